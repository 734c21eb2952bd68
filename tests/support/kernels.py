"""The kernels as tests run them: called by Python, and, with bounds checked, in few variants.

Compiling a variant that leaves parts out takes most of what it costs, and its results are the same
to the bit. So where kernels are compiled for one test run, as under bounds checks, shots run those
with contacts and with the laws that integrate; and with air and flight, where they need either. The
few lines of its own that one without contacts has, where it finds that it needs them
(`engine/event_loop/resolve.py`), run interpreted: there a place beyond an array is an error, too.
"""

from __future__ import annotations

import os
from collections.abc import Collection
from functools import cache
from typing import Any

import pytest

from ghostball.engine import batch
from ghostball.engine.library.entry import COMPILED, Entry
from ghostball.engine.running import driver
from ghostball.engine.running.from_scene import Layout, layout_of
from ghostball.engine.running.skips import Skip, has_drag
from ghostball.model import Scene


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


begins_without_contacts = pytest.mark.skipif(
    checks_bounds(), reason="with bounds checked, all shots begin with contacts"
)


ON_CLOTH = frozenset((Skip.CONTACTS, Skip.INTEGRATED_LAWS))
IN_AIR = ON_CLOTH | {Skip.DRAG, Skip.FLIGHT}
"""What is switched off so that few variants do."""


def use_few_kernels() -> None:
    """Have all shots of this process run three variants of the kernels: with cells, in air, others.

    But not those of sweeps, whose scene has one layout for all.
    """

    def layout_of_few(scene: Scene, off: Collection[Skip] = frozenset()) -> Layout:
        flies = has_drag(scene) or scene.physics.airborne
        return layout_of(scene, (IN_AIR if flies else ON_CLOTH).union(off))

    for module in (batch, driver):
        changed: Any = module
        changed.layout_of = layout_of_few
