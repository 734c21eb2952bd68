"""What given positions may be off by: more than sums of roots leave, far less than a ball."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ghostball.model.rounding import EPS, POSITION_ULPS, position_rounding


def test_it_goes_with_the_sizes_of_all_lengths_one_by_one():
    assert position_rounding(1.0, -2.0) == 3.0 * POSITION_ULPS * EPS
    found = position_rounding(np.array([1.0, -4.0]), np.array([2.0, 0.0]))
    assert found.tolist() == [position_rounding(1.0, 2.0), position_rounding(4.0)]


@pytest.mark.parametrize("radius", [0.028575, 0.02625, 1.0 / 3.0])
def test_a_row_of_balls_that_touch_by_computed_places_is_within_it(radius):
    step, x, y = 2.0 * radius, 0.1, 0.1
    for k in range(1, 40):
        next_x, next_y = 0.1 + k * step * math.sqrt(0.75), 0.1 + 0.5 * k * step
        overlap = abs(math.hypot(next_x - x, next_y - y) - step)
        assert overlap <= position_rounding(next_x, next_y)
        x, y = next_x, next_y
