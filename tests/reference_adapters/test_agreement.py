"""Results that contradict themselves, and right results of every kind."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from wrong_runs import along_x, framed, frames_of, swapped, with_end, with_moved_ends

from ghostball.engine import simulate
from ghostball.model import Result, SampledTrajectory, Status
from ghostball.reference_adapters.agreement import disagreement
from ghostball.validation.scenes.library import find_scene


def exact(name: str) -> Result:
    return simulate(find_scene(name), record="trajectory")


def moved(result: Result, by: float) -> Result:
    return with_moved_ends(result, along_x(by))


@pytest.mark.parametrize(
    "name", ["half-ball-cut", "cue-masse", "galperin-1", "pocket-side", "flight-jump", "break-7"]
)
def test_a_right_result_agrees_with_itself(name: str) -> None:
    right = exact(name)
    for run in (right, framed(right), framed(right, after=1.0), replace(right, trajectory=None)):
        assert disagreement(run, run.scene) == ""


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda run: moved(run, 1e-4), "`rest_positions[0]` must be the position of ball"),
        (lambda run: moved(run, 1e-6), "`rest_positions[0]` must be the position of ball"),
        (
            lambda run: with_moved_ends(run, swapped),
            "`rest_positions[0]` must be the position of ball",
        ),
        (
            lambda run: replace(run, rest_time=run.rest_time + 0.5),
            "`rest_time` must be the time at which the last ball comes to rest",
        ),
        (lambda run: replace(run, rest_time=run.rest_time - 0.5), "must be the position of ball"),
    ],
)
def test_an_end_that_contradicts_the_motion_is_refused(
    wrong: Callable[[Result], Result], said: str
) -> None:
    right = exact("half-ball-cut")
    for run in (right, framed(right, after=1.0)):
        assert said in disagreement(wrong(run), run.scene)


def test_times_in_messages_are_plain_numbers() -> None:
    right = exact("half-ball-cut")
    for run in (right, framed(right, after=1.0)):
        wrong = moved(replace(run, rest_time=np.float64(run.rest_time)), 1e-4)
        late = replace(run, rest_time=np.float64(run.rest_time + 0.5))
        for one in (wrong, late):
            assert "np.float64" not in disagreement(one, run.scene)


def test_a_ball_in_a_pocket_may_rest_elsewhere_than_its_motion_ends() -> None:
    """Pocketed balls must be known without events, which `record="rest"` leaves out."""
    right = exact("pocket-side")
    events, hole = right.events, right.scene.table.holes[1]
    assert right.gone.tolist() == [True]
    in_hole = np.array([[*hole.centre, right.rest_positions[0, 2]]])
    beside = in_hole + np.array([0.0, 0.5, 0.0])
    for run in (right, framed(right)):
        for recorded in (events, None):
            ended = replace(with_end(run, positions=in_hole), events=recorded)
            assert disagreement(ended, run.scene) == ""
        on_table = replace(with_end(run, positions=beside), events=None)
        assert "`rest_positions[0]` must be the position of" in disagreement(on_table, run.scene)


def test_samples_that_end_while_balls_move_are_refused() -> None:
    run = framed(exact("half-ball-cut"))
    frames = frames_of(run)
    last = len(frames.times) - 1

    def cut(samples: slice | list[int]) -> str:
        kept = (part[samples] for part in (frames.positions, frames.velocities))
        spins = frames.angular_velocities[samples]
        part = SampledTrajectory(frames.times[samples], *kept, spins)
        return disagreement(replace(run, trajectory=part), run.scene)

    # Two samples are at the end: just before the last ball rests, and at this time.
    for samples in (slice(0, 1), slice(0, last // 2), slice(0, last - 2)):
        assert "`trajectory.times` must continue to the end of the run" in cut(samples)
    assert cut(slice(0, last - 1)) == ""  # the end, between two samples
    assert cut([*range(0, last, 7), last]) == ""


def test_the_status_of_a_run_must_be_possible_in_its_scene() -> None:
    """The status "t-max" is rejected without `t_max`, and "rest" while balls move."""
    right = exact("half-ball-cut")
    assert "without `t_max`" in disagreement(replace(right, status=Status.T_MAX), right.scene)
    timed = simulate(right.scene.model_copy(update={"t_max": 0.5}), record="trajectory")
    assert timed.status is Status.T_MAX
    assert timed.rest_time == 0.5
    for run in (timed, framed(timed)):
        assert disagreement(run, run.scene) == ""
        said = disagreement(replace(run, status=Status.REST), run.scene)
        assert 'must end with "t-max"' in said
