"""Tests of small changes between events, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from changes import moved, one_direction, recorded
from shots import R, ball, scene_of

G = 9.81
MU = 0.02


def test_a_rolling_ball_is_displaced_as_its_closed_form_says():
    """dr = dr0 + [t - (mu g t^2 / 2 |v0|) P] dv0 for a roll, with P across the velocity."""
    result = recorded(scene_of(ball((0.5, 0.5), (1.0, 0.0)), rolling_friction=MU, table=None))
    along, across = result.tangent(
        np.concatenate([one_direction(1, v=(1.0, 0.0)), one_direction(1, v=(0.0, 1.0))])
    ).sample([1.5])[0]
    t = 1.5
    assert along[0, :2] == pytest.approx([t, 0.0], rel=1e-14)
    assert across[0, :2] == pytest.approx([0.0, t - MU * G * t**2 / 2.0], rel=1e-14)


def test_where_a_rolling_ball_rests_moves_as_its_closed_form_says():
    """At rest dr = dr0 + (v0 / mu g) (v^ v^T + P / 2) dv0."""
    result = recorded(scene_of(ball((0.5, 0.5), (1.0, 0.0)), rolling_friction=MU, table=None))
    along, across = result.tangent(
        np.concatenate([one_direction(1, v=(1.0, 0.0)), one_direction(1, v=(0.0, 1.0))])
    ).sample([result.rest_time])[0]
    reach = 1.0 / (MU * G)
    assert along[0] == pytest.approx([reach, 0, 0, 0, 0, 0, 0], rel=1e-14, abs=1e-14)
    assert across[0] == pytest.approx([0, reach / 2, 0, 0, 0, 0, 0], rel=1e-14, abs=1e-14)


def test_a_slide_ends_with_the_velocity_that_its_slip_leaves():
    """dv_f = dv0 - (2/7) du0 at the time at which the slide ends, with any friction."""
    scene = scene_of(
        ball((0.5, 0.5), (2.0, 0.3), angular_velocity=(1.0, -20.0, 3.0)),
        motion="sliding",
        table=None,
        rolling_friction=0.0,
        t_max=5.0,
    )
    result = recorded(scene)
    t = float(result.events["t"][0]) if len(result.events) else math.inf
    change = np.array([0.0, 0.0, 0.4, -0.3, 5.0, 7.0, 1.0])
    (after,) = result.tangent(change[np.newaxis, np.newaxis]).sample([t + 0.1])[0]
    slip = change[2:4] + R * np.array([-change[5], change[4]])
    assert after[0, 2:4] == pytest.approx(change[2:4] - slip * 2.0 / 7.0, rel=1e-12)


def test_side_spin_that_nothing_brakes_stays():
    """Fails if a spin of 0 counts as a spin that the cloth has ended."""
    scene = scene_of(
        ball((0.3, 0.5), (1.0, 0.0)),
        ball((0.6, 0.5)),
        motion="sliding",
        ball_friction=0.06,
        spinning_friction_rate=0.0,
    )
    result = recorded(scene)
    (spun,) = result.tangent(one_direction(2, w=(0.0, 0.0, 1.0))).sample([0.1])[0]
    assert spun[0, 6] == 1.0
    step = 1e-7
    sides = [moved(scene, s * step * one_direction(2, r=(0.0, 1.0))[0]) for s in (1, -1)]
    after, before = (recorded(side).sample([1.0]).angular_velocities[0, 1, 2] for side in sides)
    (aside,) = result.tangent(one_direction(2, r=(0.0, 1.0))).sample([1.0])[0]
    assert aside[1, 6] == pytest.approx((after - before) / (2 * step), rel=1e-4)
    assert abs(aside[1, 6]) > 10.0
