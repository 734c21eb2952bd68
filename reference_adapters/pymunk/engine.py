"""Pymunk (Chipmunk): a 2D engine with fixed steps, that sees the table from above.

A contact is seen when a step ends in overlap: late by up to a step, after the balls have passed the
point of contact, which makes cut shots come out too thin. `mode="native"` is that: what a user of
Pymunk gets. `mode="landed"` ends the steps where balls touch, so that only the solver's own error
remains. `config="tuned"` is the best use of Pymunk that experiments found, `config="default"` what
a newcomer types.
"""

from __future__ import annotations

import importlib.util
from typing import TYPE_CHECKING, Any, ClassVar

from ghostball.engine import EventKind, Record, Result, Scene
from ghostball.engine.scene.features import EXACT, Capabilities, Capability, Feature
from ghostball.reference_adapters.base import (
    EngineBase,
    EngineSettings,
    lacks_sequence,
    resolution_of_step,
)
from ghostball.reference_adapters.pymunk.steppers import make_stepper
from ghostball.reference_adapters.recording import Recorder
from ghostball.reference_adapters.stepping.ending import end_of, ending_of
from ghostball.reference_adapters.stepping.landing import LANDING_GAP
from ghostball.reference_adapters.stepping.settings import SteppingSettings

if TYPE_CHECKING:
    from ghostball.reference_adapters.pymunk.world import World


class PymunkSettings(SteppingSettings):
    """Settings of the Pymunk adapter.

    `iterations` is 30 tuned, Chipmunk's 10 default; `dt` is 1e-3 s tuned, 1/60 s default as in
    Pymunk's examples, 0.02 s landed.
    """


def _none(how: str) -> Capability:
    return Capability("none", how)


_RUBS = (
    "Chipmunk's own friction along the contact, with the share of the coefficient that belongs to "
    "it; the adapter turns the balls by the share up or down, of which Chipmunk's plane knows "
    "nothing. A single impact is exact; where several meet, the share is that before them all"
)
_CLOTH_TAKES_PART = _none("the cloth takes part in this impact, and Chipmunk's plane has none")
_BETWEEN_STEPS = Capability(
    "approximate", "the adapter applies the cloth between Pymunk's steps, in closed form"
)
_MULTIPLIED = Capability(
    "approximate", "elasticities set as a newcomer does: Chipmunk multiplies those of the two"
)

_TUNED: Capabilities = {
    Feature.ROLLING: EXACT,
    Feature.SLIDING: _BETWEEN_STEPS,
    Feature.FRICTIONLESS_CLOTH: EXACT,
    Feature.VERTICAL_SPIN: _BETWEEN_STEPS,
    Feature.BALL_RESTITUTION: EXACT,
    Feature.BALL_FRICTION: Capability("approximate", _RUBS),
    Feature.SPEED_DEPENDENT_FRICTION: Capability(
        "approximate", f"the coefficient of the slip before the impact, as in the law. {_RUBS}"
    ),
    Feature.MATHAVAN_BALL: _CLOTH_TAKES_PART,
    Feature.UNEQUAL_MASSES: EXACT,
    Feature.UNEQUAL_RADII: EXACT,
    Feature.PER_BALL_FRICTION: EXACT,
    Feature.UNBOUNDED_CLOTH: EXACT,
    Feature.OPEN_SIDES: EXACT,
    Feature.MIRROR_CUSHION: EXACT,
    Feature.CUSHION_RESTITUTION: EXACT,
    Feature.CUSHION_TANGENTIAL: Capability(
        "approximate",
        "Pymunk has none: the adapter scales the velocity along the cushion after the step",
    ),
    Feature.FRICTIONAL_CUSHION: Capability("approximate", _RUBS),
    Feature.HAN_CUSHION: _none("Chipmunk's plane has no height for the nose to touch a ball at"),
    Feature.MATHAVAN_CUSHION: _CLOTH_TAKES_PART,
    Feature.AIR_DRAG: _none("Pymunk damps in proportion to speed, not to its square"),
    Feature.FLIGHT: _none("Pymunk works in a plane"),
}

_DEFAULT: Capabilities = {
    **_TUNED,
    Feature.SLIDING: _none("Pymunk's cloth is the adapter's own, of `config=tuned`"),
    Feature.VERTICAL_SPIN: _none("Pymunk's cloth is the adapter's own, of `config=tuned`"),
    Feature.BALL_FRICTION: _none("balls that don't slide have no spin to rub with"),
    Feature.SPEED_DEPENDENT_FRICTION: _none("balls that don't slide have no spin to rub with"),
    Feature.FRICTIONAL_CUSHION: _none("balls that don't slide have no spin to rub with"),
    Feature.BALL_RESTITUTION: _MULTIPLIED,
    Feature.OPEN_SIDES: Capability("approximate", "cushions end at the table's corners"),
    Feature.MIRROR_CUSHION: _MULTIPLIED,
    Feature.CUSHION_RESTITUTION: _MULTIPLIED,
    Feature.CUSHION_TANGENTIAL: _none("Pymunk has no such law; `config=tuned` adds one"),
}


class PymunkEngine(EngineBase):
    """Pymunk behind the protocol; see the module."""

    name: ClassVar[str] = "pymunk"
    Settings: ClassVar[type[EngineSettings]] = PymunkSettings

    @property
    def capabilities(self) -> Capabilities:
        """How each feature of a scene is represented with these settings."""
        return _TUNED if self.settings.config == "tuned" else _DEFAULT

    @classmethod
    def unavailable(cls) -> str | None:
        """Return how to get Pymunk where it isn't installed, or None."""
        if importlib.util.find_spec("pymunk") is not None:
            return None
        return "the package `pymunk` is not installed. Install it with: pip install 'pymunk>=7'"

    def lacks(self, scene: Scene) -> tuple[str, ...]:
        """Return a sentence for each thing in `scene` that is no `Feature` and can't be done."""
        return lacks_sequence(scene)

    def resolution(self, scene: Scene) -> float:
        """Return how far a ball goes in a step [m]; landed, how far from touching it stops."""
        if self.settings.mode == "landed":
            return LANDING_GAP
        return resolution_of_step(self.settings.step, scene)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Run to rest, to `t_max`, or to `max_time` or `max_steps`.

        Raises
        ------
        UnsupportedSceneError
            Where the scene needs a feature that these settings lack.
        """
        self.check(scene)
        # Loads pymunk, which the first run may do, but not a list of engines.
        from ghostball.reference_adapters.pymunk.world import World  # noqa: PLC0415

        settings: PymunkSettings = self.settings
        world = World(scene, tuned=settings.config == "tuned", iterations=settings.iterations)
        return _run(scene, record, settings, world)


def _run(scene: Scene, record: Record, settings: PymunkSettings, world: World) -> Result:
    t_end = end_of(scene, settings)
    stepper = make_stepper(scene, world, settings.mode, settings.step, t_end)
    recorder = Recorder(scene, record)
    steps = 0

    recorder.start()
    stepper.record(recorder)
    while not stepper.resting.all() and stepper.t < t_end and steps < settings.max_steps:
        stepper.step()
        steps += 1
        for contact in world.collisions:
            kind = EventKind.BALL_CUSHION if contact.cushion else EventKind.BALL_BALL
            recorder.event(stepper.t, kind, contact.a, contact.b)
        for changed, ball in stepper.changes:
            recorder.event(stepper.t, changed, ball)
        if stepper.keep_frame or recorder.wants_frame(stepper.t):
            stepper.record(recorder, force=stepper.keep_frame)
    state = stepper.state()
    at_rest = bool(stepper.resting.all())
    status, reason = ending_of(scene, settings, stepper.t, state, at_rest=at_rest)
    return recorder.result(
        engine=PymunkEngine.name,
        settings=_as_used(settings, world),
        status=status,
        final_state=state,
        rest_time=stepper.t,
        work={"steps": steps, "contacts_solved": world.contacts_solved},
        reason=reason,
    )


def _as_used(settings: PymunkSettings, world: World) -> dict[str, Any]:
    """Return the settings with what None stood for."""
    return settings.model_dump() | {"dt": settings.step, "iterations": world.iterations}
