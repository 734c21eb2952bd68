"""One shot's arrays in one block of memory: what a shot begins with, and room to work in.

A block is packed once from a scene's arrays. Each shot begins with a copy of the whole of its first
part, so that no array can be forgotten: not by a sweep that plays one shot after another, and not
when an array is added. The second part is scratch: nothing in it is read before it is written.
Kernels take a block apart again with `balls_in`, `pairs_in` and `cells_in`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

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

# Places in `Block.places`: how many balls there are, then where each array begins, in doubles. The
# first SCRATCH arrays are what a shot begins with.
COUNT = 0
STATE = 1
OWN_KIND = 2
CHANGED = 3
TOUCHED = 4
HIGHER = 5
HEIGHT = 6
BOUND = 7
LEAST = 8
NEXT = 9
FRAME = 10
SIZE = 11
FIRST = 12
LINK = 13
SLOT = 14
TREE = 15
SCRATCH = 16
HITS = 16
NEAR = 17
TURNING = 18
SERIES = 19
TRACK = 20
END = 21


class Block:
    """The arrays of a scene in one block.

    Attributes
    ----------
    numbers : (k,) float64
        All of them, each from a whole double on.
    places : (END + 1,) int64
        COUNT ... END above.
    """

    def __init__(self, balls: Balls, pairs: Pairs, cells: Cells | None) -> None:
        air = balls.air
        arrays: list[NDArray[Any] | None] = [
            balls.state,
            balls.own_kind,
            balls.changed,
            balls.touched,
            balls.higher,
            balls.height,
            pairs.bound,
            pairs.least,
            pairs.next,
            *(cells or (None,) * len(Cells._fields)),
            balls.hits,
            balls.near,
            air and air.turning,
            air and air.series,
            pairs.track,
        ]
        sizes = [0 if array is None else -(-array.nbytes // 8) for array in arrays]
        self.places: IntArray = np.array([len(balls.own_kind), *np.cumsum([0, *sizes])])
        self.numbers: FloatArray = np.zeros(self.places[END])
        for start, array in zip(self.places[1:], arrays, strict=False):
            if array is not None:
                bytes_of = self.numbers[start:].view(np.uint8)
                bytes_of[: array.nbytes] = np.ascontiguousarray(array).reshape(-1).view(np.uint8)


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
