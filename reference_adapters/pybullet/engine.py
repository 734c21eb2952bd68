"""pybullet (Bullet 3) as a reference engine: settings, capabilities, and `Scene` -> `Result`.

Two models, chosen by the scene's `motion`:

- "rolling", the paper's: Bullet in the plane, without gravity; see `pybullet.rolling`.
- "sliding": Bullet in space, on a table under gravity; see `pybullet.sliding`.

`contact_steps` = fixed steps by `dt` and lets Bullet detect contacts, as its users do; exact steps
to each contact by the closed-form time to it and lets Bullet resolve it, which isolates its solver.

Two configurations: "tuned" sets what makes the physics right; "naive" sets what the scene states
(step, masses, radii, restitution, friction) and leaves all else to pybullet.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from ghostball.model import Record, Result, Scene
from ghostball.model.features import EXACT, Capabilities, Capability, Feature
from ghostball.reference_adapters.base import EngineSettings, lacking_sequence, none
from ghostball.reference_adapters.pybullet import loading
from ghostball.reference_adapters.pybullet.rolling import Rolling
from ghostball.reference_adapters.pybullet.settings import (
    MOST_IMPULSE,
    SHORTEST_STEP,
    PybulletSettings,
)
from ghostball.reference_adapters.pybullet.sliding import Sliding
from ghostball.reference_adapters.stepping.ending import end_of
from ghostball.reference_adapters.stepping.ends import Ends, ExactSteps
from ghostball.reference_adapters.stepping.laws import largest_momenta
from ghostball.reference_adapters.stepping.plane import Stepper, run
from ghostball.reference_adapters.stepping.plane_engine import pocketed
from ghostball.reference_adapters.stepping.space import SpaceEngine

_ROLLING = Capability(
    "exact",
    "planar, without gravity; mu g is applied around Bullet's steps, in closed form between them",
)
_FLAT_CUSHION = none("Bullet's cushion is a vertical plane: it has no nose above the ball's centre")
_PARTS = Capability(
    "approximate",
    "lines and spheres at the height of the balls' centres: right for balls that roll, in the "
    "plane; one that slides, and that friction has lifted, meets them lower, and is lifted a "
    "little more; a ball that goes farther than its radius in a step can pass through a line",
)
_LIFTED = (
    "in space: a ball that friction lifts bounces, and has no cloth until it lands; one that it "
    "pushes down is rubbed by the cloth, and slowed as it rolls, in the same instant"
)

CAPABILITIES: Capabilities = {
    Feature.ROLLING: _ROLLING,
    Feature.SLIDING: Capability("exact", "in space, on a table; Bullet's own Coulomb friction"),
    Feature.FRICTIONLESS_CLOTH: EXACT,
    Feature.VERTICAL_SPIN: Capability("exact", "Bullet's spinning friction as a length"),
    Feature.BALL_RESTITUTION: EXACT,
    Feature.BALL_FRICTION: Capability(
        "approximate",
        f"{_LIFTED}. An impact without follow or draw is exact; a rolling one, or one with as much "
        "draw, changes the balls' velocities once they roll by up to 0.5 % of the cue ball's speed "
        "with mu = 0.05, and 5 % with 0.2",
    ),
    Feature.SPEED_DEPENDENT_FRICTION: none(
        "Bullet's friction is one number for two bodies, whatever their slip"
    ),
    Feature.MATHAVAN_BALL: Capability(
        "approximate",
        "Bullet solves the friction of balls and cloth together, as the law does, but with one "
        "direction of each slip for the whole impact; and a ball that it lifts bounces. On "
        "Mathavan's own tables within 0.1 % of the speeds and 0.05 degrees",
    ),
    Feature.UNEQUAL_MASSES: EXACT,
    Feature.UNEQUAL_RADII: Capability("exact", "where balls roll: planar, centres at one height"),
    Feature.PER_BALL_FRICTION: Capability(
        "exact", "where they slide by different coefficients, each ball has a table of its own"
    ),
    Feature.UNBOUNDED_CLOTH: EXACT,
    Feature.OPEN_SIDES: EXACT,
    Feature.POLYGON: _PARTS,
    Feature.POCKETS: pocketed(_PARTS),
    Feature.POSTS: _PARTS,
    Feature.MIRROR_CUSHION: EXACT,
    Feature.CUSHION_RESTITUTION: EXACT,
    Feature.FALLING_RESTITUTION: none("Bullet's restitution is one number at any speed"),
    Feature.CUSHION_TANGENTIAL: none("along a contact Bullet has Coulomb friction, no restitution"),
    Feature.FRICTIONAL_CUSHION: Capability(
        "approximate",
        f"{_LIFTED}. A ball that rolls or doesn't turn leaves as the law says; its bounce takes it "
        "a few millimetres farther; one with as much backspin differs, once it rolls, by up to 4 % "
        "of its speed with mu = 0.2, and 9 % with 0.4",
    ),
    Feature.HAN_CUSHION: _FLAT_CUSHION,
    Feature.MATHAVAN_CUSHION: _FLAT_CUSHION,
    Feature.AIR_DRAG: none("Bullet's damping, k (1 + |v|) v, can't be quadratic alone"),
    Feature.QUADRATIC_ROLLING: none("Bullet's rolling friction is one torque, whatever the speed"),
    Feature.FLIGHT: Capability(
        "approximate",
        "in space, with the table's restitution and cushions that are thin lines; a landing is "
        "seen up to a step late, and what falls at less than (1 + 1 / (1 - e)) g dt doesn't "
        "bounce: balls that lie on the table would tremble",
    ),
}

_DAMPED = (
    "pybullet's own damping, 0.04 (1 + |v|) v a second; impacts below 0.2 m/s are inelastic, "
    "others gain some per cent of energy as overlapping balls are pushed apart"
)
_STOPPED_SHORT = Capability(
    "approximate",
    "pybullet stops a ball at the cushion in the step before it gets there: what it has left of "
    "the step is taken from its restitution",
)

_NAIVE: Capabilities = {
    **CAPABILITIES,
    Feature.ROLLING: Capability("approximate", _DAMPED),
    Feature.SLIDING: Capability(
        "approximate",
        f"{_DAMPED}; rolling friction also acts while a ball slides; no spin exceeds 100 rad/s",
    ),
    Feature.FRICTIONLESS_CLOTH: Capability("approximate", _DAMPED),
    Feature.VERTICAL_SPIN: Capability(
        "approximate",
        "pybullet's own damping of spin, 0.04 (1 + |w|) w a second: at 50 rad/s ten times what the "
        "cloth takes",
    ),
    Feature.MIRROR_CUSHION: _STOPPED_SHORT,
    Feature.CUSHION_RESTITUTION: _STOPPED_SHORT,
}
"""With `config` = naive; see `pybullet.world.World`."""

_OF_SLIDING = (
    Feature.SLIDING,
    Feature.VERTICAL_SPIN,
    Feature.BALL_FRICTION,
    Feature.MATHAVAN_BALL,
    Feature.FRICTIONAL_CUSHION,
    Feature.FLIGHT,
)
"""What only balls that may slide have."""

_NO_EXACT_STEPS = none("Bullet's table contact needs steady steps. Use `contact_steps` = fixed")


class PybulletEngine(SpaceEngine):
    """Bullet through pybullet; each run has a client of its own, emptied when it ends."""

    name: ClassVar[str] = "pybullet"
    WORLD: ClassVar[str] = "ghostball.reference_adapters.pybullet.world:World"
    Settings: ClassVar[type[EngineSettings]] = PybulletSettings
    TUNED: ClassVar[Capabilities] = CAPABILITIES
    NAIVE: ClassVar[Capabilities] = _NAIVE
    EXACT_STEPS: ClassVar[ExactSteps] = ExactSteps(shortest=SHORTEST_STEP)

    @property
    def capabilities(self) -> Capabilities:
        """How each feature is represented; some depend on the scene, see `lacks`."""
        if self.settings.contact_steps == "fixed":
            return super().capabilities
        return {**CAPABILITIES, **dict.fromkeys(_OF_SLIDING, _NO_EXACT_STEPS)}

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

    def in_plane(self, scene: Scene, world: Any, ends: Ends) -> Stepper:
        """Return what moves balls on that roll, in the plane."""
        return Rolling(scene, world, ends)

    def on_cloth(self, scene: Scene, world: Any) -> Stepper:
        """Return what moves balls on that may slide, on a plane under gravity."""
        return Sliding(scene, world, self.settings, end_of(scene, self.settings))

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Run the scene; see `ReferenceEngine.simulate`.

        A rolling ball rests when its velocity is exactly 0; for a sliding one see `rest_speed`.
        """
        self.check(scene)
        world: Any = self.world(scene)
        with world:
            return run(scene, record, self.name, self.settings, world, self.stepper(scene, world))
