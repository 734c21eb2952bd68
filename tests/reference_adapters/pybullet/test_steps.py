"""What a recorder gets of Bullet's steps."""

from __future__ import annotations

import numpy as np
import pytest
from shots import ball, scene_of

from ghostball.model import EventKind
from ghostball.reference_adapters.pybullet.engine import PybulletEngine
from ghostball.reference_adapters.pybullet.settings import PybulletSettings

SLIDING = {"motion": "sliding", "sliding_friction": 0.2, "ball_restitution": 0.9}


@pytest.mark.parametrize("physics", [{}, SLIDING], ids=["rolling", "sliding"])
def test_a_recorded_ball_turns_where_bullet_saw_it_collide(physics: dict[str, object]) -> None:
    """Fails where it turns within a step: a motion drawn from the frames would round the corner."""
    if PybulletEngine.unavailable():
        pytest.skip(str(PybulletEngine.unavailable()))
    scene = scene_of(ball((0, 0), (1, 0)), ball((0.3, 0.02)), rolling_friction=0.1, **physics)
    result = PybulletEngine(PybulletSettings(dt=5e-3)).simulate(scene, record="trajectory")
    collision = result.events[result.events["kind"] == EventKind.BALL_BALL][0]
    times = result.trajectory.times
    before, after = np.flatnonzero(times == collision["t"])[-2:]
    places, velocities = result.trajectory.positions, result.trajectory.velocities
    np.testing.assert_array_equal(places[before], places[after])
    assert velocities[before, 1, 0] == 0.0 < velocities[after, 1, 0]
    assert result.work["contacts"] >= 1
    # Its frames end when the last ball stops, which in the plane is within a step.
    assert times[-1] == result.rest_time
