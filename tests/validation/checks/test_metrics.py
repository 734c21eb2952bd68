"""Metrics of runs that are made by hand; each test derives the expected value."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import ghostball.validation.checks.motion_metrics
import ghostball.validation.checks.outcome_metrics
from ghostball.engine import simulate
from ghostball.model import (
    EVENT_DTYPE,
    Ball,
    EventKind,
    Physics,
    Result,
    SampledTrajectory,
    Samples,
    Scene,
    Status,
    Table,
)
from ghostball.validation.checks.energy_curve import conserves_energy
from ghostball.validation.checks.metrics import METRICS, MetricError, choose_metrics, measure
from ghostball.validation.runs.sampling import energy_at
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.scene_truth import Truth, truth_of

R, M = 0.03, 0.2
BB, BC = int(EventKind.BALL_BALL), int(EventKind.BALL_CUSHION)
PARTS = frozenset({"rest", "time", "events", "energy", "conditioning"})


def scene(*, friction: float = 0.02, balls: int = 2, speed: float = 1.0, **physics: Any) -> Scene:
    return Scene(
        name="made-by-hand",
        t_max=2.0,
        physics=Physics(rolling_friction=friction, **physics),
        balls=[
            Ball(id=f"{i}", position=(float(i), 0.0), velocity=(speed, 0.0), radius=R, mass=M)
            for i in range(balls)
        ],
    )


def result(
    shot: Scene,
    xs: Sequence[Sequence[float]],
    speeds: Sequence[float],
    *,
    times: Sequence[float] = (0.0, 1.0, 2.0),
    events: Sequence[tuple[float, int, int, int]] = (),
    status: Status = Status.REST,
    rest_time: float = 2.0,
) -> Result:
    """Return balls that roll along x: at frame k, ball i is at `xs[k][i]`, with `speeds[k]`."""
    positions = np.zeros((len(times), len(shot.balls), 3))
    positions[:, :, 0] = xs
    positions[:, :, 2] = R
    velocities = np.zeros_like(positions)
    velocities[:, :, 0] = np.array(speeds)[:, None]
    spins = np.zeros_like(positions)
    spins[:, :, 1] = velocities[:, :, 0] / R
    trajectory = SampledTrajectory(np.array(times), positions, velocities, spins)
    log = np.array(list(events), dtype=EVENT_DTYPE)
    return Result(
        engine="by-hand",
        settings={},
        scene=shot,
        status=status,
        final_state=Samples(positions[-1:], velocities[-1:], spins[-1:]),
        rest_time=rest_time,
        collision_counts={
            "ball-ball": int(np.sum(log["kind"] == BB)),
            "ball-cushion": int(np.sum(log["kind"] == BC)),
        },
        work={"steps": 2},
        wall_time=0.25,
        events=log,
        trajectory=trajectory,
    )


def truth(**parts: Any) -> Truth:
    return Truth("closed form", independent=PARTS, missing="left out", **parts)


def still(shot: Scene | None = None, **options: Any) -> Result:
    shot = shot or scene()
    ends = [float(i) for i in range(len(shot.balls))]
    return result(shot, [ends, ends, ends], [1.0, 0.5, 0.0], **options)


def test_a_metric_without_a_value_says_why() -> None:
    measured = measure(still(), truth())
    for name, value in measured.values.items():
        assert (value is None) == bool(measured.notes.get(name)), name
    assert measured.values["wall_time"] == 0.25, "the engine's own"


# --- rest positions and rest time


def test_rest_errors_are_distances() -> None:
    # Ball 0 is off by (3, 4) mm, ball 1 not at all: 5 mm at most, 5 / sqrt(2) mm RMS.
    where = np.array([[0.003, 0.004, R], [1.0, 0.0, R]])
    measured = measure(still(), truth(rest_positions=where))
    assert measured.values["rest_error_max"] == pytest.approx(0.005, rel=1e-12)
    assert measured.values["rest_error_rms"] == pytest.approx(0.005 / math.sqrt(2), rel=1e-12)
    assert measured.ball_errors == pytest.approx([0.005, 0.0], rel=1e-12)


def test_the_rms_is_of_all_balls_and_no_median() -> None:
    # Balls 0 and 1 are right and ball 2 is 6 mm off: 6 / sqrt(3) mm.
    where = np.array([[0.0, 0.0, R], [1.0, 0.0, R], [2.006, 0.0, R]])
    measured = measure(still(scene(balls=3)), truth(rest_positions=where))
    assert measured.values["rest_error_rms"] == pytest.approx(0.006 / math.sqrt(3), rel=1e-12)


def test_ulps_use_the_low_part_of_the_truth_and_each_balls_conditioning() -> None:
    # Ball 0 misses by 2^-60 m with a conditioning of 2 m: 2^-60 / (2^-52 2) = 2^-9 ulp. Ball 1
    # misses by 2^-58 m with 64 m: 2^-12. Without the low part both errors would be 0.
    low = np.zeros((2, 3))
    low[0, 0], low[1, 1] = 2.0**-60, -(2.0**-58)
    where = np.array([[0.0, 0.0, R], [1.0, 0.0, R]])
    measured = measure(
        still(),
        truth(rest_positions=where, rest_positions_low=low, conditioning=np.array([2.0, 64.0])),
    )
    assert measured.values["rest_error_max"] == 2.0**-58
    assert measured.values["rest_error_ulps"] == 2.0**-9


def test_rest_time_error_and_its_ulps() -> None:
    measured = measure(
        still(), truth(rest_time=2.5, rest_time_low=-(2.0**-54), rest_time_conditioning=4.0)
    )
    assert measured.values["rest_time_error"] == pytest.approx(0.5, rel=1e-15)
    exact = measure(
        still(rest_time=2.5), truth(rest_time=2.5, rest_time_low=2.0**-54, rest_time_conditioning=4)
    )
    assert exact.values["rest_time_error"] == 2.0**-54
    assert exact.values["rest_time_error_ulps"] == 2.0**-4


def test_a_run_that_stopped_early_has_no_rest_error() -> None:
    where = np.array([[0.0, 0.0, R], [1.0, 0.0, R]])
    early = still(status=Status.STEP_LIMIT)
    measured = measure(early, truth(rest_positions=where, rest_time=2.0))
    for name in ("rest_error_max", "rest_time_error"):
        assert measured.values[name] is None
        assert "stopped early" in measured.notes[name]
    assert measured.ball_errors is None


def test_without_truth_the_note_says_why() -> None:
    measured = measure(still(), Truth(None, missing="our engine can't slide"))
    for name, metric in METRICS.items():
        if metric.compares == "certificate":
            assert measured.notes[name] == "not certified: not requested"
        elif metric.compares not in (None, "conditioning") and name != "accuracy":
            assert measured.values[name] is None
            assert measured.notes[name] == "no reference result: our engine can't slide"
    assert "closed form" in measured.notes["rest_error_ulps"]
    assert measured.values["collision_count"] == 0  # needs no truth


def test_a_motion_that_blew_up_has_no_numbers() -> None:
    shot = scene(friction=0.0)
    ends = [[0.0, 1.0], [0.0, math.nan], [0.0, math.nan]]
    where = np.array([[0.0, 0.0, R], [1.0, 0.0, R]])
    measured = measure(
        result(shot, ends, [1.0, math.inf, math.nan]),
        truth(rest_positions=where, motion=still(shot)),
    )
    for name in ("rest_error_max", "energy_drift", "energy_rise", "energy_difference_max"):
        assert measured.values[name] is None
        assert "not finite" in measured.notes[name]
        assert name in measured.incomplete
    assert measured.ball_errors is None


# --- collisions


def test_counts_and_their_errors() -> None:
    events = [
        (0.5, BB, 0, 1),
        (0.6, BC, 0, 2),
        (0.7, BC, 1, 2),
        (0.8, int(EventKind.ROLL_TO_REST), 0, -1),
    ]
    measured = measure(
        still(events=events), truth(collision_counts={"ball-ball": 3, "ball-cushion": 1})
    )
    values = measured.values
    assert (values["ball_ball_count"], values["ball_cushion_count"]) == (1, 2)
    assert values["collision_count"] == 3
    assert (values["ball_ball_count_error"], values["ball_cushion_count_error"]) == (2, 1)


A, B, C = (BB, 0, 1), (BB, 1, 2), (BC, 0, 3)


@pytest.mark.parametrize(
    ("events", "when", "note"),
    [
        ([(1.0, *A), (1.5, *B)], None, "never"),
        ([(1.0, *A), (1.4, *C)], 1.4, ""),  # a wrong collision before the true one
        ([(1.0, *A), (1.7, *C)], 1.5, ""),  # the true collision is missing
        ([(1.0, *A)], 1.5, ""),
        ([(1.0, *A), (1.5, *B), (1.8, *C)], 1.8, ""),  # an additional collision
    ],
)
def test_first_divergence(events: Any, when: float | None, note: str) -> None:
    measured = measure(
        still(scene(balls=3), events=events),
        truth(collisions=(A, B), collision_times=np.array([1.0, 1.5])),
    )
    assert measured.values["first_divergence_time"] == when
    assert note in measured.notes.get("first_divergence_time", "")


def test_an_order_without_times_has_no_instant_and_the_lower_ball_comes_first() -> None:
    measured = measure(still(events=[(1.0, BB, 1, 0)]), truth(collisions=(A, B)))
    assert measured.values["matching_events"] == 1
    assert "doesn't give its time" in measured.notes["first_divergence_time"]


# --- energy


def test_energy_differences_are_fractions_of_the_initial_energy() -> None:
    # Two balls of 0.2 kg roll at 1, 0.5, 0 m/s: 0.28, 0.07, 0 J. Truth at 1, 0.8, 0 m/s.
    true = result(scene(), [[0.0, 1.0]] * 3, [1.0, 0.8, 0.0])
    measured = measure(still(), truth(motion=true))
    assert measured.values["energy_difference_max"] == pytest.approx(0.64 - 0.25, rel=1e-12)
    assert measured.values["energy_difference_time"] == 1.0
    early = measure(still(), truth(motion=true), horizon=0.5)
    assert early.values["energy_difference_max"] == 0.0
    assert early.values["energy_difference_time"] is None
    assert "equals the reference" in early.notes["energy_difference_time"]


def test_energy_between_frames_is_interpolated_not_computed_of_blended_velocities() -> None:
    # 1 m/s before and -1 m/s after a cushion: a blend of the two has no energy at all half-way.
    shot = scene(friction=0.0, balls=1)
    bounced = result(shot, [[0], [1], [0]], [1.0, -1.0, -1.0])
    steady = result(shot, [[0], [1], [2]], [1.0, 1.0, 1.0])
    measured = measure(bounced, truth(motion=steady))
    assert measured.values["energy_difference_max"] == 0.0
    assert measured.values["energy_rise"] == 0.0
    assert energy_at(bounced, np.array([0.5])).total == pytest.approx(0.14, rel=1e-12)


def test_what_a_late_collision_still_has_is_no_error_of_the_energy() -> None:
    # The reference loses 0.75 of its energy at 0.9 s, the run in its frame at 1 s.
    shot = scene(friction=0.0)
    times, ends = (0.0, 0.5, 0.9, 1.0, 1.5, 2.0), [[0.0, 1.0]] * 6
    true = result(shot, ends, [1.0, 1.0, 0.5, 0.5, 0.5, 0.5], times=times, events=[(0.9, *A)])
    late = result(shot, ends, [1.0, 1.0, 1.0, 0.5, 0.5, 0.5], times=times, events=[(1.0, *A)])
    assert measure(late, truth(motion=true)).values["energy_difference_max"] == 0.0
    # A loss without an event is an error, and so is energy that remains after the event.
    for speeds in ([1.0, 0.5, 0.5, 0.5, 0.5, 0.5], [1.0, 1.0, 1.0, 1.0, 1.0, 0.5]):
        wrong = replace(late, trajectory=result(shot, ends, speeds, times=times).trajectory)
        measured = measure(wrong, truth(motion=true))
        assert measured.values["energy_difference_max"] == pytest.approx(0.75, rel=1e-12)
    silent = replace(late, events=late.events[:0])
    assert measure(silent, truth(motion=true)).values["energy_difference_max"] > 0.7


@pytest.mark.parametrize("name", ["restitution-head-on", "throw-slip", "pocket-side", "stop"])
def test_the_energy_of_two_exact_engines_differs_by_rounding(name: str) -> None:
    shot = find_scene(name)
    measured = measure(simulate(shot, record="trajectory"), truth_of(shot))
    assert measured.values["energy_difference_max"] <= 1e-15
    assert measured.values["energy_difference_factor"] <= 4.0


def test_drift_where_energy_holds_and_rise_everywhere() -> None:
    # 1, 0.5, 1.1 m/s: 1, 0.25, 1.21 of the initial energy.
    ends = [[0.0, 1.0]] * 3
    free = measure(result(scene(friction=0.0), ends, [1.0, 0.5, 1.1]), truth())
    assert free.values["energy_drift"] == pytest.approx(0.75, rel=1e-12)
    assert free.values["energy_rise"] == pytest.approx(0.96, rel=1e-12)
    lossy = measure(result(scene(), ends, [1.0, 0.5, 1.1]), truth())
    assert lossy.values["energy_drift"] is None
    assert "conserved" in lossy.notes["energy_drift"]
    assert lossy.values["energy_rise"] == pytest.approx(0.96, rel=1e-12)
    # A rise over several samples counts as a whole: 1, 0.5, 0.8, 1.1 m/s.
    slow = measure(
        result(scene(), [[0.0, 1.0]] * 4, [1.0, 0.5, 0.8, 1.1], times=(0.0, 1.0, 1.5, 2.0)), truth()
    )
    assert slow.values["energy_rise"] == pytest.approx(0.96, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "holds"),
    [
        ({}, True),
        ({"friction": 0.02}, False),
        ({"ball_restitution": 0.9}, False),
        ({"ball_restitution": 0.9, "balls": 1}, True),
        ({"air_drag": 0.004}, False),
        ({"motion": "sliding"}, False),
        ({"motion": "sliding", "sliding_friction": 0.0}, True),
        ({"motion": "sliding", "sliding_friction": 0.0, "ball_friction": 0.05}, False),
        ({"cushion_restitution": 0.9, "cushion": "restitution"}, True),  # the scene has no cushions
    ],
)
def test_where_energy_holds(changes: dict[str, Any], holds: bool) -> None:
    assert conserves_energy(scene(**{"friction": 0.0, **changes})) is holds


@pytest.mark.parametrize(
    ("cushion", "changes", "holds"),
    [
        ("mirror", {}, True),
        ("restitution", {}, True),
        ("restitution", {"cushion_restitution": 0.9}, False),
        ("restitution", {"cushion_tangential_restitution": 0.9}, False),
        ("frictional", {}, False),
    ],
)
def test_where_cushions_hold_energy(cushion: str, changes: dict[str, Any], holds: bool) -> None:
    ball = Ball(id="cue", position=(0.5, 0.5), velocity=(1.0, 0.0))
    walls = {"table": Table(length=2.0, width=1.0), "balls": (ball,)}
    shot = scene(friction=0.0, balls=1, cushion=cushion, **changes).model_copy(update=walls)
    assert conserves_energy(shot) is holds


# --- overlaps


def test_overlap_is_the_deepest_of_any_frame() -> None:
    # Centres 0.05 m apart in the middle frame, radii of 0.03 m: an overlap of 0.01 m.
    run = result(scene(), [[0.0, 1.0], [0.5, 0.55], [0.0, 1.0]], [1.0, 0.0, 0.0])
    assert measure(run, truth()).values["overlap_max"] == pytest.approx(0.01, rel=1e-12)
    assert measure(still(), truth()).values["overlap_max"] == 0.0
    alone = measure(still(scene(balls=1)), truth())
    assert alone.values["overlap_max"] is None
    assert "one ball" in alone.notes["overlap_max"]


# --- only some metrics


def test_what_nobody_asks_for_is_not_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> Any:
        raise AssertionError("sampled for nothing")

    truth = Truth("closed form", PARTS, rest_positions=np.array([[2.0, 0.0, R]]))
    run = result(scene(balls=1), [[0.0], [1.0], [2.5]], [1.0, 1.0, 0.0])
    whole = measure(run, truth)
    for name in ("_compared", "energy_series", "largest_overlap"):
        monkeypatch.setattr(ghostball.validation.checks.motion_metrics, name, refuse)
    monkeypatch.setattr(ghostball.validation.checks.outcome_metrics, "compare_collisions", refuse)
    some = measure(run, truth, ("wall_time", "rest_error_max"))
    assert list(some.values) == ["rest_error_max", "wall_time"]
    assert some.values == {name: whole.values[name] for name in some.values}
    assert some.ball_errors is not None
    assert measure(run, truth, ("wall_time",)).ball_errors is None


@pytest.mark.parametrize(
    ("patterns", "names"),
    [
        (["wall_time", "rest_error_max"], ("rest_error_max", "wall_time")),
        (
            ["rest_error_*", "rest_error_m?x"],
            ("rest_error_max", "rest_error_rms", "rest_error_ulps"),
        ),
        (["*"], tuple(METRICS)),
    ],
)
def test_metrics_are_chosen_by_name_and_pattern(
    patterns: list[str], names: tuple[str, ...]
) -> None:
    assert choose_metrics(patterns) == names


@pytest.mark.parametrize(
    ("patterns", "message"),
    [
        (["rest_eror_max"], "Did you mean `rest_error_max`"),
        (["wall_time", "speed_*"], "got 'speed_\\*'.*Known: rest_error_max, rest_error_rms"),
        (["wall_time", ""], "got ''"),
        (["WALL_TIME"], "got 'WALL_TIME'"),
        ([], "at least one metric"),
    ],
)
def test_a_choice_that_names_no_metric_is_refused(patterns: list[str], message: str) -> None:
    with pytest.raises(MetricError, match=message):
        choose_metrics(patterns)
