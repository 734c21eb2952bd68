"""Split a block of arrays, in kernels; `core.block` describes the layout of a block."""

from __future__ import annotations

import numpy as np

from ghostball.engine.core import block as at, state as st
from ghostball.engine.core.contacts import contacts_in
from ghostball.engine.core.kernel import COMPILED, by_reference, kernel
from ghostball.engine.core.rows import BALL, STATE_COLUMNS, BallRow, rows_of
from ghostball.engine.core.state import (
    Balls,
    Cells,
    Contacts,
    FloatArray,
    IntArray,
    Pairs,
)


@kernel(inline=True)
def start_from(numbers: FloatArray, start: FloatArray, offsets: IntArray) -> None:
    """Start a shot in the block `numbers`, with the initial state in the block `start`."""
    for k in range(offsets[at.SCRATCH]):
        numbers[k] = start[k]


@kernel(inline=True)
def balls_in(
    numbers: FloatArray,
    offsets: IntArray,
    counters: IntArray,
    full: int | None,
) -> Balls:
    """Return the `Balls` of a block; their last arrays are None if `full` is None."""
    n = offsets[at.COUNT]
    state = numbers[offsets[at.STATE] : offsets[at.OWN_KIND]]
    rows = state.view(BALL) if COMPILED else rows_of(state.reshape(n, STATE_COLUMNS), BallRow)
    pairs = numbers[offsets[at.TOUCHING] : offsets[at.NEAR]].view(np.int32)
    powers, series, height = _full_in(numbers, offsets, full)
    return Balls(
        rows,
        numbers[offsets[at.OWN_KIND] : offsets[at.CHANGED]].view(np.int64),
        numbers[offsets[at.CHANGED] : offsets[at.TOUCHED]].view(np.bool_)[:n],
        numbers[offsets[at.TOUCHED] : offsets[at.POWERS]].view(np.int32)[: n + 1],
        pairs.reshape(len(pairs) // 2, 2),
        numbers[offsets[at.NEAR] : offsets[at.SERIES]].view(np.int32)[:n],
        counters,
        powers,
        series,
        height,
    )


_contacts_in = kernel(inline=True)(contacts_in)


@kernel(inline=True)
def contacts_from(numbers: FloatArray, offsets: IntArray) -> Contacts:
    """Return the `Contacts` of a block."""
    marks = numbers[offsets[at.CONTACT_MARKS] : offsets[at.CONTACT_INTEGERS]].view(np.bool_)
    integers = numbers[offsets[at.CONTACT_INTEGERS] : offsets[at.MEMBERS]].view(np.int64)
    reals = numbers[offsets[at.MEMBERS] : offsets[at.TOUCHING]]
    contacts = _contacts_in(marks[: 3 * offsets[at.COUNT]], integers, reals)
    made: Contacts = by_reference(contacts, numbers[offsets[at.CONTACTS] : offsets[at.END]])
    return made


@kernel(inline=True)
def _full_in(
    numbers: FloatArray, offsets: IntArray, full: int | None
) -> tuple[FloatArray | None, FloatArray | None, FloatArray | None]:
    """Return the last arrays of `Balls`, which the lean kernel doesn't have."""
    if full is None:
        return None, None, None
    n = offsets[at.COUNT]
    powers = numbers[offsets[at.POWERS] : offsets[at.HEIGHT]]
    series = numbers[offsets[at.SERIES] : offsets[at.TRACK]]
    height = numbers[offsets[at.HEIGHT] : offsets[at.BOUND]]
    return (
        powers.reshape(n, st.POWERS_COLUMNS),
        series.reshape(st.SERIES_ROWS, st.SERIES_TERMS),
        height.reshape(n, st.HEIGHT_COLUMNS),
    )


@kernel(inline=True)
def pairs_in(numbers: FloatArray, offsets: IntArray) -> Pairs:
    """Return the `Pairs` of a block."""
    return Pairs(
        numbers[offsets[at.BOUND] : offsets[at.LEAST]],
        numbers[offsets[at.LEAST] : offsets[at.NEXT]],
        numbers[offsets[at.NEXT] : offsets[at.FRAME]],
        numbers[offsets[at.TRACK] : offsets[at.CONTACTS]],
    )


@kernel(inline=True)
def cells_in(numbers: FloatArray, offsets: IntArray) -> Cells:
    """Return the `Cells` of a block; `first` includes the padding of its last double.

    They are empty if the scheduler works with `Pairs`.

    Contract: `numbers` isn't read, because it may not contain a shot yet.
    """
    links = numbers[offsets[at.LINK] : offsets[at.SLOT]].view(np.int32)
    slots = numbers[offsets[at.SLOT] : offsets[at.TREE]]
    return Cells(
        numbers[offsets[at.FRAME] : offsets[at.SIZE]],
        numbers[offsets[at.SIZE] : offsets[at.FIRST]].view(np.int64),
        numbers[offsets[at.FIRST] : offsets[at.LINK]].view(np.int32),
        links.reshape(len(links) // st.LINK_COLUMNS, st.LINK_COLUMNS),
        slots.reshape(len(slots) // st.SLOT_COLUMNS, st.SLOT_COLUMNS),
        numbers[offsets[at.TREE] : offsets[at.CONTACT_MARKS]],
    )
