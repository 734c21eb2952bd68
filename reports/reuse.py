"""Which pictures and parts of a page needn't be made again: each says what it was made from.

A results folder may come from anyone, and a page may hold scripts: parts are taken from one only
that was written here, as the user's cache says, and that nobody changed since.
"""

from __future__ import annotations

import hashlib
import logging
import os
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from ghostball.model.cache_folder import cache_folder
from ghostball.validation.parallel.sources import (
    SourcesError,
    hash_sources,
    source_folders,
    version_of,
)
from ghostball.validation.results.database import name_text
from ghostball.validation.results.store import Results
from ghostball.validation.suite.unchanged import hash_of

_LIBRARIES = ("matplotlib", "numpy", "pillow", "jinja2", "markupsafe")
"""Distributions that decide how a picture or a page looks."""

KEPT = 100
"""Pages that are remembered; the ones written first are forgotten first."""

_LOGGER = logging.getLogger("ghostball.reports")


def drawn_from(results: Results, stored: Mapping[str, str]) -> dict[str, str]:
    """Return by scene a hash of all that is stored of it and of the code that shows it.

    `stored`: what `stored_hashes` said before `results` were read. So of what a run writes
        meanwhile a later report finds another hash.

    "" where the sources can't be found, or a case wasn't stored yet: what is made of it is made
    again the next time.

    The hash is generous: any edit of our sources has every picture drawn again.
    """
    cases = {
        scene: [stored.get(name_text((scene, label))) for label in results.labels]
        for scene in results.scene_names
    }
    return {
        scene: "" if None in hashes else made_from(_code(), scene, results.labels, hashes)
        for scene, hashes in cases.items()
    }


def made_from(source: str, *inputs: Any) -> str:
    """Return a hash of what has the hash `source` and of more plain values; "" of ""."""
    return hash_of([source, *inputs]) if source else ""


def is_drawn(stem: Path, endings: Sequence[str], source: str) -> bool:
    """Whether the files of a picture are there, drawn from what has the hash `source`.

    Both formats hold their description as plain text: PNG in a `tEXt` chunk, SVG in an element.
    """
    if not source:
        return False
    try:
        return all(
            source.encode() in stem.with_name(f"{stem.name}.{ending}").read_bytes()
            for ending in endings
        )
    except OSError:  # it isn't there, or can't be read: drawing it says so
        return False


def remember_page(content: bytes) -> None:
    """Remember that a page of this content was written here; where that can't be, say so."""
    name = _name_of(content)
    try:
        name.parent.mkdir(parents=True, exist_ok=True)
        name.touch()
        for path in sorted(name.parent.glob("page-*"), key=_written)[:-KEPT]:
            path.unlink(missing_ok=True)  # another process may have been faster
    except OSError as error:
        _LOGGER.warning(
            "%s: can't be written: %s. The next report is made anew as a whole",
            name.parent,
            error.strerror or type(error).__name__,
        )


def is_remembered(content: bytes) -> bool:
    """Whether a page of this content was written here."""
    return os.path.exists(_name_of(content))  # not of `Path`, which raises where it may not look


def _written(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except FileNotFoundError:
        return 0.0


def _name_of(content: bytes) -> Path:
    return cache_folder("pages") / f"page-{hashlib.sha256(content).hexdigest()}"


@cache  # modules stay in memory as they were loaded, whatever becomes of their files
def _code() -> str:
    try:
        sources = hash_sources((*source_folders(), Path(__file__).parent))
    except SourcesError:
        return ""
    return " ".join([sources, *(f"{name} {version_of(name)}" for name in _LIBRARIES)])
