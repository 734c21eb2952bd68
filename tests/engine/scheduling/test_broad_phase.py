"""Tests that the broad phase checks few pairs, for any number of balls."""

import math

import numpy as np
import pytest
from many_balls import alike, many_balls
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.model import Status, Table


@pytest.mark.compiled
def test_many_balls_are_checked_only_against_neighbours():
    few, many = (
        simulate(many_balls(count, 0.5, t_max=0.2, rolling_friction=0.0)) for count in (400, 1600)
    )
    per_event = [result.work["bounds"] / result.work["events"] for result in (few, many)]
    assert per_event[1] < 1.2 * per_event[0] < 40.0


def test_a_dense_rack_on_a_large_table_needs_few_bounds():
    """If only the table determined the size of the cells, hundreds of balls would be in reach."""
    balls = [ball((2.0, 3.6), (8.0, 0.0))]
    gap = 2.0 * R + 5e-4
    for row in range(32):
        for k in range(row + 1):
            balls.append(ball((7.0 + row * gap * math.sqrt(0.75), 3.59 + (k - row / 2.0) * gap)))
    scene = scene_of(*balls[:512], table=Table(length=14.4, width=7.2))
    work = simulate(scene, record="rest", max_events=200).work
    assert work["bounds"] < 30 * (work["events"] + work["contact_steps"])


@pytest.mark.compiled
def test_an_event_takes_as_much_work_among_many_balls_as_among_few():
    """A gas of 100 000 balls once reached the work limit: an event counted as a full search."""
    few, many = (
        simulate(many_balls(count, t_max=9.0, rolling_friction=0.0), max_work=200_000)
        for count in (1_000, 6_400)
    )
    assert few.status is many.status is Status.WORK_LIMIT
    assert many.work["events"] == pytest.approx(few.work["events"], rel=0.1)


@pytest.mark.compiled
def test_the_work_of_a_tied_event_is_independent_of_the_number_of_ties():
    """Each event once searched all others: 100 us per event if 16 000 balls stop at once."""
    scene = alike(np.full((6_400, 2), (0.05, 0.0)))
    result = simulate(scene, max_work=6_400 * 200)
    assert (result.status, result.work["events"]) == (Status.REST, 6_400)
