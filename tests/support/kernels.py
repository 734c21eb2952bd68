"""The kernels as tests run them: called by Python, and, with bounds checked, with all their parts.

Compiling a variant that leaves parts out takes most of what it costs, and its results are the same
to the bit. So where kernels are compiled for one test run, as under bounds checks, shots run those
with all parts. The few lines of its own that one without contacts has, where it finds that it needs
them (`engine/event_loop/resolve.py`), are run by one test: `begin_without_contacts` lets its shots
begin as they do elsewhere.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Collection
from functools import cache, wraps
from typing import TYPE_CHECKING, Any

from ghostball.engine.library.entry import COMPILED, Entry
from ghostball.engine.running import driver
from ghostball.engine.running.driver import Run
from ghostball.engine.running.skips import Skip
from ghostball.model import Scene

if TYPE_CHECKING:
    import pytest


@cache
def entry_to(inner: Any) -> Any:
    """Return a kernel that does what `inner` does, compiled; where none are it is that itself."""
    return Entry(inner) if COMPILED and not isinstance(inner, Entry) else inner


PARTS = frozenset((Skip.CONTACTS, Skip.INTEGRATED_LAWS))
"""What is never left out, where a test doesn't ask for it."""


def checks_bounds() -> bool:
    """Whether kernels are compiled with every access to an array checked."""
    return COMPILED and os.environ.get("NUMBA_BOUNDSCHECK", "0") not in ("", "0")


def begin_without_contacts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the shots of a test begin without contacts also where others don't."""
    monkeypatch.setattr(sys.modules[__name__], "PARTS", PARTS - {Skip.CONTACTS})


def use_whole_kernels() -> None:
    """Have all shots of this process begin with contacts and with the laws that integrate.

    But not those of sweeps, whose scene has one layout for all.
    """
    make = Run.__init__

    @wraps(make)
    def make_whole(
        self: Run, scene: Scene, keep_log: bool, off: Collection[Skip] = frozenset()
    ) -> None:
        make(self, scene, keep_log, PARTS.union(off))

    changed: Any = driver
    changed.Run.__init__ = make_whole
