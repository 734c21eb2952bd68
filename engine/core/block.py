"""All arrays of one shot in one block of memory: the initial state, and working memory.

A block is packed once from the arrays of a scene. Each shot starts with a copy of the whole first
part, so no array can be forgotten, neither when a sweep simulates one shot after another nor when
an array is added. The second part is scratch: nothing in it is read before it is written. In
kernels, `event_loop.unpack` splits a block into arrays again.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ghostball.engine.core.contacts import no_contacts, numbers_of_contacts
from ghostball.engine.core.rows import MEMBER_COLUMNS
from ghostball.engine.core.state import Balls, Cells, FloatArray, IntArray, Pairs
from ghostball.engine.library.reached import REFERENCE_WORDS

# Indices of `Block.offsets`: the number of balls, then the start of each array, in doubles. The
# arrays before SCRATCH are the initial state of a shot.
COUNT = 0
STATE = 1
OWN_KIND = 2
CHANGED = 3
TOUCHED = 4
POWERS = 5
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
CONTACT_MARKS = 16
CONTACT_INTEGERS = 17
MEMBERS = 18
SCRATCH = 19
FORCES = 19
TOUCHING = 20
NEAR = 21
SERIES = 22
TRACK = 23
CONTACTS = 24
END = 25


class Block:
    """The arrays of a scene in one block.

    `numbers` (k,) float64: the initial state of a shot; each array starts at a whole double.
    `offsets` (END + 1,) int64: see COUNT ... END; a shot needs memory for `offsets[END]` doubles.
    """

    def __init__(self, balls: Balls, pairs: Pairs, cells: Cells | None, contacts: int) -> None:
        """Pack the arrays, with memory for a number of `contacts`."""
        n = len(balls.own_kind)
        marks, integers = no_contacts(n, contacts)
        members = n * MEMBER_COLUMNS
        # Each part is an array, or a number of doubles. From SCRATCH on only the size is used.
        parts: list[NDArray[Any] | int | None] = [
            balls.state,
            balls.own_kind,
            balls.changed,
            balls.touched,
            balls.powers,
            balls.height,
            pairs.bound,
            pairs.least,
            pairs.next,
            *(cells or (None,) * len(Cells._fields)),
            marks,
            integers,
            members,
            numbers_of_contacts(n, contacts) - members,
            balls.touching,
            balls.near,
            balls.series,
            pairs.track,
            REFERENCE_WORDS,
        ]
        sizes = [_size_of(part) for part in parts]
        self.offsets: IntArray = np.array([n, *np.cumsum([0, *sizes])])
        self.numbers: FloatArray = np.zeros(self.offsets[SCRATCH])
        for start, part in zip(self.offsets[STATE:SCRATCH], parts, strict=False):
            if isinstance(part, np.ndarray):
                bytes_of = self.numbers[start:].view(np.uint8)
                bytes_of[: part.nbytes] = np.ascontiguousarray(part).reshape(-1).view(np.uint8)

    def begun(self, state: FloatArray, height: FloatArray | None) -> Block:
        """Return a copy of this block with another initial state and height of the balls."""
        made = Block.__new__(Block)
        made.offsets, made.numbers = self.offsets, self.numbers.copy()
        made.numbers[self.offsets[STATE] : self.offsets[STATE] + state.size] = state.reshape(-1)
        if height is not None:
            start = self.offsets[HEIGHT]
            made.numbers[start : start + height.size] = height.reshape(-1)
        return made


def _size_of(part: NDArray[Any] | int | None) -> int:
    """Return the number of doubles that an array takes; a number stands for itself."""
    if part is None:
        return 0
    return part if isinstance(part, int) else -(-part.nbytes // 8)
