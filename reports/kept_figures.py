"""Figures of the whole run that needn't be drawn again: nothing that they are drawn from changed.

Beside the figures lies a note: a hash of all that they were drawn from, and of each file. They are
kept where both are still the same. The hash is generous: of the code of all packages, the libraries
and the machine, as `validation.unchanged` hashes them, and of every file of the results that a
figure may read. Of these, only what no figure shows is left out: when and by which command the
cases were run, and whether they were taken over from an earlier run.

The hash is taken before anything is read and again after all is drawn: where they differ, something
changed meanwhile, nobody knows which figure shows what, and no note is written.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Collection
from importlib.metadata import version
from pathlib import Path, PurePosixPath
from typing import Any

from engine import _IMPORTED_NS
from reports.markdown_parts import Drawn
from reports.stored import file_of
from reports.style import FORMATS
from validation.attribution import ATTRIBUTIONS_FILE
from validation.bench import PrecisionMeasurement, ScalingMeasurement
from validation.files import (
    ENVIRONMENT_FILE,
    MOTION_FOLDER,
    RESULTS_FILE,
    hash_of_file,
    write_whole,
)
from validation.predictability.store import PREDICTABILITY_FILE
from validation.unchanged import Code, hash_sources

NOTE = ".drawn.json"
"""The note, in the folder of the figures."""

READ = (
    ATTRIBUTIONS_FILE,
    PREDICTABILITY_FILE,
    *(file_of(kind) for kind in (PrecisionMeasurement, ScalingMeasurement)),
)
"""Files that figures of the run read where a results folder has them, beside cases and motions.

Ensembles have figures of their own, which are always drawn.
"""

DRAW = ("matplotlib", "pillow", "contourpy", "kiwisolver", "fonttools", "cycler")
"""Distributions that draw; `validation.unchanged` hashes those that compute."""

OF_THE_RUN = ("date", "command", "taken_over")
"""Entries of `env.json` that are of one run, and that no figure shows."""

_TAKEN_OVER = re.compile(rb'"taken_over":(?:true|false)')


def kept_figures(path: Path, folder: PurePosixPath, inputs: str) -> Drawn | None:
    """Return the figures that lie in `folder` of the results, or None where they must be drawn.

    Parameters
    ----------
    path : Path
        Of the results.
    folder : PurePosixPath
        Within that of the results.
    inputs : str
        What `inputs_hash` returned.
    """
    try:
        note = json.loads((path / folder / NOTE).read_text(encoding="utf-8"))
        files = {name: str(found) for name, found in note["files"].items()}
        kinds = [str(kind) for kind in note["kinds"]]
        noted = str(note["inputs"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    drawn = {kind: folder / kind for kind in kinds}
    if not inputs or noted != inputs or files != _files(path, drawn):
        return None
    return drawn


def keep_figures(
    path: Path, folder: PurePosixPath, asked: Collection[str], drawn: Drawn, before: str
) -> None:
    """Note what the figures were drawn from, so that a next report may keep them.

    Parameters
    ----------
    path : Path
        Of the results.
    folder : PurePosixPath
        Within that of the results.
    asked : collection of str
        Kinds of figures that were drawn; one without anything to show has none.
    drawn : dict
        The figures.
    before : str
        What `inputs_hash` returned before the results were read. Where it returns something else
        now, nothing is noted.
    """
    if before and before == inputs_hash(path, asked):
        note = {"inputs": before, "kinds": list(drawn), "files": _files(path, drawn)}
        write_whole(path / folder / NOTE, json.dumps(note, indent=2) + "\n")


def inputs_hash(path: Path, asked: Collection[str]) -> str:
    """Return the hash of all that figures of the results in `path` are drawn from.

    It is "" where the code can't be told, for a file of it was edited after it was loaded, and
    where the results can't be read: whoever loads them says why.
    """
    code, ours = Code.now().hash, Path(__file__).parent
    states = [file.stat() for file in ours.rglob("*.py")]
    changes = [one.st_mtime_ns if os.name == "nt" else one.st_ctime_ns for one in states]
    if not code or max(changes) > _IMPORTED_NS:
        return ""
    try:
        inputs = {
            "code": [code, hash_sources([ours])],
            "versions": {name: version(name) for name in DRAW},
            "asked": list(asked),
            **_results_read(path),
        }
    except (OSError, ValueError, TypeError):
        return ""
    return hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()


def _results_read(path: Path) -> dict[str, Any]:
    """Return the content, or hashes of it, of every file of the results that a figure may read."""
    environment = json.loads((path / ENVIRONMENT_FILE).read_text(encoding="utf-8"))
    # Several processes end their cases in any order; those taken over are in that of the plan.
    lines = sorted(_TAKEN_OVER.sub(b"", (path / RESULTS_FILE).read_bytes()).splitlines())
    files = [*sorted((path / MOTION_FOLDER).glob("*")), *(path / name for name in READ)]
    return {
        "environment": {key: environment[key] for key in environment if key not in OF_THE_RUN},
        "cases": hashlib.sha256(b"\n".join(lines)).hexdigest(),
        "files": {file.name: hash_of_file(file) for file in files if file.is_file()},
    }


def _files(path: Path, drawn: Drawn) -> dict[str, str]:
    """Return the hash of each file of the figures; "" where it is missing."""
    files = [path / f"{stem}.{ending}" for stem in drawn.values() for ending in FORMATS]
    return {file.name: hash_of_file(file) if file.is_file() else "" for file in files}
