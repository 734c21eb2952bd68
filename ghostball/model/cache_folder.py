"""Where Ghostball keeps what it would otherwise make again: each cache in a folder of its own."""

from __future__ import annotations

import os
from pathlib import Path

import platformdirs

CHOSEN = "GHOSTBALL_CACHE_DIR"
"""The variable of the environment that names another folder for all of them."""


def cache_folder(name: str) -> Path:
    """Return the folder of one cache: `libraries`, `pages`, `proofs`, `revisions` or `workers`.

    The folder that holds them may have been chosen by the user, who may keep other things in it:
    nothing is written, and nothing removed, outside the folders of our own.
    """
    chosen = os.environ.get(CHOSEN)
    return (Path(chosen) if chosen else Path(platformdirs.user_cache_dir("ghostball"))) / name
