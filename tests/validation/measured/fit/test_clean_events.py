"""Clean events are found in tracks of a table with known physics."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.synthetic_tracks import POOL, synthetic_tracks
from ghostball.model import Physics
from ghostball.validation.measured.fit.clean_events import find_clean_events, has_rolled, is_free
from ghostball.validation.measured.tracks import Track

TIMES = np.arange(0.0, 3.0, 0.02)
PHYSICS = Physics(preset="pool")


@pytest.fixture(scope="module")
def shots():
    return synthetic_tracks(PHYSICS, 60, 4, noise=1e-4, stale=0.0)


def test_events_of_all_kinds_are_found_with_the_noise_of_the_tracker(shots):
    found = find_clean_events(shots, POOL)
    assert found.noise == pytest.approx(1e-4, rel=0.1)
    assert len(found.rolling) > 60
    assert len(found.cushion) > 20
    assert len(found.hit) > 2


def test_balls_that_count_as_rolling_roll(shots):
    # They decelerate by rolling friction, never by sliding friction.
    slowing = [one.seen[0] for one in find_clean_events(shots, POOL).rolling]
    assert slowing == pytest.approx([0.01 * 9.81] * len(slowing), rel=0.1)


def test_the_line_before_a_cushion_is_straight_but_for_rolling(shots):
    for one in find_clean_events(shots, POOL).cushion:
        towards, along, side = one.given
        assert towards >= 0.14
        assert side == 0.0
        assert 0.0 < one.seen[0] < towards
        assert abs(one.seen[1]) < np.hypot(towards, along)
        assert 0.0 < one.gap < 1.0


def test_a_hit_is_seen_in_axes_along_the_way_of_the_ball():
    # The ball moves at 30 degrees and hits the other ball full: both continue in this direction.
    angle = np.pi / 6.0
    way = np.array([np.cos(angle), np.sin(angle)])
    meets, speed = 1.5, 0.6
    before = np.minimum(TIMES - meets, 0.0) * speed
    after = np.maximum(TIMES - meets, 0.0)
    rest = np.array([1.2, 0.6])
    touch = rest - 2.0 * POOL.radius * way
    struck = touch + np.outer(before + 0.1 * after, way)
    other = rest + np.outer(0.4 * after, way)
    (hit,) = find_clean_events(
        {"1": {"a": Track(TIMES, struck), "b": Track(TIMES, other)}}, POOL
    ).hit
    assert hit.given[1:] == pytest.approx([0.0, speed, 0.0, 0.0], abs=1e-9)
    assert hit.seen[[2, 3, 6, 7]] == pytest.approx([0.1, 0.0, 0.4, 0.0], abs=1e-9)
    assert hit.seen[[1, 5]] == pytest.approx([0.0, 0.0], abs=1e-9)


def test_a_ball_that_is_left_out_while_it_rests_can_be_hit(shots):
    left_out = synthetic_tracks(PHYSICS, 60, 4, noise=1e-4, stale=0.0, resting=False)
    found = {one.shot for one in find_clean_events(left_out, POOL).hit}
    assert found
    assert found <= {one.shot for one in find_clean_events(shots, POOL).hit}


def goes(x0: float, y0: float, vx: float, vy: float = 0.0) -> Track:
    return Track(TIMES, np.column_stack([x0 + vx * TIMES, y0 + vy * TIMES]))


def test_a_ball_is_free_where_nothing_is_near_and_it_is_seen():
    track = goes(0.5, 0.6, 0.3)
    assert is_free(track, [], POOL, 0.5, 2.0)
    assert not is_free(track, [], POOL, 0.5, 4.0)  # the track ends
    assert not is_free(track, [goes(1.0, 0.6, 0.0)], POOL, 0.5, 2.0)
    assert not is_free(goes(0.5, 0.04, 0.3), [], POOL, 0.5, 2.0)  # a ball along a cushion
    kept = (TIMES < 1.0) | (TIMES > 1.3)
    assert not is_free(Track(TIMES[kept], track.positions[kept]), [], POOL, 0.5, 2.0)


def test_a_fast_ball_must_have_gone_alone_for_longer():
    track = goes(0.1, 0.6, 0.5)
    assert has_rolled(track, [], POOL, 1.0, 0.5)
    assert not has_rolled(track, [], POOL, 1.0, 2.0)
