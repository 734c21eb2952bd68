"""The judges of shots without a known end: each sees a wrong result that is planted."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import (
    Ball,
    ExactTrajectory,
    Physics,
    Result,
    SampledTrajectory,
    Samples,
    Scene,
    Table,
)
from ghostball.validation.stress.invariants import travel_in_a_step
from ghostball.validation.stress.judges import Both, Ends, Invariants, asymmetry, momentum_change

R = 2.0**-5


def scene(*, speed: float = 1.0, resting: float = 0.5, **fields) -> Scene:
    return Scene(
        name="pair",
        physics=Physics(rolling_friction=0.0),
        t_max=1.0,
        balls=[
            Ball(id="a", radius=R, position=(0.0, 0.0), velocity=(speed, 0.0)),
            Ball(id="b", radius=R, position=(resting, 0.0)),
        ],
        **fields,
    )


@pytest.fixture
def run() -> Result:
    return simulate(scene(), record="trajectory")


def framed(result: Result, change) -> Result:
    """Return a run as an engine that steps records it, its states changed (times, states)."""
    times = np.linspace(0.0, result.rest_time, 101)
    states = Samples(*(array.copy() for array in result.sample(times)))
    change(times, states)
    return replace(result, trajectory=SampledTrajectory(times, *states))


def moved(result: Result, ball: int, column: int, by: float) -> Result:
    """Return a run whose exact motion has one number of one ball's first segment off."""
    trajectory = result.trajectory
    assert isinstance(trajectory, ExactTrajectory)
    segments = [rows.copy() for rows in trajectory.segments]
    segments[ball][0, column] += by
    return replace(result, trajectory=replace(trajectory, segments=tuple(segments)))


INVARIANTS = Invariants(most_events=1, isolated=True, images=(0, 1))


def test_a_right_run_survives(run):
    verdict = INVARIANTS(run)
    assert verdict.faults == ()
    assert verdict.severity <= 1.0
    assert Ends(((0.0, 0.0), (1.0, 0.0)), 1, ((0.4375, 0.0), (1.0625, 0.0)))(run).faults == ()


def test_an_overlap_is_seen(run):
    (fault,) = Invariants(most_events=1)(moved(run, 1, 1, -2e-12)).faults
    assert "overlap of balls" in fault
    assert (
        Invariants(most_events=1)(moved(run, 1, 1, -2e-13)).faults == ()
    )  # a contact may be that deep


def test_an_overlap_with_a_cushion_is_seen():
    table = Table(length=1.0, width=1.0, cushions=("left",))
    ball = Ball(id="a", radius=R, position=(0.25, 0.5), velocity=(-1.0, 0.0))
    shot = Scene(
        name="one", physics=Physics(rolling_friction=0.0), table=table, balls=[ball], t_max=1.0
    )
    run = simulate(shot, record="trajectory")
    assert Invariants(most_events=1)(run).faults == ()
    (fault,) = Invariants(most_events=1)(moved(run, 0, 1, -2e-12)).faults
    assert "ball and cushion" in fault


def test_an_engine_that_steps_may_go_into_a_cushion_by_the_way_of_a_step(run):
    table = Table(length=2.0, width=1.0, cushions=("right",))
    scene = run.scene.model_copy(update={"table": table})

    def deep(times, states):
        states.positions[50:60, 1, 0] = 2.0 - R + 0.9e-3

    stepped = replace(framed(run, deep), scene=scene)
    (fault,) = Invariants(most_events=1)(replace(stepped, settings={"dt": 1e-4})).faults
    assert "overlap of ball and cushion" in fault
    slow = replace(stepped, settings={"dt": 1e-3})
    assert travel_in_a_step(slow) == 1e-3
    assert Invariants(most_events=1)(slow).faults == ()
    assert travel_in_a_step(stepped) == math.inf  # nobody says how long its steps are


def test_what_the_law_says_of_an_engine_that_steps_is_not_said_twice(run):
    def bad(times, states):
        states.positions[50:60, 1, 0] = states.positions[50:60, 0, 0]
        states.velocities[:, 0, 0] = 1.0 + 1e-4 * np.arange(len(times))

    assert Invariants(most_events=1)(framed(run, bad)).faults == ()


def test_energy_that_rises_is_seen(run):
    # The struck ball starts to move by itself, before it is hit.
    faults = Invariants(most_events=1)(moved(run, 1, 4, 1e-6)).faults
    assert faults == ()  # at once: the first energy is that one
    trajectory = run.trajectory
    segments = [rows.copy() for rows in trajectory.segments]
    segments[1][-1, 3] *= 1.0 + 1e-14
    leaking = replace(run, trajectory=replace(trajectory, segments=tuple(segments)))
    (fault,) = Invariants(most_events=1)(leaking).faults
    assert "energy" in fault


def test_momentum_that_changes_is_seen(run):
    faults = INVARIANTS(moved(run, 1, 4, 1e-14)).faults
    assert any("momentum" in fault for fault in faults)


def test_momentum_is_measured_against_the_most_there_is():
    shot = scene()
    velocities = np.zeros((3, 2, 3))
    velocities[:, 0, 0] = 1.0, -1.0, 0.0
    velocities[:, 1, 0] = 0.0, 2.0, 1.5
    states = Samples(velocities, velocities, velocities)
    assert momentum_change(shot, states) == pytest.approx(0.5 / 3.0)


def test_asymmetry_is_seen_to_the_last_bit(run):
    faults = INVARIANTS(moved(run, 0, 2, 1e-18)).faults
    assert len(faults) == 1
    assert "asymmetry" in faults[0]


@pytest.mark.parametrize("swapped", [False, True])
def test_the_image_of_a_ball_may_be_another_one(swapped):
    a, b = ((1.0, 2.0, 0.0), (2.0, 1.0, 0.0)) if swapped else ((1.0, 2.0, 0.0), (1.0, -2.0, 0.0))
    positions = np.array([[a, b]])
    assert asymmetry(positions, (1, 0), swapped) == 0.0
    assert asymmetry(positions, (0, 1), swapped) > 0.5


def test_contact_steps_permit_a_stated_asymmetry(run):
    stepped = replace(run, work={**run.work, "contact_steps": 3})
    askew = moved(stepped, 0, 2, 1e-12)
    assert Invariants(most_events=1, most_steps=3, images=(0, 1))(askew).faults == ()
    assert (
        len(Invariants(most_events=1, most_steps=3, images=(0, 1), skew=1e-13)(askew).faults) == 1
    )


@pytest.mark.parametrize(
    ("counter", "words"),
    [
        ("contact_steps", "number of contact steps"),
        ("unsolved_contact_steps", "left unsolved"),
        ("unsolved_joint_impacts", "left unsolved"),
    ],
)
def test_work_beyond_its_bound_is_seen(run, counter, words):
    (fault,) = Invariants(most_events=1)(replace(run, work={**run.work, counter: 1})).faults
    assert words in fault


def test_a_ball_that_must_not_move_is_seen():
    away = simulate(scene(speed=-1.0), record="trajectory")
    still = Invariants(most_events=0, still=(1,))
    assert still(away).faults == ()
    (fault,) = still(moved(away, 1, 2, 1e-18)).faults
    assert "nothing moves" in fault


def test_a_wrong_end_is_seen(run):
    velocities, positions = ((0.0, 0.0), (1.0, 0.0)), ((0.4375, 0.0), (1.0625, 0.0))
    assert "collisions" in Ends(velocities, 2)(run).faults[0]
    assert "velocity" in Ends(((0.0, 0.0), (1.0 - 1e-14, 0.0)))(run).faults[0]
    assert "from where" in Ends(velocities, 1, (positions[0], (1.0625 + 1e-13, 0.0)))(run).faults[0]


def test_both_judges_are_asked(run):
    verdict = Both(Invariants(most_events=0), Ends(((0.0, 0.0), (1.0, 0.0)), 2))(run)
    assert len(verdict.faults) == 2
    assert {"number of events [1]", "collisions"} & set(verdict.values)
    assert verdict.broken == 1
