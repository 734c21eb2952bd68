"""Storms: what is wrong with a break is seen, wherever it is looked at."""

from __future__ import annotations

import numpy as np
import pytest
from shots import ball, scene_of

from ghostball.engine import GhostballError, Result, UnsupportedSceneError, simulate
from ghostball.engine.trajectory import ExactTrajectory, SampledTrajectory, Samples
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.stress.families import storms
from ghostball.validation.stress.families.storms import (
    Breaks,
    faults_of,
    looks,
    worst_of,
)

SHOT = scene_of(ball((0.0, 0.0), (1.0, 0.0)), ball((0.5, 0.0)), ball((0.6, 0.001)))


@pytest.fixture(scope="module")
def result():
    return simulate(SHOT, record="trajectory")


def changed(result, **fields):
    return Result(**{**vars(result), **fields})


def test_a_clean_break_has_no_fault(result):
    for everywhere in (False, True):
        worst = worst_of(result, looks(result, everywhere))
        assert faults_of(result, worst) == ()


def framed(result, by):
    """Return a run as an engine that steps records it, one ball nearer to another by so much."""
    times = np.linspace(0.0, result.rest_time, 101)
    states = Samples(*(array.copy() for array in result.sample(times)))
    states.positions[0, 2, 0] -= by  # at the very start, where they rest
    return changed(result, trajectory=SampledTrajectory(times, *states), settings={"dt": 1e-4})


def test_overlap_energy_and_what_is_unsolved_are_faults(result):
    fine = worst_of(result, looks(result, True))
    # A contact force holds its gaps to 4.2e-13 m, and the sum over three balls is rounded.
    assert fine.deepest == pytest.approx(4.2e-13, rel=0.02)
    assert fine.most_rise < 4e-15
    assert "overlap" in faults_of(result, fine._replace(depth=5e-13))[0]
    assert "energy rises" in faults_of(result, fine._replace(rise=4e-15))[0]
    work = {**result.work, "unsolved_joint_impacts": 1}
    assert "unsolved" in faults_of(changed(result, work=work), fine)[0]
    # Whatever an overlap may be, a ball that is gone is gone.
    assert faults_of(result, fine._replace(depth=0.05, deepest=0.2)) == (
        "a ball has left the table, or is within another",
    )


def test_what_the_law_says_of_an_engine_that_steps_is_not_said_twice(result):
    stepped = framed(result, 0.05)  # into the other ball, by far: `play` sees it
    assert faults_of(stepped, worst_of(stepped, looks(stepped, True))) == ()


@pytest.mark.parametrize("everywhere", [False, True])
def test_a_ball_moved_into_another_is_seen_in_the_recorded_motion(result, everywhere):
    assert isinstance(result.trajectory, ExactTrajectory)
    knots = [rows.copy() for rows in result.trajectory.knots]
    knots[1][0, 1] -= 0.01  # nearer to the cue ball until it is hit
    moved = ExactTrajectory(
        result.trajectory.radii,
        tuple(knots),
        result.trajectory.t_end,
        result.trajectory.spin_decelerations,
    )
    planted = changed(result, trajectory=moved)
    times = looks(planted, everywhere)
    times = times if everywhere else np.append(times, np.nextafter(times[1:], 0.0))
    assert worst_of(planted, np.sort(times)).depth > 5e-3


@pytest.mark.parametrize("everywhere", [False, True])
def test_speed_gained_at_an_impact_is_seen(result, everywhere):
    knots = [rows.copy() for rows in result.trajectory.knots]
    knots[1][1:, 3:5] *= 1.2
    faster = ExactTrajectory(
        result.trajectory.radii,
        tuple(knots),
        result.trajectory.t_end,
        result.trajectory.spin_decelerations,
    )
    assert worst_of(changed(result, trajectory=faster), looks(result, everywhere)).rise > 1e-3


def test_everywhere_is_at_each_event_just_before_it_and_between(result):
    times = set(looks(result, True).tolist())
    for t in result.events["t"]:
        assert {float(t), float(np.nextafter(t, 0.0))} <= times


@pytest.mark.compiled
def test_our_engine_plays_all_and_survives():
    verdict = Breaks("some", 0, 30).run(make_engine("ghostball"))
    assert verdict.faults == ()
    assert (verdict.shots, verdict.broken) == (30, 0)
    assert [len(verdict.values[name]) for name in ("events", "contact_steps", "seconds")] == [
        30
    ] * 3
    assert verdict.values["everywhere"] == 1
    assert verdict.scene is not None
    busiest = int(np.argmax(np.add(verdict.values["events"], verdict.values["contact_steps"])))
    assert verdict.scene.name == f"break-{busiest}"


@pytest.mark.compiled
def test_the_longest_break_needs_a_quarter_of_what_is_allowed():
    work = simulate(storms.random_break(39225)).work
    needed = work["events"] + work["contact_steps"]
    assert 4 * needed <= storms.MOST_EVENTS < 5 * needed


@pytest.mark.compiled
def test_a_break_that_does_not_end_is_a_fault(monkeypatch):
    monkeypatch.setattr(storms, "MOST_EVENTS", 20)
    verdict = Breaks("some", 0, 10).run(make_engine("ghostball"))
    assert verdict.broken > 0
    assert "event limit" in verdict.faults[0]
    assert verdict.scene is not None


def test_another_engine_plays_one_and_says_what_it_lacks():
    verdict = Breaks("some", 100, 10).run(make_engine("paper-continuous"))
    assert verdict.shots == 1
    assert verdict.scene is not None
    assert verdict.scene.t_max == storms.FOREIGN_T_MAX
    sliding = next(n for n in range(40) if storms.random_break(n).physics.motion == "sliding")
    with pytest.raises(UnsupportedSceneError) as caught:
        Breaks("one", sliding, 1).run(make_engine("paper-continuous"))
    assert caught.value.features
    assert isinstance(caught.value, GhostballError)
