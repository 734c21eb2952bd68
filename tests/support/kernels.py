"""The kernels as tests run them: called by Python."""

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
    """Return the three arrays of the contacts of n balls of which there are none yet."""
    m = most_contacts(n)
    marks, integers = no_contacts(n, m)
    return marks.copy(), integers.copy(), np.zeros(numbers_of_contacts(n, m))


@cache
def entry_to(inner: Any) -> Any:
    """Return a kernel that does what `inner` does, compiled; where none are it is that itself."""
    return Entry(inner) if COMPILED and not isinstance(inner, Entry) else inner


def checks_bounds() -> bool:
    """Whether kernels are compiled with every access to an array checked."""
    return COMPILED and os.environ.get("NUMBA_BOUNDSCHECK", "0") not in ("", "0")


interpreted = pytest.mark.skipif(COMPILED, reason="it needs kernels that Python runs")
