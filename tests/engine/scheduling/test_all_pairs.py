"""Tests of bounds computed for blocks of pairs: none is missing, and each is the expected root.

A missing bound rarely shows in a shot, because the event of another ball brings a new bound.
Therefore these tests compare hundreds of thousands of bounds directly.
"""

from __future__ import annotations

import numpy as np
import pytest
from kernels import entry_to

from ghostball.engine.core import state as st
from ghostball.engine.scheduling.all_pairs import (
    _bent_block,
    _bound_block,
    _meet_block,
    _Moving,
)

BLOCKS = 12_000
T = 1.0


def tracks(slowed: bool):
    """Return blocks of balls, and a ball for each block, which most balls of the block approach."""
    chance = np.random.default_rng(5)
    track = np.zeros((BLOCKS, st.TRACKS, st.TRACK_BALLS))
    turn = chance.uniform(0.0, 2.0 * np.pi, (BLOCKS, st.TRACK_BALLS))
    away = chance.uniform(0.3, 1.0, (BLOCKS, st.TRACK_BALLS)) * np.array(
        [np.cos(turn), np.sin(turn)]
    )
    mine = chance.normal(size=(BLOCKS, 6)) * [1.0, 1.0, 1.0, 1.0, 0.1 * slowed, 0.1 * slowed]
    towards = mine[:, 2:4, np.newaxis] - chance.uniform(
        1.0, 2.0, (BLOCKS, 1, st.TRACK_BALLS)
    ) * np.moveaxis(away, 0, 1)
    track[:, 2:4] = towards + 0.05 * chance.normal(size=(BLOCKS, 2, st.TRACK_BALLS))
    track[:, 4:6] = 0.1 * slowed * chance.normal(size=(BLOCKS, 2, st.TRACK_BALLS))
    track[:, 6] = T - chance.uniform(0.0, 0.1, (BLOCKS, st.TRACK_BALLS))
    ago = (T - track[:, 6])[:, np.newaxis]
    track[:, 0:2] = mine[:, 0:2, np.newaxis] + np.moveaxis(away, 0, 1) - ago * track[:, 2:4]
    track[:, 7] = chance.uniform(0.01, 0.05, (BLOCKS, st.TRACK_BALLS))
    track[:, 8] = T + chance.uniform(0.5, 5.0, (BLOCKS, st.TRACK_BALLS))
    return track, mine


def roots(track, mine, slowed):
    """Return when the gap or the distance of each pair first closes, by the school formula."""
    x, y, vx, vy, ax, ay, epoch, radius, own, _ = np.moveaxis(track, 1, 0)
    mx, my, mvx, mvy, max_, may = mine.T[:, :, np.newaxis]
    s = T - epoch
    rx, ry = x + s * (vx + 0.5 * ax * s) - mx, y + s * (vy + 0.5 * ay * s) - my
    ux, uy = vx + ax * s - mvx, vy + ay * s - mvy
    reach = radius + 0.03
    distance = np.hypot(rx, ry)
    if slowed:
        c, b = distance * (distance - reach), rx * ux + ry * uy
        a = 0.5 * (rx * (ax - max_) + ry * (ay - may))
    else:
        c, b, a = distance**2 - reach**2, 2.0 * (rx * ux + ry * uy), ux**2 + uy**2
    square = b * b - 4.0 * a * c
    with np.errstate(invalid="ignore"):
        both = (-b + np.array([1.0, -1.0])[:, None, None] * np.sqrt(square)) / (2.0 * a)
    first = np.min(np.where(both >= 0.0, both, np.inf), axis=0)
    clear = (c > 1e-6) & (np.abs(square) > 1e-6 * b * b)  # neither touching nor grazing
    end = np.minimum(own, T + 2.0)
    clear &= np.abs(T + first - end) > 1e-6
    return np.where(T + first <= end, T + first, np.inf), clear


@pytest.mark.compiled
@pytest.mark.parametrize("slowed", [True, False], ids=["slowed", "uniform"])
def test_no_bound_of_a_pair_is_missing(slowed):
    track, mine = tracks(slowed)
    expected, clear = roots(track, mine, slowed)
    found = np.empty((BLOCKS, st.TRACK_BALLS))
    kernel = entry_to(_bound_block if slowed else _meet_block)
    for k in range(BLOCKS):
        kernel(track[k].ravel(), found[k], T, _Moving(*mine[k].tolist(), 0.03, T + 2.0))
    assert np.count_nonzero(clear & np.isfinite(expected)) > 400_000
    assert np.array_equal(np.isfinite(found[clear]), np.isfinite(expected[clear]))
    due = clear & np.isfinite(expected)
    assert np.max(np.abs(found[due] - expected[due])) < 1e-7


@pytest.mark.compiled
def test_no_bound_of_a_pair_that_bends_is_late():
    """The gap is open until the bound, for any change of the accelerations within their limits."""
    track, mine = tracks(slowed=True)
    chance = np.random.default_rng(6)
    track[:, 9] = 10.0 ** chance.uniform(-4.0, 0.5, (BLOCKS, st.TRACK_BALLS))
    jerk = 10.0 ** chance.uniform(-4.0, 0.5, BLOCKS)
    found = np.empty((BLOCKS, st.TRACK_BALLS))
    kernel = entry_to(_bent_block)
    for k in range(BLOCKS):
        one = _Moving(*mine[k].tolist(), 0.03, T + 2.0)
        kernel(track[k].ravel(), found[k], T, one, float(jerk[k]), 2.0)
    x, y, vx, vy, ax, ay, epoch, radius, own, bent = np.moveaxis(track, 1, 0)
    mx, my, mvx, mvy, max_, may = mine.T[:, :, np.newaxis]
    s = T - epoch
    rx, ry = x + s * (vx + 0.5 * ax * s) - mx, y + s * (vy + 0.5 * ay * s) - my
    distance = np.hypot(rx, ry)
    rate = (rx * (vx + ax * s - mvx) + ry * (vy + ay * s - mvy)) / distance
    pull = (rx * (ax - max_) + ry * (ay - may)) / distance
    until = np.minimum(own, T + 2.0)
    due = np.isfinite(found)
    assert 400_000 < np.count_nonzero(due) < due.size
    for part in np.linspace(0.0, 1.0, 30):
        after = part * (np.where(due, found, until) - T)
        gap = distance - radius - 0.03 + after * (rate + 0.5 * pull * after)
        gap -= (bent * (s + after) ** 3 + jerk[:, np.newaxis] * after**3) / 6.0
        # A pair is due now if the jerks since its epoch may have closed its gap.
        assert np.all((gap > -1e-12) | (found == T))
