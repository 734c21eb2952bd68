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

from ghostball.engine.core.contacts import no_contacts, numbers_of_contacts
from ghostball.engine.core.rows import MEMBER_COLUMNS
from ghostball.engine.core.state import Balls, Cells, FloatArray, IntArray, Pairs
from ghostball.engine.library.reached import REFERENCE_WORDS

# Indices of `Block.offsets`: how many balls there are, then where each array begins, in doubles.
# The first SCRATCH arrays are what a shot begins with.
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

    `numbers` (k,) float64: what a shot begins with, each array from a whole double on.
    `offsets` (END + 1,) int64: COUNT ... END above, for a room of `offsets[END]` doubles.
    """

    def __init__(self, balls: Balls, pairs: Pairs, cells: Cells | None, contacts: int) -> None:
        """Pack the arrays, with room for a number of `contacts`."""
        n = len(balls.own_kind)
        marks, integers = no_contacts(n, contacts)
        members = n * MEMBER_COLUMNS
        # An array, or a number of doubles. From SCRATCH on only the size counts.
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
        """Return a block whose balls begin otherwise: with these arrays of `Balls`."""
        made = Block.__new__(Block)
        made.offsets, made.numbers = self.offsets, self.numbers.copy()
        made.numbers[self.offsets[STATE] : self.offsets[STATE] + state.size] = state.reshape(-1)
        if height is not None:
            start = self.offsets[HEIGHT]
            made.numbers[start : start + height.size] = height.reshape(-1)
        return made


def _size_of(part: NDArray[Any] | int | None) -> int:
    """Return how many doubles an array takes, or a number of numbers."""
    if part is None:
        return 0
    return part if isinstance(part, int) else -(-part.nbytes // 8)
