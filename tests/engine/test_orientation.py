"""Orientation of rolling balls: quaternions about the axis of rolling, exact between events."""

import math

import numpy as np
import pytest

from engine import Ball, GhostballError, Physics, Scene, Table, simulate

R = 0.028575


def turned(quaternion, vector):
    """Rotate a vector by a unit quaternion, the slow way."""
    w, axis = quaternion[0], quaternion[1:]
    return vector + 2 * w * np.cross(axis, vector) + 2 * np.cross(axis, np.cross(axis, vector))


def rolling_scene(velocity, **physics):
    ball = Ball(id="cue", position=(0.3, 0.3), velocity=velocity)
    return Scene(name="roll", balls=[ball], physics=Physics(**physics))


def test_quarter_turn_brings_the_top_to_the_front():
    """A wrong sign of the axis (r = v x k taken literally) would bring it to the back."""
    scene = rolling_scene((1.0, 0.0))
    result = simulate(scene, record="events")
    quarter = math.pi * R / 2  # distance rolled
    a = 0.02 * 9.81
    t = (1.0 - math.sqrt(1.0 - 2.0 * a * quarter)) / a
    (q,) = result.orientation([t])[0]
    assert turned(q, np.array([0.0, 0.0, 1.0])) == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)


def test_angle_is_distance_over_radius_and_axis_is_k_cross_v():
    result = simulate(rolling_scene((0.3, -0.4)), record="events")
    (q,) = result.orientation([result.rest_time])[0]
    angle = 0.5**2 / (2 * 0.02 * 9.81) / R
    assert q[0] == pytest.approx(math.cos(angle / 2), abs=1e-12)
    axis = np.array([0.4, 0.3, 0.0]) / 0.5  # k x v
    assert q[1:] == pytest.approx(axis * math.sin(angle / 2), abs=1e-12)


def test_quaternion_follows_the_angular_velocity_through_events():
    """dq/dt = w q / 2 with the sampled angular velocity, also after bounces and hits."""
    scene = Scene(
        name="three",
        balls=[
            Ball(id="a", position=(0.3, 0.3), velocity=(1.5, 0.7)),
            Ball(id="b", position=(0.9, 0.55)),
        ],
        table=Table(length=1.5, width=0.8),
    )
    result = simulate(scene, record="events")
    events = result.events["t"]
    times = np.linspace(0.01, result.rest_time - 0.01, 200)
    times = times[np.min(np.abs(times[:, None] - events), axis=1) > 1e-3]
    h = 1e-6
    before, q, after = (result.orientation(times + s) for s in (-h, 0.0, h))
    rate = (after - before) / (2 * h)
    omega = result.sample(times).angular_velocities
    w, x, y, z = np.moveaxis(q, -1, 0)
    ox, oy, oz = np.moveaxis(omega, -1, 0)
    expected = 0.5 * np.stack(
        (
            -ox * x - oy * y - oz * z,
            ox * w + oy * z - oz * y,
            oy * w + oz * x - ox * z,
            oz * w + ox * y - oy * x,
        ),
        axis=-1,
    )
    assert np.max(np.abs(rate - expected)) < 1e-5 * np.max(np.abs(omega))
    assert np.allclose(np.linalg.norm(q, axis=2), 1.0, rtol=0, atol=1e-14)


def test_a_resting_ball_keeps_its_orientation():
    result = simulate(rolling_scene((0.5, 0.0)), record="events")
    at_rest = result.orientation([result.rest_time, result.rest_time + 1.0])
    assert np.array_equal(at_rest[0], at_rest[1])


def test_without_a_record_it_says_how_to_get_one():
    with pytest.raises(GhostballError, match="record"):
        simulate(rolling_scene((0.5, 0.0))).orientation([0.0])
