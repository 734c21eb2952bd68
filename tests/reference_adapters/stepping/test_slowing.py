"""The kernels of cloth friction, compared with solutions by hand."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.reference_adapters.stepping.slowing import (
    SLOWEST,
    accelerate,
    last,
    move,
    slow,
    stop,
    turn,
)

V = np.array([[3.0, 4.0], [0.0, 0.0], [0.1 * SLOWEST, 0.0]])
BY = np.array([2.0, 2.0, 0.0])


def test_a_ball_is_slowed_against_its_motion_until_it_stops():
    accelerations, times = np.empty((3, 2)), np.empty(3)
    slow(V, BY, accelerations)
    stop(V, BY, times)
    assert accelerations == pytest.approx(np.array([[-1.2, -1.6], [0.0, 0.0], [0.0, 0.0]]))
    assert times.tolist() == [2.5, 0.0, np.inf]


def test_one_that_slides_is_slowed_against_its_slip_and_turned_until_it_rolls():
    """The slip decreases by 7/2 times the change of the velocity."""
    radii, by, none = np.array([0.5]), np.array([0.1]), np.zeros(1)
    v, w = np.array([[2.0, 1.0]]), np.array([[-0.4, 2.8, -3.0]])  # slips by (0.6, 0.8) m/s
    slides, ends = np.zeros(1, dtype=bool), np.zeros(1, dtype=bool)
    accelerations, durations, way = np.empty((1, 2)), np.empty((1, 2)), np.empty((1, 2))
    accelerate(v, w, radii, slides, none, by, accelerations)
    last(v, w, radii, slides, none, by, np.array([1.5]), durations)
    assert accelerations == pytest.approx(np.array([[-0.06, -0.08]]))
    assert durations == pytest.approx(np.array([[1.0 / 0.35, 2.0]]))
    dt = float(durations[0, 0])
    turn(dt, w, accelerations, radii, ~slides, none, ends)
    move(dt, v, accelerations, way)
    assert way[0] == pytest.approx([2.0 * dt - 0.03 * dt * dt, dt - 0.04 * dt * dt])
    assert v[0] == pytest.approx([0.5 * w[0, 1], -0.5 * w[0, 0]])  # the ball rolls
    assert v[0] == pytest.approx([2.0 - 1.2 / 7.0, 1.0 - 1.6 / 7.0])


def test_a_spin_about_the_vertical_falls_and_ends_at_nothing():
    w, radii = np.array([[0.0, 0.0, -3.0], [0.0, 0.0, 3.0]]), np.ones(2)
    ends, none = np.array([False, True]), np.zeros((2, 2))
    turn(0.5, w, none, radii, np.zeros(2, dtype=bool), np.array([1.0, 6.0]), ends)
    assert w[:, 2].tolist() == [-2.5, 0.0]
