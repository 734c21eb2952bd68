"""Tests of bounces on the table."""

from __future__ import annotations

import pytest
from in_space import after_the_first_event
from shots import FLIES, JUST_ABOVE, R, ball, scene_of

from ghostball.model import EventKind


@pytest.mark.parametrize(
    ("velocity", "spin", "then", "turning"),
    [
        ((2, 0, -1), (0, 0, 0), (1.7, 0, 0.5), (0, 26.246719160104987, 0)),
        (
            (0.5, 0, -2),
            (0, 0, 40),
            (0.35714285714285714, 0, 1),
            (0, 12.498437695288089, 40),
        ),
        (
            (1, 0.5, -1),
            (20, -30, 10),
            (0.74014490651493903, 0.35008225458648925, 0.5),
            (6.88383679671822, -7.2655211299159254, 10),
        ),
    ],
    ids=["slips", "sticks", "slips across"],
)
def test_a_bounce_on_the_table_is_the_published_one(velocity, spin, then, turning):
    """Fails if the vertical spin changes: another engine takes 2/7 of it if the ball sticks."""
    scene = scene_of(ball((0, 0, JUST_ABOVE), velocity, angular_velocity=spin), **FLIES)
    event, v, w = after_the_first_event(scene)
    assert event["kind"] == EventKind.BALL_CLOTH
    assert v[0] == pytest.approx(then, abs=1e-12)
    assert w[0] == pytest.approx(turning, abs=1e-10)
    invariant = [velocity[0] + 0.4 * R * spin[1], velocity[1] - 0.4 * R * spin[0]]
    assert [v[0, 0] + 0.4 * R * w[0, 1], v[0, 1] - 0.4 * R * w[0, 0]] == pytest.approx(invariant)
