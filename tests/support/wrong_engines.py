"""A table of engines with one fault each, and of some right engines.

Every command must give the same verdict on each engine; see `tests/ghostball/test_one_verdict.py`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import wrong_physics as physics
import wrong_runs as runs

from ghostball.model import (
    COLLISION_KINDS,
    EVENT_DTYPE,
    EventKind,
    Record,
    Result,
    SampledTrajectory,
    Samples,
    Scene,
    Status,
    rolling_angular_velocity,
)
from ghostball.model.features import EXACT, Capabilities, Feature
from ghostball.reference_adapters import EngineBase, EngineSettings
from ghostball.reference_adapters.base import resolution_of_step
from ghostball.validation.examples.stepper import Stepper

CUT, BOUNCE, HEAD_ON = "half-ball-cut", "wall-bounce", "restitution-head-on"
SLIDING, BREAK, FROZEN, FLIGHT = "draw-shot", "break-7", "frozen-triangle", "flight-lands"


@dataclass(frozen=True)
class Row:
    """One engine of the table.

    `fault`: the fault in one sentence; "" for a right engine.
    `play`: function that simulates a scene; None if `label` names an engine outside this table.
    `scenes`: shipped scenes in which the fault has an effect.
    `states`: the declared `resolution` [m]; None if the engine declares nothing.
    `step`: the declared time step [s], in place of a resolution.
    `status`: exit status of every command.
    `label`: label of the engine; "" for an engine of this table.
    """

    fault: str
    play: runs.Play | None
    scenes: tuple[str, ...]
    states: float | None = 0.0
    step: float | None = None
    status: int = 1
    label: str = ""


def _stepper(dt: float) -> runs.Play:
    """Return a function that simulates in time steps [s] and detects contacts after each step."""
    engine = Stepper(Stepper.Settings(dt=dt))
    return lambda scene: engine.simulate(scene, record="trajectory")


def by_formula(scene: Scene) -> Result:
    """Simulate one ball that rolls to rest without collisions, by a formula."""
    x, v = scene.positions, scene.velocities
    slowing = scene.physics.gravity * scene.physics.rolling_friction
    ends = float(np.linalg.norm(v)) / slowing
    t = np.linspace(0.0, ends, 401)[:, np.newaxis, np.newaxis]
    positions, velocities = x + v * (t - t**2 / (2.0 * ends)), v * (1.0 - t / ends)
    spins = np.array([rolling_angular_velocity(one, scene.radii) for one in velocities])
    return Result(
        engine="",
        settings={},
        scene=scene,
        status=Status.REST,
        final_state=Samples(positions[-1:], velocities[-1:], spins[-1:]),
        rest_time=ends,
        collision_counts={"ball-ball": 0, "ball-cushion": 0},
        work={},
        wall_time=0.0,
        events=np.array([(ends, EventKind.ROLL_TO_REST, 0, -1)], dtype=EVENT_DTYPE),
        trajectory=SampledTrajectory(t[:, 0, 0], positions, velocities, spins),
    )


WRONG: Mapping[str, Row] = {
    # Events, times, counts.
    "late-collisions": Row(
        "Each collision is reported 50 ms late.", runs.late(0.05, *COLLISION_KINDS), (CUT,)
    ),
    "late-collisions-exact": Row(
        "Each collision is reported 50 ms late; it claims to be exact without a resolution.",
        runs.late(0.05, *COLLISION_KINDS),
        (BOUNCE,),
        states=None,
    ),
    "late-events": Row("Each event is reported 1 us late.", runs.late(1e-6), (CUT,)),
    "late-rest": Row("The rest time is 0.5 s too long.", runs.rests_late(0.5), (CUT,)),
    "milliseconds": Row("Times are in milliseconds.", runs.in_milliseconds, (CUT,)),
    "waits": Row("The shot starts 10 ms late.", runs.waits, (CUT,)),
    "missing-event": Row("A collision is missing.", runs.without_first_collision, (CUT,)),
    "doubled-event": Row("A collision is reported twice.", runs.first_collision_twice, (CUT,)),
    "no-events": Row("No collision is reported.", runs.without_collisions, (CUT,)),
    "wrong-cushion": Row("A bounce names another cushion.", runs.with_another_cushion, (BOUNCE,)),
    "wrong-ball": Row(
        "A collision names another ball.", runs.with_another_ball, ("three-ball-chain",)
    ),
    "swapped-events": Row(
        "Two collisions come in the wrong order.",
        runs.with_swapped_collisions,
        ("three-ball-chain",),
    ),
    "wrong-counts": Row(
        "The counts differ from the number of events.", runs.with_another_count, (CUT,)
    ),
    # Final positions.
    "swapped-ends": Row(
        "The rest positions of two balls are swapped.", runs.ends_moved(runs.swapped), (CUT,)
    ),
    "moved-ends": Row(
        "The rest positions are 0.1 mm off, the samples are right.",
        runs.ends_moved(runs.along_x(1e-4)),
        (CUT,),
    ),
    "mirrored-ends": Row(
        "The rest positions are mirrored.", runs.ends_moved(runs.mirrored), (CUT,)
    ),
    "half-a-micrometre": Row("Balls rest 500 nm off.", runs.drifting(5e-7), (CUT,)),
    "mirrored-table": Row("Left and right are swapped.", runs.mirrored_table, (BOUNCE,)),
    "asleep": Row("Balls stop when they are slower than 5 cm/s.", runs.falls_asleep, ("stop",)),
    "ends-early": Row("The run ends after half its time.", runs.ends_early, (CUT,)),
    "stops-late": Row("All balls stop dead at 60 % of the shot.", runs.stops_late, (BREAK,)),
    "stops-past-the-proof": Row(
        "All balls stop dead at 60 % of a shot; only its start is proved.",
        runs.stops_late,
        (FROZEN,),
    ),
    "stops-past-the-proof-of-a-step": Row(
        "The same; the declared step is 1 ms.", runs.stops_late, (FROZEN,), step=1e-3
    ),
    "stops-at-once-of-a-step": Row(
        "All balls stop dead after 20 ms; the declared step is 1 ms.",
        runs.stops_at_once,
        (BREAK,),
        step=1e-3,
    ),
    "moves-at-rest": Row("A ball still moves when all rest.", runs.moves_at_rest, ("stop",)),
    "lazy": Row(
        "Nothing moves, and the engine declares no accuracy.",
        None,
        (CUT,),
        states=None,
        label="silent_engine:lazy",
    ),
    "no-motion": Row("Nothing moves.", runs.without_motion, (CUT,)),
    # The motion between events.
    "slow-samples": Row(
        "Sampled velocities are up to 30 % too low halfway.", runs.slow_in_the_middle, (CUT,)
    ),
    "straight-samples": Row(
        "Sampled positions are linear between events.", runs.straight_between_events, (CUT,)
    ),
    "jump": Row("A ball jumps 1 mm aside halfway.", runs.jumps, ("stop",)),
    "kinematics": Row(
        "A rolling ball slows down unevenly; rest position and rest time are right.",
        runs.slows_unevenly,
        ("stop",),
    ),
    "drift": Row("Energy rises by 0.01 % from start to end.", runs.gains_slowly, ("galperin-1",)),
    "overlap": Row("Balls overlap by 5.7 mm for a moment.", runs.overlaps, (CUT,)),
    "not-finite": Row("A velocity is NaN.", runs.not_finite, (CUT,)),
    "single-precision": Row(
        "Positions are rounded to single precision.", runs.in_single_precision, (CUT,)
    ),
    # Wrong physics.
    "energy": Row(
        "The first collision of balls gains 5 % of energy.",
        physics.makes_energy(0.05, only_once=True),
        (HEAD_ON,),
    ),
    "energy-at-hits": Row(
        "Each collision of balls gains 2 % of energy.", physics.makes_energy(0.02), (HEAD_ON,)
    ),
    "friction": Row(
        "Rolling friction is 5/7 of the right value.",
        physics.with_physics(rolling_friction=lambda friction: 5.0 / 7.0 * friction),
        ("stop",),
    ),
    "sliding": Row(
        "Sliding friction is 10 % too high.",
        physics.with_physics(sliding_friction=lambda friction: 1.1 * friction),
        (SLIDING,),
    ),
    "gravity": Row(
        "Gravity is 9.8 m/s^2, not 9.81.", physics.with_physics(gravity=lambda _: 9.8), ("stop",)
    ),
    "restitution": Row(
        "The restitution of balls is squared.",
        physics.with_physics(ball_restitution=lambda e: e**2),
        (HEAD_ON,),
    ),
    "elastic-cushion": Row(
        "Cushions keep all energy.",
        physics.with_physics(cushion_restitution=lambda _: 1.0),
        ("restitution-bounce",),
    ),
    "no-throw": Row(
        "Balls have no friction between them.",
        physics.with_physics(ball_friction=lambda _: 0.0),
        ("throw-slip",),
    ),
    "cushion-angle": Row(
        "A cushion throws a ball back 0.5 degrees off.",
        physics.at_each(EventKind.BALL_CUSHION, physics.turned(np.radians(0.5))),
        (BOUNCE,),
    ),
    "lost-spin": Row(
        "Balls lose their spin when they collide.",
        physics.at_each(EventKind.BALL_BALL, physics.scaled(1.0, 0.0)),
        (SLIDING,),
    ),
    "mass": Row(
        "A ball is 1 % too heavy.",
        physics.with_balls(mass=lambda mass: 1.01 * mass),
        ("galperin-1",),
    ),
    "radius": Row(
        "A ball is 0.1 % too large.",
        physics.with_balls(radius=lambda radius: 1.001 * radius),
        (CUT,),
    ),
    # Contacts and steps.
    "missed-collision": Row("Balls pass through each other.", physics.passes_through, (CUT,)),
    "late-collision": Row(
        "Balls collide when they overlap by 0.5 mm.", physics.sees_late(5e-4), (CUT,)
    ),
    "smaller-step": Row(
        "The step is 5 ms, the declared step 0.1 ms.", _stepper(5e-3), (CUT,), step=1e-4
    ),
    "exact-steps": Row("The step is 1 ms; the engine claims to be exact.", _stepper(1e-3), (CUT,)),
    "friction-of-a-step": Row(
        "Rolling friction is 5/7 of the right value; the declared step is 1 ms.",
        physics.with_physics(rolling_friction=lambda friction: 5.0 / 7.0 * friction),
        ("stop",),
        step=1e-3,
    ),
    "gravity-of-a-step": Row(
        "Gravity is 8.8 m/s^2 in flight, not 9.81; the declared step is 1 ms.",
        physics.with_physics(gravity=lambda _: 8.8),
        (FLIGHT,),
        step=1e-3,
    ),
    "late-collisions-of-a-step": Row(
        "Each collision is reported 50 ms late; the declared step is 1 ms.",
        runs.late(0.05, *COLLISION_KINDS),
        (CUT,),
        step=1e-3,
    ),
    "late-rest-of-a-step": Row(
        "The rest time is 0.5 s too long; the declared step is 1 ms.",
        runs.rests_late(0.5),
        (CUT,),
        step=1e-3,
    ),
    "late-rests-of-a-step": Row(
        "All balls but the last are reported to rest 0.2 s late; the declared step is 1 ms.",
        runs.rests_late_but_the_last(0.2),
        (CUT,),
        step=1e-3,
    ),
    "second-rests-of-a-step": Row(
        "A resting ball is reported to rest again at the end; the declared step is 1 ms.",
        runs.rests_again,
        (CUT,),
        step=1e-3,
    ),
    "late-slides-of-a-step": Row(
        "Each slide is reported to end 0.1 s late; the declared step is 0.1 ms.",
        runs.late(0.1, EventKind.SLIDE_TO_ROLL),
        (SLIDING,),
        step=1e-4,
    ),
    "slow-samples-of-a-step": Row(
        "Sampled velocities are up to 30 % too low halfway; the declared step is 1 ms.",
        runs.slow_in_the_middle,
        (CUT,),
        step=1e-3,
    ),
    "energy-at-hits-of-a-step": Row(
        "Each collision of balls gains 2 % of energy; the declared step is 1 ms.",
        physics.makes_energy(0.02),
        (HEAD_ON,),
        step=1e-3,
    ),
    "nondeterministic": Row("Each run has a different stroke.", physics.nondeterministic, (CUT,)),
}
"""Engines that every command must fail."""

UNJUDGED: Mapping[str, Row] = {
    "huge-resolution": Row(
        "Rest positions are 1.11 m off; the declared resolution is 10 m.",
        runs.drifting(1.11),
        (CUT,),
        states=10.0,
        status=4,
    ),
    "huge-step": Row(
        "Rolling friction is 5/7 of the right value; the declared step is 10 s.",
        physics.with_physics(rolling_friction=lambda friction: 5.0 / 7.0 * friction),
        ("catch-up",),
        step=10.0,
        status=4,
    ),
    "braked": Row(
        "Balls roll half as far, and the engine declares no accuracy.",
        None,
        (CUT,),
        states=None,
        status=4,
        label="silent_engine:braked",
    ),
}
"""Engines that declare too little to be judged; no command passes them."""

RIGHT: Mapping[str, Row] = {
    "right": Row("", runs.right, (CUT, SLIDING, "restitution-bounce"), status=0),
    "rounded-once": Row("", runs.rounded_once, (CUT, HEAD_ON), status=0),
    "formula": Row("", by_formula, ("stop",), status=0),
    "honest-steps": Row("", _stepper(1e-3), (CUT, BOUNCE), step=1e-3, status=0),
    "ours": Row("", None, (CUT, SLIDING, "throw-slip"), status=0, label="ghostball"),
    "proved": Row("", None, (CUT, SLIDING), status=0, label="certified"),
    "pymunk": Row("", None, (CUT, SLIDING, HEAD_ON), status=0, label="pymunk:dt=1e-3"),
    "in-time": Row(
        "", None, (CUT, "restitution-bounce"), status=0, label="pymunk:contact_steps=exact"
    ),
}
"""Engines that every command must pass."""

CRASHES: Mapping[str, Row] = {
    "crash": Row("The engine exits its process.", physics.crashes, (CUT,)),
    "hang": Row("The engine never returns.", physics.hangs, (CUT,)),
}
"""Engines that need their own process."""

ROWS: Mapping[str, Row] = {**WRONG, **UNJUDGED, **RIGHT, **CRASHES}


class WrongSettings(EngineSettings):
    """The fault: a name in `ROWS`."""

    way: str = "right"


class Wrong(EngineBase):
    """An engine of the table, which claims that all its features are exact."""

    name: ClassVar[str] = "wrong"
    Settings: ClassVar[type[EngineSettings]] = WrongSettings
    capabilities: ClassVar[Capabilities] = dict.fromkeys(Feature, EXACT)

    @property
    def row(self) -> Row:
        """The row of the table."""
        return ROWS[self.settings.way]

    def resolution(self, scene: Scene) -> float | None:
        """Return the resolution that the row declares [m]."""
        step = self.row.step
        return self.row.states if step is None else resolution_of_step(step, scene)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Simulate the scene with the fault."""
        self.check(scene)
        assert self.row.play is not None
        result = self.row.play(scene)
        kept: dict[str, Any] = {"engine": self.name, "settings": {}, "scene": scene}
        if record == "rest":
            kept["events"] = None
        if record != "trajectory":
            kept["trajectory"] = None
        return replace(result, **kept)
