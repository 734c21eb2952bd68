"""Tests of balls that jump, drop and bounce: properties in space that hold for any shot.

A jump clears a ball or hits its top. A ball that falls on another ball, however near to the centre,
falls off it. Endless bounces end at the limit of their series.
"""

import math
from dataclasses import replace

import in_space
import numpy as np
import pytest
from in_space import faults_in_space

from ghostball.engine import simulate
from ghostball.model import Ball, EventKind, Physics, Result, Scene, Table

R = Ball(id="any", position=(0.0, 0.0)).radius
G = 9.81
FLIES = Physics(preset="pool", airborne=True, table_restitution=0.5)


def over_the_top(depth, turn):
    """Return a jump over a resting ball, with the apex `depth` diameters below the contact.

    The speed of 1 m/s is large enough for the path to be nearest there: 2 R g < v^2.
    """
    speed, before = 1.0, 0.1
    c, s = math.cos(turn), math.sin(turn)
    top = 3.0 * R - 2.0 * R * depth
    way = speed * before
    return Scene(
        name="over-top",
        physics=FLIES,
        balls=[
            Ball(
                id="cue",
                position=(-c * way, -s * way, top - 0.5 * G * before * before),
                velocity=(speed * c, speed * s, G * before),
                angular_velocity=(0.0, 0.0, 0.0),
            ),
            Ball(id="object", position=(0.0, 0.0)),
        ],
        t_max=1.2 * before,
    )


def on_top(aside, restitution, drop=0.1):
    """Return a ball that falls on another ball, `aside` radii from its centre."""
    return Scene(
        name="on-top",
        physics=FLIES.model_copy(update={"ball_restitution": restitution}),
        balls=[
            Ball(id="below", position=(0.0, 0.0)),
            Ball(id="above", position=(aside * R, 0.0, 3.0 * R + drop)),
        ],
    )


def meet(result):
    return bool(np.any(result.events["kind"] == EventKind.BALL_BALL))


@pytest.mark.compiled
@pytest.mark.parametrize("turn", [0.0, 0.3, 0.7, 2.0])
@pytest.mark.parametrize("depth", [sign * 10.0**-k for k in range(1, 10) for sign in (1.0, -1.0)])
def test_a_jump_clears_a_ball_or_clips_its_top(depth, turn):
    result = simulate(over_the_top(depth, turn), record="trajectory")
    assert faults_in_space(result) == []
    assert meet(result) == (depth > 0.0)


@pytest.mark.compiled
@pytest.mark.parametrize("drop", [0.1, 1e-3, 1e-7])
@pytest.mark.parametrize("restitution", [0.0, 0.95, 1.0])
@pytest.mark.parametrize("aside", [0.0, 1e-13, 1e-6, 0.5, 1.5])
def test_a_ball_that_falls_on_another_comes_off_it(aside, restitution, drop):
    result = simulate(on_top(aside, restitution, drop), record="trajectory")
    assert faults_in_space(result) == []
    assert meet(result)


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.6, 0.9, 0.99])
def test_endless_bounces_end_when_their_series_does(restitution, count):
    """Allow 1e-14 of the time for each landing. Balls that are released together land together."""
    drop = 0.1
    scene = Scene(
        name="endless",
        physics=FLIES.model_copy(update={"table_restitution": restitution}),
        balls=[Ball(id=f"b{i}", position=(0.25 * i, 0.0, R + drop)) for i in range(count)],
    )
    events = simulate(scene, record="events").events
    landings = events[events["kind"] == EventKind.BALL_CLOTH]
    ends = math.sqrt(2.0 * drop / G) * (1.0 + restitution) / (1.0 - restitution)
    for i in range(count):
        last = float(landings["t"][landings["a"] == i].max())
        assert abs(last / ends - 1.0) <= 1e-14 * len(landings)
    assert len(np.unique(landings["t"])) * count == len(landings)


def test_what_overlaps_in_space_is_seen(monkeypatch):
    result = simulate(on_top(1.5, 0.0), record="trajectory")
    assert faults_in_space(result) == []
    monkeypatch.setattr(in_space, "FLIGHT_CONTACT_TOLERANCE", -1e-3)
    assert "overlap of balls" in faults_in_space(result)[0]


@pytest.mark.parametrize(
    ("name", "raised"),
    [
        ("depth in the table", (0, 0, -1e-6)),
        ("height of a ball at rest", (0, 0, 1e-6)),
        ("overlap of ball and nose", (-1e-6, 0, 0)),
    ],
)
def test_what_is_in_the_table_over_it_or_in_a_nose_is_seen(monkeypatch, name, raised):
    """The ball leans on the left nose at the end."""
    scene = Scene(
        name="leans",
        table=Table(length=1.0, width=1.0),
        physics=Physics(preset="pool", airborne=True, cushion_height=R),
        balls=[Ball(id="cue", position=(R, 0.5))],
    )
    result = simulate(scene, record="trajectory")
    assert faults_in_space(result) == []
    sample = Result.sample

    def moved(self, times):
        states = sample(self, times)
        return states._replace(positions=states.positions + np.array(raised))

    monkeypatch.setattr(Result, "sample", moved)
    assert any(name in fault for fault in faults_in_space(result))


def test_energy_from_nowhere_and_steps_left_unsolved_are_seen():
    result = simulate(on_top(0.5, 0.95), record="trajectory")
    times = in_space.instants(result)
    assert in_space.rise_limit(result, times, result.sample(times)) < 1e-6
    unsolved = replace(result, work={**result.work, "unsolved_joint_impacts": 1})
    assert "left unsolved" in faults_in_space(unsolved)[0]
