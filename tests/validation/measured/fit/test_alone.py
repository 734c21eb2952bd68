"""When a ball is alone, and has been for long enough."""

from __future__ import annotations

import numpy as np

from benchmarks.synthetic_tracks import POOL
from ghostball.validation.measured.fit.alone import has_rolled, is_free
from ghostball.validation.measured.tracks import Track

TIMES = np.arange(0.0, 3.0, 0.02)


def goes(x0: float, y0: float, vx: float, vy: float = 0.0) -> Track:
    return Track(TIMES, np.column_stack([x0 + vx * TIMES, y0 + vy * TIMES]))


def test_a_ball_is_free_where_nothing_is_near_and_it_is_seen():
    track = goes(0.5, 0.6, 0.3)
    assert is_free(track, [], POOL, 0.5, 2.0)
    assert not is_free(track, [], POOL, 0.5, 4.0)  # its track ends
    assert not is_free(track, [goes(1.0, 0.6, 0.0)], POOL, 0.5, 2.0)
    assert not is_free(goes(0.5, 0.04, 0.3), [], POOL, 0.5, 2.0)  # along a cushion
    kept = (TIMES < 1.0) | (TIMES > 1.3)
    assert not is_free(Track(TIMES[kept], track.positions[kept]), [], POOL, 0.5, 2.0)


def test_a_fast_ball_must_have_gone_alone_for_longer():
    track = goes(0.1, 0.6, 0.5)
    assert has_rolled(track, [], POOL, 1.0, 0.5)
    assert not has_rolled(track, [], POOL, 1.0, 2.0)
