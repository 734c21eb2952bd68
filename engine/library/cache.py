"""The folder of libraries made on this machine, each named by a hash of everything it depends on.

The hash ensures that no outdated library is used, and lets several checkouts share libraries.
"""

from __future__ import annotations

import logging
import re
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from ghostball.model.cache_folder import cache_folder, last_use

logger = logging.getLogger("ghostball.engine")

KEPT = 400
"""Number of libraries kept: those of a dozen versions of sources or of flags, 0.1 MB each."""

UNUSED = 86_400.0
"""Time [s] after its last use during which no library is removed: a day."""

_OURS = re.compile(r"\w+-[0-9a-f]{20}\.(so|o|lock)")

_MARKER = "CACHEDIR.TAG"
_MARKED = b"""Signature: 8a477f597d28d172789f06886806bc55
# Compiled kernels of Ghostball, which removes those that have not been used for long.
"""
"""Content of the file that makes backup programs skip the folder.

It follows the Cache Directory Tagging Specification (bford.info/cachedir).
"""


@cache
def directory() -> Path | None:
    """Return the folder; on first use it is created.

    None if the folder can't be written. Kernels are then compiled again in each process, and a
    warning says so.
    """
    folder = cache_folder("libraries")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if not (folder / _MARKER).exists():
            (folder / _MARKER).write_bytes(_MARKED)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        logger.warning(
            "compiled kernels can't be kept in %s: %s. Every run will compile them again; set "
            "GHOSTBALL_CACHE_DIR to a directory that can be written",
            folder,
            error.strerror or type(error).__name__,
        )
        return None
    return folder


@contextmanager
def alone(path: Path) -> Iterator[None]:
    """Lock a library, so that no other process makes it at the same time."""
    from filelock import FileLock  # noqa: PLC0415 - only where something is made

    path.parent.mkdir(parents=True, exist_ok=True)  # another process may have removed it
    with FileLock(path.with_suffix(".lock")):
        yield


def prune(folder: Path) -> None:
    """Remove libraries beyond the `KEPT` last used ones that were not used within a day.

    Only files that have the name of a library are removed, in a folder that has our marker.
    """
    from filelock import FileLock, Timeout  # noqa: PLC0415 - only where something was made

    if not _is_ours(folder):
        return
    ours = [path for path in folder.iterdir() if _OURS.fullmatch(path.name)]
    libraries = [path for path in ours if path.suffix != ".lock" and not path.is_symlink()]
    libraries.sort(key=last_use, reverse=True)
    for path in libraries[KEPT:]:
        lock = FileLock(path.with_suffix(".lock"))
        with suppress(OSError, Timeout), lock.acquire(timeout=0):
            if last_use(path) < time.time() - UNUSED:
                path.unlink()


def _is_ours(folder: Path) -> bool:
    try:
        return (folder / _MARKER).read_bytes() == _MARKED
    except OSError:
        return False
