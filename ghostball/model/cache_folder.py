"""Locate Ghostball's caches: a folder for each, for results that are expensive to recompute."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

CACHE_DIR_VARIABLE = "GHOSTBALL_CACHE_DIR"
"""Environment variable that selects a different parent folder for all caches."""


def cache_folder(name: str) -> Path:
    """Return the folder of a cache: `libraries`, `proofs`, `revisions` or `workers`.

    If the user has chosen the parent folder, it may contain other files. Ghostball writes and
    removes files only inside the folders of its caches.
    """
    chosen = os.environ.get(CACHE_DIR_VARIABLE)
    if chosen:
        return Path(chosen) / name
    from platformdirs import user_cache_path  # noqa: PLC0415 - imported only if needed

    return user_cache_path("ghostball") / name


def note_use(path: Path) -> None:
    """Store in the modification time of a file that it is used now."""
    with suppress(OSError):  # the file may belong to another user
        os.utime(path)


def last_use(path: Path) -> float:
    """Return when a file was last used, in seconds; 0 if the file is gone or not accessible."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0
