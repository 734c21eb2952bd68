"""The oracle's root finder where random shots don't lead it.

All else of it is checked by `test_api.py`: proofs hold the closed forms' answers, and the oracle's.
"""

from __future__ import annotations

import pytest
from mpmath import mp, mpf, workdps
from oracle import first_entry

TINY = mpf(10) ** -40


@pytest.fixture(autouse=True)
def _fifty_digits():
    with workdps(50):
        yield


def test_the_first_entering_root_where_the_balls_overlap_and_leave():
    # (s - 1)(s - 2)(s - 3): negative up to 1, positive from 1 to 2, so that the entry is at 2.
    assert abs(first_entry([mpf(-6), mpf(11), mpf(-6), mpf(1)], mpf(10)) - 2) < TINY


def test_two_roots_a_hair_apart_are_a_collision_and_a_hair_less_is_a_miss():
    hair = mpf(10) ** -20
    root = first_entry([1 - hair, mpf(-2), mpf(1)], mpf(10))
    assert abs(root - (1 - mp.sqrt(hair))) < TINY
    assert first_entry([1 + hair, mpf(-2), mpf(1)], mpf(10)) is None
