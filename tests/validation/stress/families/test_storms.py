"""Storms: what is wrong with a break is seen, wherever it is looked at."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shots import ball, scene_of

from ghostball.engine import simulate
from ghostball.model import GhostballError, SampledTrajectory, Samples, UnsupportedSceneError
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.stress.families import storms
from ghostball.validation.stress.families.storms import Breaks, looks
from ghostball.validation.stress.invariants import faults_in, measured

SHOT = scene_of(ball((0.0, 0.0), (1.0, 0.0)), ball((0.5, 0.0)), ball((0.6, 0.001)))


@pytest.fixture(scope="module")
def result():
    return simulate(SHOT, record="trajectory")


def test_a_clean_break_has_no_fault(result):
    for everywhere in (False, True):
        assert faults_in(measured(result, looks(result, everywhere))) == []


def with_motion(result, change):
    """Return a run with the first ball that is hit moved otherwise."""
    segments = [rows.copy() for rows in result.trajectory.segments]
    change(segments[1])
    return replace(result, trajectory=replace(result.trajectory, segments=tuple(segments)))


def seen(result, everywhere=True):
    return " ".join(faults_in(measured(result, looks(result, everywhere))))


def test_the_limits_are_what_contacts_and_rounding_leave(result):
    found = measured(result, looks(result, True))
    # A contact force holds its gaps to 4.2e-13 m, and the sum over three balls is rounded.
    assert found["overlap of balls [m]"][1] == pytest.approx(4.2e-13, rel=0.02)
    assert found["rise of the energy [1]"][1] < 4e-15
    work = {**result.work, "unsolved_joint_impacts": 1}
    assert "unsolved" in seen(replace(result, work=work))


def test_what_the_law_says_of_an_engine_that_steps_is_not_said_twice(result):
    times = np.linspace(0.0, result.rest_time, 101)
    states = Samples(*(array.copy() for array in result.sample(times)))
    states.positions[0, 2, 0] -= 0.05  # into the other ball, by far: `play` sees it
    frames = SampledTrajectory(times, *states)
    assert seen(replace(result, trajectory=frames, settings={"dt": 1e-4})) == ""


def test_a_ball_moved_into_another_is_seen_in_the_recorded_motion(result):
    def nearer(rows):
        rows[0, 1] -= 0.01  # until it is hit

    assert "overlap of balls" in seen(with_motion(result, nearer))


@pytest.mark.parametrize("everywhere", [False, True])
def test_speed_gained_at_an_impact_is_seen(result, everywhere):
    def faster(rows):
        rows[1:, 3:5] *= 1.2

    assert "rise of the energy" in seen(with_motion(result, faster), everywhere)


def test_a_ball_that_is_gone_is_a_fault_whatever_the_step(result, monkeypatch):
    engine = make_engine("ghostball")
    monkeypatch.setattr(storms, "play", lambda *_: result)
    gone = {"overlap of balls [m]": (0.05, 0.2)}
    monkeypatch.setattr(storms, "measured", lambda *_: gone)
    (fault,) = storms.judged(0, SHOT, engine).faults
    assert fault == "a ball has left the table, or is within another"


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
