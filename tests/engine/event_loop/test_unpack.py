"""Tests that kernels find in a block of arrays what was packed into it."""

from __future__ import annotations

import numpy as np
import pytest
from shots import ball, scene_of

from ghostball.engine.core import block as at
from ghostball.engine.core.block import Block
from ghostball.engine.core.rows import STATE_COLUMNS
from ghostball.engine.event_loop.unpack import balls_in, cells_in, pairs_in, start_from
from ghostball.engine.running.from_scene import blank_balls, cells_of, pairs_of
from ghostball.engine.running.variants import Variant

AIR = {"air_drag": 0.1, "motion": "sliding", "airborne": True}


def fill(parts):
    """Fill arrays with numbers that are all different."""
    arrays = [one for part in parts for one in (part if isinstance(part, tuple) else (part,))]
    for k, one in enumerate(one for one in arrays if one is not None):
        one[:] = (np.arange(one.size) * 7 + k).reshape(one.shape) % 100


@pytest.mark.parametrize("n", [1, 3, 6])
@pytest.mark.parametrize("physics", [{}, AIR], ids=["on the cloth", "in air"])
def test_every_array_comes_back(n, physics):
    scene = scene_of(*(ball((float(k), 0.0)) for k in range(n)), **physics)
    balls = blank_balls(n, Variant.FULL if physics else Variant.LEAN)
    pairs, cells = pairs_of.__wrapped__(n), cells_of(scene)
    fill([balls.state, *balls[1:6], *balls[7:]])
    fill(pairs)
    fill(cells)
    made = Block(balls, pairs, cells, 1)
    numbers = np.zeros(made.offsets[at.END])
    start_from(numbers, made.numbers, made.offsets)
    found = balls_in(numbers, made.offsets, balls.counters, 1 if physics else None)
    start, end = made.offsets[at.STATE], made.offsets[at.OWN_KIND]
    np.testing.assert_array_equal(made.numbers[start:end].reshape(n, STATE_COLUMNS), balls.state)
    for name in ("own_kind", "changed", "touched", "powers", "height"):
        np.testing.assert_array_equal(getattr(found, name), getattr(balls, name), name)
    for name in ("touching", "near"):  # scratch: the size is kept, but not the contents
        assert getattr(found, name).shape == getattr(balls, name).shape
    assert np.shape(found.series) == np.shape(balls.series)
    packed_pairs = pairs_in(numbers, made.offsets)
    for name in ("bound", "least", "next"):
        np.testing.assert_array_equal(getattr(packed_pairs, name), getattr(pairs, name))
    assert packed_pairs.track.shape == pairs.track.shape
    for name, one in cells_in(numbers, made.offsets)._asdict().items():
        packed = getattr(cells, name)  # `first` includes the padding of its last double
        np.testing.assert_array_equal(one.ravel()[: packed.size], packed.ravel(), name)


def test_a_shot_starts_with_everything_except_scratch():
    made = Block(blank_balls(2, Variant.LEAN), pairs_of(2), None, 1)
    numbers = np.full(made.offsets[at.END], np.nan)
    start_from(numbers, made.numbers, made.offsets)
    scratch = made.offsets[at.SCRATCH]
    np.testing.assert_array_equal(numbers[:scratch], made.numbers[:scratch])
    assert np.all(np.isnan(numbers[scratch:]))
    assert scratch < len(numbers)
