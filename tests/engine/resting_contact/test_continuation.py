"""Tests of an island that continues from motion to motion, against another integration."""

from __future__ import annotations

import numpy as np
import pytest
from constrained_motion import Touch, constrained_motion
from shots import R

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene


@pytest.mark.parametrize("e", [1.0, 0.0])
def test_a_rolling_pair_follows_the_constrained_motion_of_the_paper(e):
    """The rear ball rolls at an angle, so that friction holds it at the other ball."""
    scene = Scene(
        name="rolling-pair",
        physics=Physics(ball_restitution=e),
        balls=[
            Ball(id="rear", position=(0.0, 0.0), velocity=(0.05, 0.03)),
            Ball(id="front", position=(2.0 * R, 0.0), velocity=(0.05, 0.0)),
        ],
        t_max=0.1,
    )
    result = simulate(scene, record="events")
    assert result.work["contact_steps"] > 3
    end = result.sample([scene.t_max])
    assert np.max(np.abs(end.positions[0] - constrained_motion(scene, [Touch(0, 1)])[0])) < 1e-10
