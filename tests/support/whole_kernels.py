"""Where kernels are compiled for one test run, every shot runs those with all their parts.

That is so under bounds checks, and without the optimiser. A variant that leaves parts out has no
lines of its own, and its results are the same to the bit (`test_skips.py`), so that nothing more is
found with it. Compiling it takes most of what it costs.
"""

from __future__ import annotations

from collections.abc import Collection
from functools import wraps
from typing import Any

import numba

from engine import _run
from engine._run import Run, Variant
from engine.scene import Scene
from engine.skips import Skip

PARTS = frozenset((Skip.CONTACTS, Skip.INTEGRATED_LAWS))
"""What is never left out."""


def checks_bounds() -> bool:
    """Whether kernels are compiled with every access to an array checked."""
    return bool(numba.config.BOUNDSCHECK) and not numba.config.DISABLE_JIT


def use_whole_kernels() -> None:
    """Have all shots of this process begin with contacts and with the laws that integrate.

    Sweeps of shots, which are a kernel of their own, go on as they are.
    """
    variant_of, make = _run.variant_of, Run.__init__

    @wraps(variant_of)
    def whole_variant(scene: Scene, contacts: bool, off: Collection[Skip] = frozenset()) -> Variant:
        return variant_of(scene, contacts, PARTS.union(off))

    @wraps(make)
    def make_whole(
        self: Run, scene: Scene, keep_log: bool, off: Collection[Skip] = frozenset()
    ) -> None:
        make(self, scene, keep_log, PARTS.union(off))

    changed: Any = _run
    changed.variant_of, changed.Run.__init__ = whole_variant, make_whole
