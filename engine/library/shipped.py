"""Shipped libraries of kernels, and whether they match the sources and this machine."""

from __future__ import annotations

import hashlib
import inspect
import json
import logging
import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from ghostball.engine.library import processor, table
from ghostball.model import events, impact_laws, rounding
from ghostball.model.trajectory import polynomial

logger = logging.getLogger("ghostball.engine")

FOLDER = Path(__file__).resolve().parent / "shipped"
MANIFEST = "manifest.json"

FLAGS = ("BOUNDSCHECK", "OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE")
"""Environment settings of numba that change the machine code."""

MODEL_MODULES = (events, impact_laws, polynomial, rounding)
"""Modules of the model from which kernels take constants and functions."""

_ENGINE = Path(__file__).resolve().parent.parent
_ADAPTERS = _ENGINE.parent / "reference_adapters" / "stepping"


def flags() -> dict[str, str]:
    """Return those settings of numba in the environment that change the machine code."""
    names = (f"NUMBA_{flag}" for flag in FLAGS)
    return {name: os.environ[name] for name in names if name in os.environ}


def sources() -> str:
    """Return a hash of the paths and contents of all files that kernels may depend on.

    It changes more often than a kernel's own hash, but is the same in every version of Python.
    """
    digest = hashlib.sha256()
    for name, path in sorted(_files()):
        digest.update(name.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def _files() -> Iterator[tuple[str, Path]]:
    for path in _ENGINE.rglob("*.py"):
        yield path.relative_to(_ENGINE).as_posix(), path
    for path in _ADAPTERS.glob("*.py"):
        yield f"{_ADAPTERS.name}/{path.name}", path
    for module in MODEL_MODULES:
        yield module.__name__, Path(inspect.getfile(module))


def manifest(files: dict[str, str]) -> dict[str, Any]:
    """Return the manifest of libraries made here: table version, system, sources, and file names.

    `files`: the file name of each library by `key_of`.
    """
    return {**_wanted(), "target": processor.target(), "files": files}


def _wanted() -> dict[str, Any]:
    return {"table": table.VERSION, "system": processor.system(), "sources": sources()}


def key_of(function: Any, kinds: table.Kind) -> str:
    """Return the key of a kernel for some kinds of arguments."""
    text = f"{function.__module__}:{function.__qualname__}{table.text_of(kinds)}"
    return hashlib.sha256(text.encode()).hexdigest()[:20]


@cache
def files() -> dict[str, Path]:
    """Return the shipped libraries by `key_of`; empty if they can't be used here.

    If there are libraries that can't be used, a message says why.
    """
    try:
        found = json.loads((FOLDER / MANIFEST).read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    reason = why_not(found)
    if reason is not None:
        _say_aside(reason)
        return {}
    return {key: FOLDER / name for key, name in found["files"].items()}


def set_aside(reason: str) -> None:
    """Make `files` return no libraries from now on, in this process."""
    _say_aside(reason)
    files().clear()


def _say_aside(reason: str) -> None:
    logger.warning("the shipped kernels are not used: %s", reason)


def why_not(found: dict[str, Any]) -> str | None:
    """Return why libraries with this manifest can't be used here, or None if they can."""
    if flags():
        return f"{', '.join(sorted(flags()))} requires other kernels"
    wanted = _wanted()
    for name, what in (
        ("table", "they have another calling interface"),
        ("system", "they are for another system"),
        ("sources", "the sources have changed"),
    ):
        if found.get(name) != wanted[name]:
            return what
    if found["target"] == processor.WIDE and processor.target() != processor.WIDE:
        return f"they are for processors with {', '.join(sorted(processor.NEEDED))}"
    return None
