"""Tests of the three arrays that store all arrays of contacts: no overlap, and no unused number."""

from __future__ import annotations

import numpy as np
import pytest
from kernels import room_for_contacts

from ghostball.engine.core.contacts import contacts_in, numbers_of_contacts
from ghostball.engine.core.rows import COMPLIANCE_COLUMNS, MEMBER_COLUMNS
from ghostball.engine.core.state import MOST_DIRECT


@pytest.mark.parametrize("n", [1, 2, 7])
def test_each_array_has_its_own_part(n):
    room = room_for_contacts(n)
    contacts = contacts_in(*room)
    for whole in room:
        whole[:] = 0
        for one in contacts:
            if isinstance(one, np.ndarray) and one.dtype == whole.dtype:
                one[:] += whole.dtype.type(1)
    marks, integers, numbers = room
    assert np.all(marks)
    assert np.all(integers == 1)
    # These two arrays have rows only, without a matrix that shares their memory.
    rows = n * MEMBER_COLUMNS + 2 * MOST_DIRECT * COMPLIANCE_COLUMNS
    assert len(numbers) == numbers_of_contacts(n, len(contacts.columns))
    assert np.bincount(numbers.astype(np.int64)).tolist() == [rows, len(numbers) - rows]
