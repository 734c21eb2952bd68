"""Accelerations of balls in contact, against another integration of the constrained motion."""

from __future__ import annotations

import pytest
from constrained_motion import Touch, constrained_motion
from shots import R

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene


@pytest.mark.parametrize("air_drag", [0.0, 0.5])
def test_a_ball_that_slides_and_pushes_another_follows_the_constrained_motion(air_drag):
    """In air, too: left out of balls in contact, it would be missed by 2e-3 m/s here."""
    x = [(0.0, 0.0, 0.0), (2.0 * R, 0.0, 0.0)]
    v = [(0.3, 0.1, 0.0), (0.3, -0.02, 0.0)]
    w = [(4.0, 60.0, 8.0), (-30.0, -20.0, -5.0)]
    t = 0.04
    scene = Scene(
        name="pushed",
        physics=Physics(
            motion="sliding",
            sliding_friction=0.2,
            spinning_friction_rate=10.0,
            ball_friction=0.06,
            ball_restitution=0.5,
            air_drag=air_drag,
        ),
        balls=[
            Ball(id=f"b{k}", radius=R, position=x[k][:2], velocity=v[k][:2], angular_velocity=w[k])
            for k in range(2)
        ],
        t_max=t,
    )
    result = simulate(scene, record="events")
    assert result.work["contact_steps"] > 0
    expected = constrained_motion(scene, [Touch(0, 1)])
    end = result.sample([t])
    assert end.positions[0, :, :2] == pytest.approx(expected[0, :, :2], abs=1e-8)
    assert end.velocities[0] == pytest.approx(expected[1], abs=1e-7)
    assert R * end.angular_velocities[0] == pytest.approx(R * expected[2], abs=1e-6)
