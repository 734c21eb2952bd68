"""Check whether pybullet can be imported, and import it without its output."""

from __future__ import annotations

import functools
import importlib
import importlib.util
import os
import sys
from typing import Any

from ghostball.reference_adapters.base import EngineError


def unavailable() -> str | None:
    """Return why pybullet can't be imported here and how to install it, or None."""
    if importlib.util.find_spec("pybullet") is not None:
        return None
    if sys.version_info >= (3, 12):
        found = f"{sys.version_info.major}.{sys.version_info.minor}"
        return (
            f"pybullet isn't installed: it has no wheels above Python 3.11, and this is {found}. "
            "Use an environment with Python 3.11, or install pybullet from conda-forge"
        )
    return "pybullet isn't installed. Run `python -m pip install pybullet`"


@functools.cache
def load() -> Any:
    """Import pybullet without its output, and return the module.

    Raises `EngineError` if pybullet isn't installed.

    During the import, pybullet writes its build time from C to descriptor 2, bypassing
    `sys.stderr`, so the descriptor is redirected during the import. Exceptions are unaffected.
    """
    reason = unavailable()
    if reason is not None:
        raise EngineError(f"engine `pybullet` is unavailable: {reason}")
    sys.stderr.flush()
    kept = os.dup(2)
    try:
        with open(os.devnull, "wb") as nowhere:
            os.dup2(nowhere.fileno(), 2)
        return importlib.import_module("pybullet")
    finally:
        os.dup2(kept, 2)
        os.close(kept)
