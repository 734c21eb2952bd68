"""Which pictures needn't be drawn again: each says in its file what it was drawn from."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ghostball.reports.shots import Shot
from ghostball.validation.parallel.sources import (
    SourcesError,
    hash_sources,
    source_folders,
    version_of,
)

_LIBRARIES = ("matplotlib", "numpy", "pillow")
"""Distributions that decide how a picture looks."""


def drawn_from(shot: Shot) -> str:
    """Return a hash of all that a picture of `shot` shows and of the code that draws it.

    "" where the sources can't be found: nothing is known of such a picture.

    The hash is generous: any edit of our sources has every picture drawn again.
    """
    code = _code()
    if not code:
        return ""
    digest = hashlib.sha256(code.encode())
    scene = shot.scene.model_dump(mode="json", by_alias=True)
    _add(digest, [scene, [(run.label, run.case, run.motion) for run in shot.runs]])
    return digest.hexdigest()


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


@cache  # modules stay in memory as they were loaded, whatever becomes of their files
def _code() -> str:
    try:
        sources = hash_sources((*source_folders(), Path(__file__).parent))
    except SourcesError:
        return ""
    return " ".join([sources, *(f"{name} {version_of(name)}" for name in _LIBRARIES)])


def _add(digest: Any, value: Any) -> None:
    """Add a value to a hash, with its kind and its length, so that no two values look alike."""
    if isinstance(value, np.ndarray):
        digest.update(f"array {value.dtype.descr} {value.shape} ".encode())
        digest.update(np.ascontiguousarray(value).tobytes())
    elif is_dataclass(value):
        parts = {field.name: getattr(value, field.name) for field in fields(value)}
        _add(digest, [type(value).__name__, parts])
    elif isinstance(value, Mapping):
        _add(digest, ["mapping", *sorted(value.items())])
    elif isinstance(value, (list, tuple)):
        digest.update(f"list {len(value)} ".encode())
        for each in value:
            _add(digest, each)
    elif isinstance(value, Enum):
        _add(digest, [type(value).__name__, value.name])
    else:
        digest.update(json.dumps(value, ensure_ascii=True).encode() + b" ")
