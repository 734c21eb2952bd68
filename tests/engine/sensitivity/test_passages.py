"""Tests of small changes along a shot: times of events, and where no derivative exists."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from changes import directions_of, moved, recorded
from same.images import shuffled
from shots import ball, scene_of

from ghostball.model import EventKind, Table
from ghostball.validation.scenes.library import find_scene


def test_event_shifts_say_when_events_come():
    scene = find_scene("break-7")
    result = recorded(scene)
    change, size = directions_of(scene, 1), 1e-8
    shifts = result.tangent(change).event_shifts[:, 0]
    after, before = (recorded(moved(scene, sign * size * change[0])) for sign in (1, -1))
    difference = (after.events["t"] - before.events["t"]) / (2 * size)
    assert difference == pytest.approx(shifts, rel=1e-4, abs=1e-4 * np.max(np.abs(shifts)))


@pytest.mark.parametrize("name", ["break-7", "half-ball-cut", "throw-slip", "moving-moving"])
def test_the_numbering_of_the_balls_does_not_matter(name):
    """Fails if the random signs of rounding depend on the log or on the index of a ball."""
    result = recorded(find_scene(name))
    order = list(range(len(result.scene.balls)))
    times = np.linspace(0.0, 1.0, 9) * result.rest_time
    base = result.sensitivity(times)
    for seed in range(3):
        random.Random(seed).shuffle(order)
        other = recorded(shuffled(result.scene, order))
        assert np.array_equal(other.rest_positions, result.rest_positions[order])
        assert other.sensitivity(times) == pytest.approx(base[:, order], rel=1e-9)
        assert other.horizon() == pytest.approx(result.horizon(), rel=1e-9)


def test_what_is_exact_by_symmetry_is_not_taken_for_chaos():
    """Galperin's balls stay exactly on their line: rounding never moves them off it."""
    result = recorded(find_scene("galperin-2"))
    assert result.horizon() == math.inf
    assert np.max(result.sensitivity(result.rest_time)) < 1e9


def test_nothing_is_predicted_past_several_collisions_of_one_ball():
    result = recorded(find_scene("three-ball-symmetric"))
    t = float(result.events["t"][0])
    assert result.horizon() == pytest.approx(t)
    assert np.all(np.isfinite(result.sensitivity(t * (1 - 1e-9))))
    assert np.all(np.isinf(result.sensitivity(t * (1 + 1e-9))))


@pytest.mark.parametrize("flipped", [False, True])
def test_nothing_is_predicted_past_a_collision_and_a_bounce_of_one_ball_at_one_instant(flipped):
    """A hits B, which rolls along a cushion, from the side and drives it into the cushion."""
    r = 2.0**-5
    balls = [
        ball((1.0, r + 0.25), (0.0, -0.25), radius=r),
        ball((1.0 - 2.0 * r - 0.5, r), (0.5, 0.0), radius=r),
    ]
    table = Table(length=4.0, width=2.0)
    scene = scene_of(
        *(balls[::-1] if flipped else balls), table=table, rolling_friction=0.0, t_max=2.0
    )
    result = recorded(scene)
    (t, first, *_), (at, second, *_) = result.events[:2].tolist()
    assert (first, second) == (EventKind.BALL_BALL, EventKind.BALL_CUSHION)
    assert t == at == result.horizon() == pytest.approx(1.0, rel=1e-15)
    assert np.all(np.isfinite(result.sensitivity(1.0 - 1e-9)))
    assert np.all(np.isinf(result.sensitivity(1.5)))


def test_nothing_is_predicted_past_sustained_contact():
    result = recorded(find_scene("push-line"))
    assert result.horizon() < result.rest_time
    assert np.any(np.isinf(result.sensitivity(result.rest_time)))
