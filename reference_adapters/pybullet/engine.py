"""pybullet (Bullet 3) as a reference engine: settings, capabilities, and `Scene` -> `Result`.

The scene's `motion` selects one of two models:

- "rolling", the paper's model: Bullet in the plane, without gravity; the adapter applies cloth
  friction between the time steps.
- "sliding": Bullet in 3D, on a table under gravity; its friction ends a slide, and the adapter
  slows rolling balls.

`contact_steps` = fixed uses time steps of `dt` and Bullet's contact detection, as Bullet's users
do. With exact, steps end at the contact times computed in closed form, and Bullet resolves the
contacts, so that only the error of its solver remains.

Two configurations: "tuned" has settings for accurate physics; "naive" sets the values of the scene
(time step, masses, radii, restitution, friction) and leaves everything else at pybullet's defaults.
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
from ghostball.reference_adapters.stepping.laws import largest_momenta
from ghostball.reference_adapters.stepping.plane import WorldStepper
from ghostball.reference_adapters.stepping.run_end import end_of, run
from ghostball.reference_adapters.stepping.settings import OwnClothSettings
from ghostball.reference_adapters.stepping.space import OwnClothStepper, SpaceEngine
from ghostball.reference_adapters.stepping.step_ends import ExactSteps

SHORTEST_STEP = float(np.finfo(np.float64).eps)
"""Shortest step of Bullet [s]; it treats a shorter step as 0 and moves nothing."""

MAX_IMPULSE = 1e10
"""Limit of Bullet's solver on the impulse of a contact per step [N s]."""


class PybulletSettings(OwnClothSettings):
    """Settings of the pybullet adapter.

    `cloth`: where balls slide, Bullet has the sliding friction. With "closed-form", the adapter
        slows rolling and spinning balls between the steps. With "own", Bullet's rolling and
        spinning friction do.

    `dt`: 1e-3 s tuned; 1/240 s naive, pybullet's default; 0.02 s with exact steps.
    `iterations`: 50, pybullet's default.
    """

    NAIVE_DT: ClassVar[float] = 1.0 / 240.0
    EXACT_IF_NAIVE: ClassVar[bool] = False

    iterations: Annotated[int, Field(ge=1)] = 50

    @property
    def bullet_slows(self) -> bool:
        """Whether Bullet applies rolling and spinning friction, instead of the adapter."""
        return self.config == "naive" or self.cloth == "own"


class PybulletEngine(SpaceEngine):
    """Bullet through pybullet; each run has its own client, which is emptied at the end."""

    name: ClassVar[str] = "pybullet"
    WORLD: ClassVar[str] = "PybulletWorld"
    Settings: ClassVar[type[EngineSettings]] = PybulletSettings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "pybullet")
    EXACT_STEPS: ClassVar[ExactSteps] = ExactSteps(shortest=SHORTEST_STEP)

    @property
    def capabilities(self) -> Capabilities:
        """How each feature is supported; some depend on the scene, see `lacks`."""
        exact = self.settings.contact_steps == "exact"
        return self.CAPABILITIES["exact-steps"] if exact else super().capabilities

    @classmethod
    def unavailable(cls) -> str | None:
        """Return why pybullet can't be imported here and how to install it, or None."""
        return loading.unavailable()

    def _lacking(self, scene: Scene) -> Iterator[str]:
        slides = scene.physics.motion == "sliding"
        if slides and len({ball.radius for ball in scene.balls}) > 1 and not scene.physics.airborne:
            yield (
                "no balls of different radii that slide (in 3D their contact normal isn't "
                "horizontal, and they touch below the sum of their radii in the plane)"
            )
        if slides and np.any(scene.sliding_frictions == 0.0):
            yield (
                "no sliding without friction (Bullet's rolling friction is a fraction of the "
                "sliding friction)"
            )
        if scene.physics.airborne and scene.table is not None and scene.table.obstacles:
            yield (
                "no pockets, polygons and posts in scenes with airborne balls (here they have the "
                "height of the balls' centres, and a hole takes a ball at any height)"
            )
        # The impulse of an impact is at most 2 m |v|, with the reduced mass m and the relative
        # velocity v, and m v^2 / 2 is at most all the energy.
        impulse = 2.0 * float(np.max(largest_momenta(scene)))
        if impulse > MAX_IMPULSE:
            yield (
                f"no impulses above {MAX_IMPULSE:g} N s (Bullet's solver limits them in each "
                f"step; the energy in this scene could require {impulse:.3g} N s)"
            )
        yield from lacking_sequence(scene)

    def own_cloth(self, scene: Scene) -> bool:
        """Return whether balls lie on a plane of Bullet: in all scenes with sliding."""
        return scene.physics.motion == "sliding"

    def on_cloth(self, scene: Scene, world: Any) -> WorldStepper:
        """Return the stepper of balls that may slide."""
        t_end, slows = end_of(scene, self.settings), not self.settings.bullet_slows
        return OwnClothStepper(scene, world, self.step(scene), t_end, slows=slows)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Simulate the scene; see `ReferenceEngine.simulate`."""
        self.check(scene)
        world: Any = self.world(scene)
        with world:
            return run(scene, record, self.name, self.settings, world, self.stepper(scene, world))
