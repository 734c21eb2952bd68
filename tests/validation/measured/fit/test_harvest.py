"""Which events count as clean: those that are, in tracks of a table whose physics is known."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.synthetic_tracks import POOL, synthetic_tracks
from ghostball.model import Physics
from ghostball.validation.measured.fit.harvest import harvest
from ghostball.validation.measured.tracks import Track

TIMES = np.arange(0.0, 3.0, 0.02)
PHYSICS = Physics(preset="pool")


@pytest.fixture(scope="module")
def shots():
    return synthetic_tracks(PHYSICS, 60, 4, noise=1e-4, stale=0.0)


def test_events_of_all_kinds_are_found_with_the_noise_of_the_tracker(shots):
    found = harvest(shots, POOL)
    assert found.noise == pytest.approx(1e-4, rel=0.1)
    assert len(found.rolling) > 60
    assert len(found.cushion) > 20
    assert len(found.hit) > 2


def test_balls_that_count_as_rolling_roll(shots):
    # the friction of the cloth, and never that of a slide.
    slowing = [one.seen[0] for one in harvest(shots, POOL).rolling]
    assert slowing == pytest.approx([0.01 * 9.81] * len(slowing), rel=0.1)


def test_the_line_before_a_cushion_is_straight_but_for_rolling(shots):
    for one in harvest(shots, POOL).cushion:
        towards, along, side = one.given
        assert towards >= 0.14
        assert side == 0.0
        assert 0.0 < one.seen[0] < towards
        assert abs(one.seen[1]) < np.hypot(towards, along)
        assert 0.0 < one.gap < 1.0


def test_a_hit_is_seen_in_axes_along_the_way_of_the_ball():
    # The ball comes at an angle of 30 degrees, and hits the other full: both go on that way.
    angle = np.pi / 6.0
    way = np.array([np.cos(angle), np.sin(angle)])
    meets, speed = 1.5, 0.6
    before = np.minimum(TIMES - meets, 0.0) * speed
    after = np.maximum(TIMES - meets, 0.0)
    rest = np.array([1.2, 0.6])
    touch = rest - 2.0 * POOL.radius * way
    struck = touch + np.outer(before + 0.1 * after, way)
    other = rest + np.outer(0.4 * after, way)
    (hit,) = harvest({"1": {"a": Track(TIMES, struck), "b": Track(TIMES, other)}}, POOL).hit
    assert hit.given[1:] == pytest.approx([0.0, speed, 0.0, 0.0], abs=1e-9)
    assert hit.seen[[2, 3, 6, 7]] == pytest.approx([0.1, 0.0, 0.4, 0.0], abs=1e-9)
    assert hit.seen[[1, 5]] == pytest.approx([0.0, 0.0], abs=1e-9)


def test_a_ball_that_is_left_out_while_it_rests_can_be_hit(shots):
    left_out = synthetic_tracks(PHYSICS, 60, 4, noise=1e-4, stale=0.0, resting=False)
    found = {one.shot for one in harvest(left_out, POOL).hit}
    assert found
    assert found <= {one.shot for one in harvest(shots, POOL).hit}
