"""Takes a block of arrays apart in the kernels; `core.block` says what lies where in it."""

from __future__ import annotations

import numpy as np

from ghostball.engine.core.block import (
    BOUND,
    CHANGED,
    COUNT,
    END,
    FIRST,
    FRAME,
    HEIGHT,
    HIGHER,
    HITS,
    LEAST,
    LINK,
    NEAR,
    NEXT,
    OWN_KIND,
    SCRATCH,
    SERIES,
    SIZE,
    SLOT,
    STATE,
    TOUCHED,
    TRACK,
    TREE,
    TURNING,
)
from ghostball.engine.core.kernel import COMPILED, kernel
from ghostball.engine.core.state import (
    BALL,
    HEIGHT_COLUMNS,
    LINK_COLUMNS,
    SERIES_ROWS,
    SERIES_TERMS,
    SLOT_COLUMNS,
    STATE_COLUMNS,
    Air,
    BallRow,
    Balls,
    Cells,
    FloatArray,
    IntArray,
    Pairs,
    rows_of,
)


@kernel(inline=True)
def start_from(numbers: FloatArray, start: FloatArray, places: IntArray) -> None:
    """Begin a shot in the block `numbers`, with all that is in the block `start`."""
    for k in range(places[SCRATCH]):
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
    """Return the `Balls` of a block; which of their last arrays there are is told, by None."""
    n = places[COUNT]
    state = numbers[places[STATE] : places[OWN_KIND]]
    rows = state.view(BALL) if COMPILED else rows_of(state.reshape(n, STATE_COLUMNS), BallRow)
    hits = numbers[places[HITS] : places[NEAR]].view(np.int32)
    return Balls(
        rows,
        numbers[places[OWN_KIND] : places[CHANGED]].view(np.int64),
        numbers[places[CHANGED] : places[TOUCHED]].view(np.bool_)[:n],
        numbers[places[TOUCHED] : places[HIGHER]].view(np.int32)[: n + 1],
        hits.reshape(len(hits) // 2, 2),
        numbers[places[NEAR] : places[TURNING]].view(np.int32)[:n],
        counters,
        _higher_in(numbers, places, bends),
        _air_in(numbers, places, drags),
        _height_in(numbers, places, flies),
    )


@kernel(inline=True)
def _higher_in(numbers: FloatArray, places: IntArray, bends: int | None) -> FloatArray | None:
    if bends is None:
        return None
    n, start, end = places[COUNT], places[HIGHER], places[HEIGHT]
    return numbers[start:end].reshape(n, (end - start) // n)


@kernel(inline=True)
def _air_in(numbers: FloatArray, places: IntArray, drags: int | None) -> Air | None:
    if drags is None:
        return None
    n, start, end = places[COUNT], places[TURNING], places[SERIES]
    series = numbers[end : places[TRACK]].reshape(SERIES_ROWS, SERIES_TERMS)
    return Air(numbers[start:end].reshape(n, (end - start) // n), series)


@kernel(inline=True)
def _height_in(numbers: FloatArray, places: IntArray, flies: int | None) -> FloatArray | None:
    if flies is None:
        return None
    return numbers[places[HEIGHT] : places[BOUND]].reshape(places[COUNT], HEIGHT_COLUMNS)


@kernel(inline=True)
def pairs_in(numbers: FloatArray, places: IntArray) -> Pairs:
    """Return the `Pairs` of a block."""
    return Pairs(
        numbers[places[BOUND] : places[LEAST]],
        numbers[places[LEAST] : places[NEXT]],
        numbers[places[NEXT] : places[FRAME]],
        numbers[places[TRACK] : places[END]],
    )


@kernel(inline=True)
def cells_in(numbers: FloatArray, places: IntArray) -> Cells:
    """Return the `Cells` of a block, `first` with what fills its last double.

    Contract: nothing of `numbers` is read, since a shot may not have begun in it.
    """
    n = places[COUNT]
    return Cells(
        numbers[places[FRAME] : places[SIZE]],
        numbers[places[SIZE] : places[FIRST]].view(np.int64),
        numbers[places[FIRST] : places[LINK]].view(np.int32),
        numbers[places[LINK] : places[SLOT]].view(np.int32).reshape(n, LINK_COLUMNS),
        numbers[places[SLOT] : places[TREE]].reshape(n, SLOT_COLUMNS),
        numbers[places[TREE] : places[SCRATCH]],
    )
