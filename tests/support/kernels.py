"""The kernels as tests run them: called by Python, and, with bounds checked, in few variants.

Compiling a variant that leaves parts out takes most of what the whole costs, and its results are
the same to the bit. So where kernels are compiled for one test run, as under bounds checks, shots
run those with air and flight where they need either.
"""

from __future__ import annotations

import os
from collections.abc import Collection
from functools import cache
from typing import Any

import numpy as np
import pytest

from ghostball.engine import batch
from ghostball.engine.core import state as st
from ghostball.engine.core.contacts import no_contacts, numbers_of_contacts
from ghostball.engine.library.entry import COMPILED, Entry
from ghostball.engine.running import driver
from ghostball.engine.running.from_scene import Layout, layout_of, most_contacts
from ghostball.engine.running.skips import Skip, has_drag
from ghostball.model import Scene


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


interpreted = pytest.mark.skipif(
    COMPILED, reason="compiling its variants takes minutes, and changes no bit"
)


IN_AIR = frozenset((Skip.DRAG, Skip.FLIGHT))
"""What is switched off so that few variants do."""


def use_few_kernels() -> None:
    """Have all shots of this process run three variants of the kernels: with cells, in air, others.

    But not those of sweeps, whose scene has one layout for all.
    """

    def layout_of_few(scene: Scene, off: Collection[Skip] = frozenset()) -> Layout:
        flies = has_drag(scene) or scene.physics.airborne
        return layout_of(scene, IN_AIR.union(off) if flies else frozenset(off))

    for module in (batch, driver):
        changed: Any = module
        changed.layout_of = layout_of_few
