"""pybullet (Bullet 3) as a reference engine: settings, capabilities, and `Scene` -> `Result`.

Two models, chosen by the scene's `motion`:

- "rolling", the paper's: Bullet in the plane, without gravity; see `pybullet.rolling`.
- "sliding": Bullet in space, on a table under gravity; see `pybullet.sliding`.

`contact_steps` = fixed steps by `dt` and lets Bullet detect contacts, as its users do; exact steps
to each contact by the closed-form time to it and lets Bullet resolve it, which isolates its solver.

Two configurations: "tuned" sets what makes the physics right; "default" sets what the scene states
(step, masses, radii, restitution, friction) and leaves all else to pybullet.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from ghostball.model import Record, Result, Scene
from ghostball.model.features import EXACT, Capabilities, Capability, Feature
from ghostball.reference_adapters.base import (
    EngineBase,
    EngineSettings,
    lacking_sequence,
    none,
    resolution_of_step,
)
from ghostball.reference_adapters.pybullet import loading
from ghostball.reference_adapters.pybullet.rolling import PlanarRun
from ghostball.reference_adapters.pybullet.sliding import SlidingRun
from ghostball.reference_adapters.pybullet.world import MOST_IMPULSE, SHORTEST_STEP, World
from ghostball.reference_adapters.recording import Recorder
from ghostball.reference_adapters.stepping import contact_time
from ghostball.reference_adapters.stepping.contact_time import CONTACT_GAP
from ghostball.reference_adapters.stepping.ending import end_of, ending_of
from ghostball.reference_adapters.stepping.laws import largest_momenta
from ghostball.reference_adapters.stepping.plane_engine import pocketed
from ghostball.reference_adapters.stepping.settings import SteppingSettings
from ghostball.reference_adapters.stepping.space import slowest_bounce

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

_DEFAULT: Capabilities = {
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
"""With `config` = default; see `pybullet.world.World`."""

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


class PybulletSettings(SteppingSettings):
    """Settings of the pybullet adapter.

    `dt` is 1e-3 s tuned, pybullet's own 1/240 s default, 0.02 s in exact steps; `iterations`
    pybullet's own 50.

    `rest_speed` [m/s]: in sliding scenes, the speed of centre and surface below which a ball rests.
    Bullet's friction leaves about 1e-11 m/s; at 1e-6 m/s a ball on mu = 0.01 has 5e-12 m to go. In
    rolling scenes a ball rests at exactly 0.
    """

    DEFAULT_DT: ClassVar[float] = 1.0 / 240.0
    CLOTH_BETWEEN_STEPS: ClassVar[bool] = False
    EXACT_BY_DEFAULT: ClassVar[bool] = False

    iterations: Annotated[int, Field(ge=1)] = 50
    rest_speed: Annotated[float, Field(gt=0.0)] = 1e-6


class PybulletEngine(EngineBase):
    """Bullet through pybullet; each run has a client of its own, closed when it ends."""

    name: ClassVar[str] = "pybullet"
    Settings: ClassVar[type[EngineSettings]] = PybulletSettings

    @property
    def capabilities(self) -> Capabilities:
        """How each feature is represented; some depend on the scene, see `lacks`."""
        if self.settings.config == "default":
            return _DEFAULT
        if self.settings.contact_steps == "fixed":
            return CAPABILITIES
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

    def resolution(self, scene: Scene) -> float:
        """Return how far a ball goes in a step [m]; or how far from a contact its step ends."""
        if self.settings.contact_steps == "exact":
            shortest = resolution_of_step(SHORTEST_STEP, scene)
            return max(CONTACT_GAP, shortest)
        return resolution_of_step(self.settings.step, scene)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Run the scene; see `ReferenceEngine.simulate`.

        A rolling ball rests when its velocity is exactly 0; for a sliding one see `rest_speed`.
        """
        self.check(scene)
        settings: PybulletSettings = self.settings
        dt = settings.step
        t_end = end_of(scene, settings)
        planar = scene.physics.motion == "rolling"
        recorder = Recorder(scene, record)
        falls = slowest_bounce(scene, dt) if scene.physics.airborne else 0.0
        with World(
            scene,
            planar=planar,
            config=settings.config,
            iterations=settings.iterations,
            slow=falls,
        ) as world:
            if settings.contact_steps == "exact":
                contact_time.warm_up()
            recorder.start()
            run: PlanarRun | SlidingRun
            if planar:
                run = PlanarRun(world, scene, recorder)
                run.run(settings.contact_steps, dt, t_end, settings.max_steps)
            else:
                gated = settings.config == "tuned"
                run = SlidingRun(
                    world, scene, recorder, dt=dt, gated=gated, rest_speed=settings.rest_speed
                )
                run.run(t_end, settings.max_steps)
            final_state = run.state()
            status, reason = ending_of(scene, settings, run.t, final_state, at_rest=run.at_rest)
            return recorder.result(
                engine=self.name,
                settings=settings.model_dump() | {"dt": dt},
                status=status,
                final_state=final_state,
                rest_time=run.rest_time if run.at_rest else run.t,
                work=run.work,
                reason=reason,
            )
