"""One shot's arrays in one block of memory: what a shot begins with, and room to work in.

A block is packed once from a scene's arrays. Each shot begins with a copy of the whole of its first
part, so that no array can be forgotten: not by a sweep that plays one shot after another, and not
when an array is added. The second part is scratch: nothing in it is read before it is written.
Kernels split a block again in `event_loop.unpack`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ghostball.engine.core.state import Balls, Cells, FloatArray, IntArray, Pairs

# Indices of `Block.offsets`: how many balls there are, then where each array begins, in doubles.
# The first SCRATCH arrays are what a shot begins with.
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
TOUCHING = 16
NEAR = 17
TURNING = 18
RISING = 19
SERIES = 20
NODES = 21
TRACK = 22
END = 23


class Block:
    """The arrays of a scene in one block.

    `numbers` (k,) float64: all of them, each from a whole double on.
    `offsets` (END + 1,) int64: COUNT ... END above.
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
            balls.touching,
            balls.near,
            air and air.turning,
            air and air.rising,
            air and air.series,
            air and air.nodes,
            pairs.track,
        ]
        sizes = [0 if array is None else -(-array.nbytes // 8) for array in arrays]
        self.offsets: IntArray = np.array([len(balls.own_kind), *np.cumsum([0, *sizes])])
        self.numbers: FloatArray = np.zeros(self.offsets[END])
        for start, array in zip(self.offsets[1:], arrays, strict=False):
            if array is not None:
                bytes_of = self.numbers[start:].view(np.uint8)
                bytes_of[: array.nbytes] = np.ascontiguousarray(array).reshape(-1).view(np.uint8)
