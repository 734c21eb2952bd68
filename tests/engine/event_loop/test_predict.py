"""Tests that an event cancels the old motion of its balls and their predicted events."""

from __future__ import annotations

import pytest
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.model import EventKind


def test_balls_that_exchange_velocities_exchange_rest_times():
    """Equal elastic balls in a line: each continues like the other, displaced by two radii."""
    slow, fast, start = 0.2, 1.0, 0.5
    scene = scene_of(ball((start, 0.0), (slow, 0.0)), ball((0.0, 0.0), (fast, 0.0)))
    slowing = scene.physics.rolling_friction * scene.physics.gravity
    result = simulate(scene, record="events")
    rests = result.events[result.events["kind"] == EventKind.ROLL_TO_REST]
    assert rests["a"].tolist() == [1, 0]
    assert rests["t"] == pytest.approx([slow / slowing, fast / slowing], rel=1e-12)
    ways = [2.0 * R + fast**2 / (2.0 * slowing), start - 2.0 * R + slow**2 / (2.0 * slowing)]
    assert result.rest_positions[:, 0] == pytest.approx(ways, rel=1e-12)
