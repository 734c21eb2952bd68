"""Tests of accelerations of balls in contact, against another integration of the motion."""

from __future__ import annotations

import pytest
from constrained_motion import Touch, constrained_motion
from islands import pushing_pair
from shots import R

from ghostball.engine import simulate


@pytest.mark.parametrize(
    ("radii", "masses", "air_drag"),
    [
        ((R, R), (0.17, 0.17), 0.0),
        ((R, R), (0.17, 0.17), 0.5),
        ((0.03, 0.02), (0.2, 0.08), 0.0),
        ((0.02, 0.03), (0.2, 0.08), 0.0),
    ],
    ids=["alike", "alike-in-air", "large-and-small", "small-and-large"],
)
def test_a_ball_that_slides_and_pushes_another_follows_the_constrained_motion(
    radii, masses, air_drag
):
    """In air, too: without drag on balls in contact, the error here would be 2e-3 m/s.

    If the radii of the two balls are exchanged, the errors are 1.5e-6 m and 9e-5 m.
    """
    scene = pushing_pair(radii, masses, air_drag=air_drag)
    result = simulate(scene, record="events")
    assert result.work["contact_steps"] > 0
    expected = constrained_motion(scene, [Touch(0, 1)])
    end = result.sample([scene.t_max])
    assert end.positions[0, :, :2] == pytest.approx(expected[0, :, :2], abs=1e-8)
    assert end.velocities[0] == pytest.approx(expected[1], abs=1e-7)
    assert R * end.angular_velocities[0] == pytest.approx(R * expected[2], abs=1e-6)
