"""pybullet (Bullet 3) as a reference engine: settings, capabilities, and `Scene` -> `Result`.

Two models, chosen by the scene's `motion`:

- "rolling", the paper's: Bullet in the plane, without gravity; the adapter applies the cloth
  between its steps.
- "sliding": Bullet in space, on a table under gravity; its friction ends a slide, and the adapter
  slows balls that roll.

`contact_steps` = fixed steps by `dt` and lets Bullet detect contacts, as its users do; exact steps
to each contact by the closed-form time to it and lets Bullet resolve it, which isolates its solver.

Two configurations: "tuned" sets what makes the physics right; "naive" sets what the scene states
(step, masses, radii, restitution, friction) and leaves all else to pybullet.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from ghostball.model import Record, Result, Scene
from ghostball.model.features import Capabilities
from ghostball.reference_adapters.base import EngineSettings, lacking_sequence
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.pybullet import loading
from ghostball.reference_adapters.stepping.ending import end_of
from ghostball.reference_adapters.stepping.ends import ExactSteps
from ghostball.reference_adapters.stepping.laws import largest_momenta
from ghostball.reference_adapters.stepping.plane import Stepper, run
from ghostball.reference_adapters.stepping.settings import SteppingSettings
from ghostball.reference_adapters.stepping.space import OnItsOwnCloth, SpaceEngine

SHORTEST_STEP = float(np.finfo(np.float64).eps)
"""Shortest step that Bullet makes [s]; it takes a shorter one for none, and moves nothing."""

MOST_IMPULSE = 1e10
"""Bound of Bullet's solver on the impulse of a contact in a step [N s]: more stops no ball."""


class PybulletSettings(SteppingSettings):
    """Settings of the pybullet adapter.

    `dt` is 1e-3 s tuned, pybullet's own 1/240 s naive, 0.02 s in exact steps; `iterations`
    pybullet's own 50.
    """

    NAIVE_DT: ClassVar[float] = 1.0 / 240.0
    EXACT_IF_NAIVE: ClassVar[bool] = False

    iterations: Annotated[int, Field(ge=1)] = 50


class PybulletEngine(SpaceEngine):
    """Bullet through pybullet; each run has a client of its own, emptied when it ends."""

    name: ClassVar[str] = "pybullet"
    Settings: ClassVar[type[EngineSettings]] = PybulletSettings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "pybullet")
    EXACT_STEPS: ClassVar[ExactSteps] = ExactSteps(shortest=SHORTEST_STEP)

    @property
    def capabilities(self) -> Capabilities:
        """How each feature is represented; some depend on the scene, see `lacks`."""
        exact = self.settings.contact_steps == "exact"
        return self.CAPABILITIES["exact-steps"] if exact else super().capabilities

    @classmethod
    def unavailable(cls) -> str | None:
        """Return why pybullet can't be imported here and how to get it, or None."""
        return loading.unavailable()

    def _lacking(self, scene: Scene) -> Iterator[str]:
        slides = scene.physics.motion == "sliding"
        if slides and len({ball.radius for ball in scene.balls}) > 1 and not scene.physics.airborne:
            yield (
                "no balls of different radius that slide (in space they touch along a line that "
                "isn't level, nearer than the sum of their radii in the plane)"
            )
        if slides and np.any(scene.sliding_frictions == 0.0):
            yield (
                "no sliding without friction (Bullet's rolling friction is a part of the sliding "
                "friction)"
            )
        if scene.physics.airborne and scene.table is not None and scene.table.obstacles:
            yield (
                "no pockets, polygons and posts where balls leave the cloth (here they are as high "
                "as the balls' centres, and a hole takes a ball at any height)"
            )
        # An impact's impulse is at most 2 m |v|, m the reduced mass and v the relative velocity,
        # and m v^2 / 2 at most all the energy.
        impulse = 2.0 * float(np.max(largest_momenta(scene)))
        if impulse > MOST_IMPULSE:
            yield (
                f"no impulses above {MOST_IMPULSE:g} N s (Bullet's solver bounds them in each "
                f"step; the energy of these balls could need {impulse:.3g} N s)"
            )
        yield from lacking_sequence(scene)

    def own_cloth(self, scene: Scene) -> bool:
        """Whether balls lie on a plane of Bullet's: all that may slide do."""
        return scene.physics.motion == "sliding"

    def on_cloth(self, scene: Scene, world: Any) -> Stepper:
        """Return what moves balls on that may slide; naive, Bullet slows those that roll."""
        t_end, tuned = end_of(scene, self.settings), self.settings.config == "tuned"
        return OnItsOwnCloth(scene, world, self.step(scene), t_end, slows=tuned)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Run the scene; see `ReferenceEngine.simulate`."""
        self.check(scene)
        world: Any = self.world(scene)
        with world:
            return run(scene, record, self.name, self.settings, world, self.stepper(scene, world))
