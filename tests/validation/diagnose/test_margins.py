"""Overlaps, gaps and approach speeds agree with geometry."""

import math

import numpy as np
import pytest
from toy_engines import cut

from ghostball.engine import simulate
from ghostball.model import Ball, EventKind, Scene, Table
from ghostball.reference_adapters import make_engine
from ghostball.validation.diagnose.margins import (
    approach_speed,
    in_ulps,
    nearest_approach,
    overlap_of,
)
from ghostball.validation.grading.event_logs import Event, events_in

R = 0.028575


def aimed(aside=0.0, speed=1.0, x=0.6):
    """Return a run: a ball rolls along x towards a ball at `x`, with the offset `aside` [m]."""
    balls = [
        Ball(id="cue", position=(0.0, aside), velocity=(speed, 0.0)),
        Ball(id="object", position=(x, 0.0)),
    ]
    return simulate(Scene(name="aim", balls=balls), record="trajectory")


@pytest.mark.parametrize("aside", [0.0, 0.03, 0.0571])
def test_the_overlap_of_a_collision_is_what_is_left_of_two_radii_beside_the_aim(aside):
    run = aimed(aside)
    (collision,) = events_in(run.events)
    assert overlap_of(run, collision) == pytest.approx(2 * R - aside, rel=1e-6)


def test_the_overlap_with_a_ball_that_would_stop_is_what_it_would_still_go():
    # Without the other ball, it would roll 1 mm beyond the contact.
    way = 0.5 + 1e-3
    speed = math.sqrt(2.0 * 0.02 * 9.81 * way)
    run = aimed(speed=speed, x=0.5 + 2 * R)
    assert overlap_of(run, events_in(run.events)[0]) == pytest.approx(1e-3, rel=1e-6)


def test_the_overlap_with_a_cushion_is_what_the_ball_would_still_go():
    ball = Ball(id="cue", position=(0.5, 0.5), velocity=(0.6, 0.0))
    run = simulate(
        Scene(name="bank", balls=[ball], table=Table(length=1.2, width=1.0)), record="trajectory"
    )
    collision = events_in(run.events)[0]
    way = 0.36 / (2.0 * 0.02 * 9.81) - (1.2 - R - 0.5)
    assert overlap_of(run, collision) == pytest.approx(way, rel=1e-9)
    assert approach_speed(run, collision) == pytest.approx(
        math.sqrt(0.36 - 2.0 * 0.02 * 9.81 * (1.2 - R - 0.5)), rel=1e-9
    )


def test_a_miss_is_as_wide_as_its_gap():
    run = aimed(2 * R + 0.002)
    gap, when = nearest_approach(run, Event(EventKind.BALL_BALL, 0, 1, 0.6), 0.0, run.rest_time)
    assert gap == pytest.approx(0.002, rel=1e-6)
    assert run.sample([when]).positions[0, 0, 0] == pytest.approx(0.6, abs=1e-4)


def test_frames_of_a_stepping_engine_give_the_same_to_a_step():
    exact = simulate(cut(), record="trajectory")
    stepped = make_engine("pymunk").simulate(cut(), record="trajectory")
    collisions = [events_in(run.events)[0] for run in (exact, stepped)]
    assert overlap_of(stepped, collisions[1]) == pytest.approx(
        overlap_of(exact, collisions[0]), rel=1e-3
    )
    assert approach_speed(stepped, collisions[1]) == pytest.approx(
        approach_speed(exact, collisions[0]), rel=0.02
    )


def test_ulps_are_those_of_the_largest_coordinate():
    assert in_ulps(4.0 * 2.0**-52, [np.array([0.1, 1.5])]) == 4.0
