"""Helpers for tests that call kernels from Python."""

from __future__ import annotations

import os
from functools import cache
from typing import Any

import numpy as np
import pytest

from ghostball.engine.core import state as st
from ghostball.engine.core.contacts import no_contacts, numbers_of_contacts
from ghostball.engine.library.entry import COMPILED, Entry
from ghostball.engine.running.from_scene import most_contacts


def room_for_contacts(n: int) -> tuple[st.BoolArray, st.IntArray, st.FloatArray]:
    """Return the three empty arrays for the contacts of n balls."""
    m = most_contacts(n)
    marks, integers = no_contacts(n, m)
    return marks.copy(), integers.copy(), np.zeros(numbers_of_contacts(n, m))


@cache
def entry_to(inner: Any) -> Any:
    """Return a compiled kernel that calls `inner`; if kernels are interpreted, `inner` itself."""
    return Entry(inner) if COMPILED and not isinstance(inner, Entry) else inner


def checks_bounds() -> bool:
    """Return True if kernels are compiled with checks of array bounds."""
    return COMPILED and os.environ.get("NUMBA_BOUNDSCHECK", "0") not in ("", "0")


interpreted = pytest.mark.skipif(COMPILED, reason="it needs interpreted kernels")
