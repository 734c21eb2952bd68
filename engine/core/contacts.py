"""Three arrays in which all arrays of `Contacts` are stored, and how they are split."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from ghostball.engine.core.kernel import COMPILED
from ghostball.engine.core.rows import (
    COMPLIANCE,
    COMPLIANCE_COLUMNS,
    CONTACT,
    CONTACT_COLUMNS,
    MEMBER,
    MEMBER_COLUMNS,
    NUMBERS,
    PER_ROUND,
    REMEMBERED,
    STAGE,
    STAGE_COLUMNS,
    STAGES,
    ComplianceRow,
    ContactRow,
    MemberRow,
    StageRow,
    rows_of,
)
from ghostball.engine.core.state import (
    COMPRESSED_COLUMNS,
    FREE,
    MOST_DIRECT,
    NOWHERE,
    BoolArray,
    Contacts,
    FloatArray,
    IntArray,
)

_PATH = 2 * 6
_SPIN = 3 * 4
_HISTORY = (REMEMBERED + 1) * PER_ROUND
_AT_ONCE = MOST_DIRECT * (
    MOST_DIRECT + 2 * COMPLIANCE_COLUMNS + STAGE_COLUMNS + NUMBERS + STAGES * NUMBERS
)


@lru_cache(maxsize=8)
def no_contacts(n: int, m: int) -> tuple[BoolArray, IntArray]:
    """Return the marks and integers of n balls without contacts, with memory for m contacts.

    Their shapes are (3 n,) bool and (5 n + 8 m + 3,) int64. Calls share the arrays: don't modify
    them.
    """
    none, free = np.zeros(n, dtype=np.int64), np.arange(2 * m)
    kept = (np.full(n, FREE), np.arange(n), [0], none, none, np.full(n, NOWHERE), [2 * m], free)
    integers = np.concatenate((*kept, np.zeros(6 * m + 1, dtype=np.int64)))
    return np.zeros(3 * n, dtype=np.bool_), integers


def numbers_of_contacts(n: int, m: int) -> int:
    """Return how many float64 numbers n balls with m contacts need; `Contacts.motion` is first."""
    by_ball = MEMBER_COLUMNS + _PATH + _SPIN + COMPRESSED_COLUMNS
    return n * by_ball + m * (CONTACT_COLUMNS + _HISTORY) + _AT_ONCE


def contacts_in(marks: BoolArray, integers: IntArray, numbers: FloatArray) -> Contacts:
    """Return the `Contacts` whose arrays are views of these three arrays."""
    n = len(marks) // 3
    m = (len(integers) - 5 * n - 3) // 8
    held = 5 * n + 2 + 2 * m
    paths = n * MEMBER_COLUMNS
    spins = paths + n * _PATH
    forces = spins + n * _SPIN
    history = forces + m * CONTACT_COLUMNS
    matrix = history + m * _HISTORY
    compliances = matrix + MOST_DIRECT * MOST_DIRECT
    stage = compliances + 2 * MOST_DIRECT * COMPLIANCE_COLUMNS
    start = stage + MOST_DIRECT * STAGE_COLUMNS
    slopes = start + MOST_DIRECT * NUMBERS
    compressed = slopes + MOST_DIRECT * STAGES * NUMBERS
    members: Any = numbers[:paths]
    contacts: Any = numbers[forces:history]
    sides: Any = numbers[compliances:stage]
    states: Any = numbers[stage:start]
    by_member = members.reshape(n, MEMBER_COLUMNS)
    by_contact = contacts.reshape(m, CONTACT_COLUMNS)
    by_side = sides.reshape(2 * MOST_DIRECT, COMPLIANCE_COLUMNS)
    by_state = states.reshape(MOST_DIRECT, STAGE_COLUMNS)
    return Contacts(
        integers[:n],
        integers[n : 2 * n],
        marks[:n],
        integers[2 * n : 3 * n + 1],
        marks[n : 2 * n],
        marks[2 * n :],
        integers[3 * n + 1 : 4 * n + 1],
        integers[4 * n + 1 : 5 * n + 1],
        integers[held : held + 4 * m].reshape(2 * m, 2),
        integers[5 * n + 1 : held],
        members.view(MEMBER) if COMPILED else rows_of(by_member, MemberRow),
        numbers[paths:spins].reshape(n, 2, 6),
        numbers[spins:forces].reshape(n, 3, 4),
        integers[held + 4 * m : held + 6 * m].reshape(m, 2),
        contacts.view(CONTACT) if COMPILED else rows_of(by_contact, ContactRow),
        by_contact,
        numbers[history:matrix].reshape(m, REMEMBERED + 1, PER_ROUND),
        numbers[matrix:compliances].reshape(MOST_DIRECT, MOST_DIRECT),
        sides.view(COMPLIANCE) if COMPILED else rows_of(by_side, ComplianceRow),
        states.view(STAGE) if COMPILED else rows_of(by_state, StageRow),
        by_state,
        numbers[start:slopes].reshape(MOST_DIRECT, NUMBERS),
        numbers[slopes:compressed].reshape(MOST_DIRECT, STAGES, NUMBERS),
        integers[held + 6 * m :],
        numbers[compressed:].reshape(n, COMPRESSED_COLUMNS),
    )
