"""Tests of the block with all arrays of a shot: arrays start at whole doubles and don't overlap."""

from __future__ import annotations

import numpy as np
import pytest
from shots import ball, scene_of

from ghostball.engine.core import block as at
from ghostball.engine.core.block import Block
from ghostball.engine.running.from_scene import blank_balls, cells_of, pairs_of
from ghostball.engine.running.variants import Variant


@pytest.mark.parametrize("in_cells", [False, True])
def test_each_array_begins_where_the_one_before_ends(in_cells):
    """Use three balls, whose booleans and 32-bit integers don't fill whole doubles."""
    scene = scene_of(*(ball((float(k), 0.0)) for k in range(3)))
    balls, pairs = blank_balls(3, Variant.LEAN), pairs_of(0 if in_cells else 3)
    cells = cells_of(scene) if in_cells else None
    made = Block(balls, pairs, cells, 1)
    offsets = made.offsets
    assert (offsets[at.COUNT], offsets[at.STATE], offsets[at.SCRATCH]) == (3, 0, len(made.numbers))
    sizes = np.diff(offsets[at.STATE :])
    assert sizes[at.CHANGED - 1] == 1  # three bytes
    assert sizes[at.TOUCHED - 1] == 2  # four numbers of 32 bits
    assert sizes[at.BOUND - 1] == (0 if in_cells else 9)
    assert (sizes[at.FRAME - 1 : at.CONTACT_MARKS - 1] > 0).tolist() == [in_cells] * 6
    assert sizes[at.POWERS - 1] == sizes[at.HEIGHT - 1] == 0  # no ball flies, and there is no air
    changed = made.numbers[offsets[at.CHANGED] :].view(np.bool_)[:3]
    np.testing.assert_array_equal(changed, balls.changed)
