"""Where Ghostball keeps what it would otherwise make again: each cache in a folder of its own."""

from __future__ import annotations

import os
from pathlib import Path

CHOSEN = "GHOSTBALL_CACHE_DIR"
"""The variable of the environment that names another folder for all of them."""


def cache_folder(name: str) -> Path:
    """Return the folder of one cache: `libraries`, `pages`, `proofs`, `revisions` or `workers`.

    The folder that holds them may have been chosen by the user, who may keep other things in it:
    nothing is written, and nothing removed, outside the folders of our own.
    """
    chosen = os.environ.get(CHOSEN)
    if chosen:
        return Path(chosen) / name
    from platformdirs import user_cache_path  # noqa: PLC0415 - not whenever an engine is imported

    return user_cache_path("ghostball") / name
