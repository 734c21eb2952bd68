"""Balls and the table: what is filled in, and what a ball that rolls has for a spin."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.model import Ball, SceneError, Table, rolling_angular_velocity


def test_z_defaults_to_the_radius_and_vertical_velocity_to_zero():
    given = Ball(id="cue", position=(0.5, 0.25), velocity=(1, 2), radius=0.03)
    assert given.position == (0.5, 0.25, 0.03)
    assert given.velocity == (1.0, 2.0, 0.0)


def test_cushions_keep_the_order_of_their_index_and_appear_once():
    assert Table(length=1, width=1, cushions=("top", "left")).cushions == ("left", "top")
    with pytest.raises(SceneError, match="`cushions` must name each cushion once"):
        Table(length=1, width=1, cushions=("top", "top"))
    with pytest.raises(SceneError, match=r"`cushions\[0\]` must be 'left'"):
        Table(length=1, width=1, cushions=("north",))


def test_rolling_means_that_the_lowest_point_of_the_ball_does_not_slip():
    velocity = np.array([[0.3, -1.7, 0.0], [2.0, 0.1, 0.0]])
    radius = np.array([0.028575, 0.05])
    omega = rolling_angular_velocity(velocity, radius)
    lever = np.stack([np.zeros(2), np.zeros(2), -radius], axis=1)
    slip = velocity + np.cross(omega, lever)
    assert np.all(np.abs(slip) < 4 * 2**-52)
