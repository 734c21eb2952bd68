"""Helpers for tests that call kernels from Python."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from ghostball.engine.core import state as st
from ghostball.engine.core.contacts import no_contacts, numbers_of_contacts
from ghostball.engine.library.entry import COMPILED, Entry
from ghostball.engine.library.reached import reached_by
from ghostball.engine.running.from_scene import most_contacts


def room_for_contacts(n: int) -> tuple[st.BoolArray, st.IntArray, st.FloatArray]:
    """Return the three empty arrays for the contacts of n balls."""
    m = most_contacts(n)
    marks, integers = no_contacts(n, m)
    return marks.copy(), integers.copy(), np.zeros(numbers_of_contacts(n, m))


@cache
def entry_to(inner: Any) -> Any:
    """Return `inner` compiled in this process, or `inner` itself if kernels are interpreted.

    Unlike an `Entry`, the result takes and returns named tuples.
    """
    if not COMPILED or isinstance(inner, Entry) or hasattr(inner, "py_func"):
        return inner
    from ghostball.engine.library import build

    return build._compilable(inner, reached_by(inner).functions, _in_process())


@cache
def _in_process() -> Any:
    """Return a compiler whose kernels Python can call."""
    import numba

    from ghostball.engine.library import plain_numba

    class InProcess(plain_numba.Plain):
        def dispatcher(self, function: Callable[..., Any], **options: Any) -> Any:
            options |= {"error_model": "numpy", "pipeline_class": plain_numba.Passes}
            return numba.njit(**options)(function)

    return InProcess()


def if_compiled(*values: Any) -> tuple[Any, ...]:
    """Return the values of a parameter of a test if kernels are compiled, otherwise none.

    For values that reach no further lines of the kernels: interpreted kernels are much slower, and
    give the same bits as compiled kernels.
    """
    return values if COMPILED else ()


def checks_bounds() -> bool:
    """Return True if kernels are compiled with checks of array bounds."""
    return COMPILED and os.environ.get("NUMBA_BOUNDSCHECK", "0") not in ("", "0")


interpreted = pytest.mark.skipif(COMPILED, reason="it needs interpreted kernels")
