"""Splits a block of arrays in the kernels; `core.block` says what lies where in it."""

from __future__ import annotations

import numpy as np

from ghostball.engine.core import block as at, state as st
from ghostball.engine.core.kernel import COMPILED, kernel
from ghostball.engine.core.rows import BALL, STATE_COLUMNS, BallRow, rows_of
from ghostball.engine.core.state import (
    Air,
    Balls,
    Cells,
    FloatArray,
    IntArray,
    Pairs,
)


@kernel(inline=True)
def start_from(numbers: FloatArray, start: FloatArray, places: IntArray) -> None:
    """Begin a shot in the block `numbers`, with all that is in the block `start`."""
    for k in range(places[at.SCRATCH]):
        numbers[k] = start[k]


@kernel(inline=True)
def balls_in(
    numbers: FloatArray,
    places: IntArray,
    counters: IntArray,
    bends: int | None,
    drags: int | None,
    flies: int | None,
) -> Balls:
    """Return the `Balls` of a block; which of their last arrays there are is said, by None."""
    n = places[at.COUNT]
    state = numbers[places[at.STATE] : places[at.OWN_KIND]]
    rows = state.view(BALL) if COMPILED else rows_of(state.reshape(n, STATE_COLUMNS), BallRow)
    pairs = numbers[places[at.TOUCHING] : places[at.NEAR]].view(np.int32)
    return Balls(
        rows,
        numbers[places[at.OWN_KIND] : places[at.CHANGED]].view(np.int64),
        numbers[places[at.CHANGED] : places[at.TOUCHED]].view(np.bool_)[:n],
        numbers[places[at.TOUCHED] : places[at.HIGHER]].view(np.int32)[: n + 1],
        pairs.reshape(len(pairs) // 2, 2),
        numbers[places[at.NEAR] : places[at.TURNING]].view(np.int32)[:n],
        counters,
        _higher_in(numbers, places, bends),
        _air_in(numbers, places, drags),
        _height_in(numbers, places, flies),
    )


@kernel(inline=True)
def _higher_in(numbers: FloatArray, places: IntArray, bends: int | None) -> FloatArray | None:
    if bends is None:
        return None
    n, start, end = places[at.COUNT], places[at.HIGHER], places[at.HEIGHT]
    return numbers[start:end].reshape(n, (end - start) // n)


@kernel(inline=True)
def _air_in(numbers: FloatArray, places: IntArray, drags: int | None) -> Air | None:
    if drags is None:
        return None
    n, start, end = places[at.COUNT], places[at.TURNING], places[at.SERIES]
    series = numbers[end : places[at.TRACK]].reshape(st.SERIES_ROWS, st.SERIES_TERMS)
    return Air(numbers[start:end].reshape(n, (end - start) // n), series)


@kernel(inline=True)
def _height_in(numbers: FloatArray, places: IntArray, flies: int | None) -> FloatArray | None:
    if flies is None:
        return None
    return numbers[places[at.HEIGHT] : places[at.BOUND]].reshape(
        places[at.COUNT], st.HEIGHT_COLUMNS
    )


@kernel(inline=True)
def pairs_in(numbers: FloatArray, places: IntArray) -> Pairs:
    """Return the `Pairs` of a block."""
    return Pairs(
        numbers[places[at.BOUND] : places[at.LEAST]],
        numbers[places[at.LEAST] : places[at.NEXT]],
        numbers[places[at.NEXT] : places[at.FRAME]],
        numbers[places[at.TRACK] : places[at.END]],
    )


@kernel(inline=True)
def cells_in(numbers: FloatArray, places: IntArray) -> Cells:
    """Return the `Cells` of a block, `first` with what fills its last double.

    Contract: nothing of `numbers` is read, since a shot may not have begun in it.
    """
    n = places[at.COUNT]
    return Cells(
        numbers[places[at.FRAME] : places[at.SIZE]],
        numbers[places[at.SIZE] : places[at.FIRST]].view(np.int64),
        numbers[places[at.FIRST] : places[at.LINK]].view(np.int32),
        numbers[places[at.LINK] : places[at.SLOT]].view(np.int32).reshape(n, st.LINK_COLUMNS),
        numbers[places[at.SLOT] : places[at.TREE]].reshape(n, st.SLOT_COLUMNS),
        numbers[places[at.TREE] : places[at.SCRATCH]],
    )
