"""A result says how the run ended, and prints floats that read back to the same bits."""

from __future__ import annotations

import json
import pickle
from dataclasses import replace

import numpy as np
import pytest
from shots import R, ball, result_of, scene_of

from ghostball.engine import simulate, simulate_many
from ghostball.model import (
    EVENT_DTYPE,
    Ball,
    EventKind,
    GhostballError,
    Phase,
    Result,
    SampledTrajectory,
    Samples,
    Scene,
    SceneError,
    Status,
    Table,
    initial_state,
)
from ghostball.validation.scenes.library import find_scene

SCENE = scene_of(ball((0.1, 0.2), (1.0, 0.5)), ball((0.9, 0.2)))
EVENTS = np.array(
    [(1 / 3, 0, 0, 1), (0.7, 1, 1, 3), (0.8, 1, 0, 0), (2.0, 3, 1, -1)], dtype=EVENT_DTYPE
)


def result_with(**fields) -> Result:
    defaults = {
        "settings": {"dt": 1e-3},
        "rest_time": 2.0,
        "collision_counts": {"ball-ball": 1, "ball-cushion": 2},
        "work": {"steps": 7},
        "wall_time": 0.25,
        "events": EVENTS,
    }
    return result_of(SCENE, **{**defaults, **fields})


def test_the_initial_state_is_the_scenes():
    state = initial_state(SCENE)
    assert [array.shape for array in state] == [(1, 2, 3)] * 3
    assert state.positions[0].tolist() == [[0.1, 0.2, R], [0.9, 0.2, R]]
    assert state.angular_velocities[0, 0].tolist() == [-0.5 / R, 1.0 / R, 0.0]


def test_json_reads_back_to_the_same_bits():
    noise = np.random.default_rng(1).normal(size=(1, 2, 3))
    result = result_with(final_state=Samples(noise, noise, noise))
    text = result.to_json()
    assert "\n" not in text
    read = json.loads(text)
    assert read == result.to_dict()
    assert np.array(read["rest_positions"]).tobytes() == noise[0].tobytes()
    assert read["events"][0]["t"].hex() == (1 / 3).hex()
    assert read["status"] == "rest"
    assert set(read["energy"]) == {"initial", "final"}


def test_energy_of_the_two_ends_in_json():
    still = initial_state(scene_of(ball((0.1, 0.2)), ball((0.9, 0.2))))
    energy = result_with(final_state=still).to_dict()["energy"]
    assert energy["final"] == 0.0
    assert energy["initial"] == pytest.approx(0.7 * 0.170097 * 1.25, rel=1e-15)


def test_sampling_what_was_not_recorded_says_what_to_do():
    for ask in (result_with().sample, result_with().energy, result_with().phases):
        with pytest.raises(GhostballError, match=r'engine `toy` .*record="trajectory"'):
            ask([0.0])


def test_sampling_takes_one_time_or_many_in_any_order():
    state = initial_state(SCENE)
    later = state.positions + np.array([1.0, 0.0, 0.0])
    trajectory = SampledTrajectory(
        np.array([0.0, 1.0]),
        np.concatenate([state.positions, later]),
        np.concatenate([state.velocities] * 2),
        np.concatenate([state.angular_velocities] * 2),
    )
    result = result_with(trajectory=trajectory)
    assert result.sample(0.5).positions.shape == (1, 2, 3)
    assert result.sample([1, 0, 0.5]).positions[:, 0, 0].tolist() == pytest.approx([1.1, 0.1, 0.6])
    assert result.energy([0.0, 1.0]).total.shape == (2,)


def test_frames_have_no_phases_and_a_trajectory_of_ones_own_no_orientation():
    trajectory = SampledTrajectory(np.zeros(1), *initial_state(SCENE))
    result = result_with(trajectory=trajectory)
    with pytest.raises(GhostballError, match=r"engine `toy` .* no phases; .*`ghostball`"):
        result.phases([0.0])
    assert np.all(result.orientation([0.0, 1.0]) == [1.0, 0.0, 0.0, 0.0])

    class Own:
        t_end, sample = 0.0, trajectory.sample

    with pytest.raises(GhostballError, match=r"engine `toy` returned its own .* no orientation"):
        result_with(trajectory=Own()).orientation([0.0])


def test_our_engine_says_how_the_balls_move():
    result = simulate(scene_of(ball((0, 0), (1, 0)), ball((9, 9))), record="events")
    assert result.phases([0.0, result.rest_time]).tolist() == [
        [Phase.ROLLING, Phase.RESTING],
        [Phase.RESTING, Phase.RESTING],
    ]


@pytest.mark.parametrize(
    ("times", "complaint"),
    [
        ([-1.0], "at least 0"),
        ([float("nan")], "at least 0"),
        ([[0.0, 1.0]], "one-dimensional"),
        (None, "must be numbers of seconds, got None"),
        ([0.0, None], r"must be numbers of seconds, got \[0.0, None\]"),
        ("1.0", "must be numbers of seconds, got '1.0'"),
        ([[0.0], [0.0, 1.0]], "must be numbers of seconds"),
    ],
)
def test_times_to_sample_at_are_checked(times, complaint):
    scene = Scene(name="roll", balls=[Ball(id="a", position=(0, 0), velocity=(1, 0))])
    result = simulate(scene, record="events")
    for method in (result.sample, result.energy, result.orientation, result.phases):
        with pytest.raises(GhostballError, match=complaint):
            method(times)


def test_a_result_passes_to_another_process_after_its_sensitivity_was_asked_for() -> None:
    """Without numba, the obstacles of a table, which the sensitivity uses, can't be pickled."""
    table = Table(length=2.0, width=1.0)
    shot = scene_of(ball((0.1, 0.2), (1.0, 0.5)), ball((0.9, 0.2)), table=table)
    run = simulate(shot, record="trajectory")
    sizes = run.sensitivity([0.1, 0.5])
    again = pickle.loads(pickle.dumps(run))
    assert "rounding" not in vars(again)
    np.testing.assert_array_equal(again.sensitivity([0.1, 0.5]), sizes)


@pytest.mark.parametrize(
    ("t", "complaint"),
    [
        (None, "`t` must be numbers of seconds, got None"),
        ("x", "`t` must be numbers of seconds, got 'x'"),
        (-1.0, "`t` must be at least 0"),
        ([0.0, 1.0], "`t` must be one time, got 2"),
    ],
)
def test_the_moment_of_a_scene_is_checked(t, complaint):
    result = simulate(scene_of(ball((0, 0), (1, 0))), record="events")
    with pytest.raises(GhostballError, match=complaint):
        result.at(t)


def test_a_result_with_the_scene_of_another_shot_has_no_next_shot():
    result = simulate(scene_of(ball((0, 0), (1, 0)), ball((9, 9))))
    other = replace(result, scene=scene_of(ball((0, 0), (1, 0))))
    with pytest.raises(SceneError, match=r"must have 1 rows, .* got 2"):
        Scene.after(other)


SCREEN = 80 * 24
"""Characters on one screen."""


def test_its_repr_is_one_screen_at_most_and_says_what_happened():
    # Fails if the repr contains arrays, or the scene with all balls.
    found = simulate(find_scene("break-16"), record="trajectory")
    said = repr(found)
    assert len(said) < SCREEN / 2
    for part in ("break-16", "16 balls", "'ghostball'", "status=REST", "ball-ball", "Trajectory"):
        assert part in said
    batch = repr(simulate_many([find_scene("break-16"), find_scene("stop")]))
    assert batch == "<Batch of 2 shots with up to 16 balls, 2 complete>"


def test_the_repr_of_a_run_that_stopped_says_why():
    said = repr(result_with(status=Status.FAILED, reason="it fell"))
    assert "status=FAILED, reason='it fell'" in said


# Outcomes


def test_outcomes_are_counted_from_events():
    events = [
        (0.1, EventKind.BALL_CUSHION, 2, 1),
        (0.2, EventKind.BALL_CUSHION, 2, 0),
        (0.2, EventKind.BALL_CUSHION, 3, 0),
        (0.3, EventKind.BALL_BALL, 0, 1),
        (0.4, EventKind.BALL_BALL, 1, 2),
        (0.5, EventKind.BALL_CUSHION, 2, 3),
        (0.6, EventKind.POCKETED, 1, 4),
        (0.7, EventKind.LEAVES_TABLE, 0, 2),
    ]
    scene = scene_of(*(ball((0.1 + 0.1 * i, 0.2)) for i in range(4)))
    result = result_of(scene, events=np.array(events, dtype=EVENT_DTYPE))
    found = result.outcomes(cue="b2")
    assert found.pocketed.tolist() == [-1, 4, -1, -1]
    assert np.array_equal(found.pocketed_at, [np.nan, 0.6, np.nan, np.nan], equal_nan=True)
    assert found.off_table.tolist() == [True, False, False, False]
    assert found.ball_cushions.tolist() == [0, 0, 3, 1]
    assert (found.first_contact, found.cushions_before) == (1, 2)
    for cue, first in enumerate((1, 0, 1, -1)):
        assert result.outcomes(cue).first_contact == first


def test_a_cue_ball_that_hits_nothing_has_all_of_its_cushion_collisions_before():
    events = np.array([(0.1, EventKind.BALL_CUSHION, 0, 1)] * 3, dtype=EVENT_DTYPE)
    assert result_with(events=events).outcomes().cushions_before == 3


def test_outcomes_need_events_and_a_cue_ball_of_the_scene():
    with pytest.raises(GhostballError, match=r'no events .* simulate\(scene, record="events"\)'):
        result_with(events=None).outcomes()
    for wrong in (2, -1, True, 0.0, "cue"):
        with pytest.raises(GhostballError, match="`cue` must be the index of a ball, 0 to 1, or"):
            result_with().outcomes(wrong)
