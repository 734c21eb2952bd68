"""A pair that has no bound is looked at truly: what a wrong skip passed over would be found."""

import math

import numpy as np
import pytest
from kernels import entry_to
from shots import R, ball, scene_of

from engine.core.kernel import COMPILED
from engine.core.state import BALL, BOUNDS, COUNTERS, BallRow, rows_of
from engine.running.from_scene import layout_of
from engine.scheduling.look_again import overlap_until

overlap_until = entry_to(overlap_until)


def looked_at(other, velocity, end):
    scene = scene_of(
        ball((0.0, 0.0), (1.0, 0.0)), ball(other, velocity), rolling_friction=0.0, t_max=9.0
    )
    counters = np.zeros(COUNTERS, dtype=np.int64)
    balls = layout_of(scene).balls
    balls = balls._replace(
        state=balls.state.view(BALL)[:, 0] if COMPILED else rows_of(balls.state, BallRow)
    )
    return overlap_until(balls, 0, 1, 0.0, end, counters), counters[BOUNDS]


def test_a_contact_that_was_passed_over_is_found():
    found, looks = looked_at((1.0, 0.0), (0.9, 0.0), 10.0 * (1.0 - 2.0 * R) + 0.2)
    assert found > 10.0 * (1.0 - 2.0 * R)
    assert looks == 32


@pytest.mark.parametrize(
    ("other", "velocity", "end"),
    [
        ((1.0, 0.0), (1.1, 0.0), 50.0),  # recedes
        ((1.0, 0.0), (0.9, 0.0), 9.0),  # would meet, but later
        ((1.0, 2.0 * R), (0.0, 0.0), 5.0),  # passes by, and touches
        ((1.0, 0.0), (0.9, 0.0), math.inf),  # nothing ends their motion
    ],
)
def test_nothing_is_found_where_nothing_meets(other, velocity, end):
    assert looked_at(other, velocity, end)[0] == math.inf
