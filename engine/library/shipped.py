"""The libraries that come with the package, and whether they fit it and this machine."""

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
"""Settings of numba, in the environment, that change the machine code."""

FROM_MODEL = (events, impact_laws, polynomial, rounding)
"""Modules of the model that kernels take constants and functions from."""

_ENGINE = Path(__file__).resolve().parent.parent
_ADAPTERS = _ENGINE.parent / "reference_adapters" / "stepping"


def flags() -> dict[str, str]:
    """Return the settings of numba that are made, of those that change the machine code."""
    names = (f"NUMBA_{flag}" for flag in FLAGS)
    return {name: os.environ[name] for name in names if name in os.environ}


def sources() -> str:
    """Return a hash of all files that kernels may be made of, and of where in the package they are.

    Coarser than what a kernel reaches, and the same on every version of Python.
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
    for module in FROM_MODEL:
        yield module.__name__, Path(inspect.getfile(module))


def manifest(files: dict[str, str]) -> dict[str, Any]:
    """Return what is written beside libraries that were made here: what they fit, and their files.

    `files`: the name of each library by `key_of` its kernel and arguments.
    """
    return {**_wanted(), "target": processor.target(), "files": files}


def _wanted() -> dict[str, Any]:
    return {"table": table.VERSION, "system": processor.system(), "sources": sources()}


def key_of(function: Any, kinds: table.Kind) -> str:
    """Return the name of a kernel for some kinds of arguments."""
    text = f"{function.__module__}:{function.__qualname__}{table.text_of(kinds)}"
    return hashlib.sha256(text.encode()).hexdigest()[:20]


@cache
def files() -> dict[str, Path]:
    """Return the libraries that came with the package, by `key_of`; none where they don't fit.

    Where there are some that don't, a message says why.
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
    """Have `files` return none from now on, in this process."""
    _say_aside(reason)
    files().clear()


def _say_aside(reason: str) -> None:
    logger.warning("the kernels that came with ghostball are set aside: %s", reason)


def why_not(found: dict[str, Any]) -> str | None:
    """Return why libraries with such a manifest can't be used here, or None."""
    if flags():
        return f"{', '.join(sorted(flags()))} asks for others"
    wanted = _wanted()
    for name, what in (
        ("table", "they are called in another way"),
        ("system", "they are for another system"),
        ("sources", "the sources were changed"),
    ):
        if found.get(name) != wanted[name]:
            return what
    if found["target"] == processor.WIDE and processor.target() != processor.WIDE:
        return f"they are for processors with {', '.join(sorted(processor.NEEDED))}"
    return None
