"""Figures of the whole run that needn't be drawn again: nothing that they are drawn from changed.

Beside the figures lies a note: a hash of all that they were drawn from, and of each file. They are
kept where both are still the same. The hash is generous: of the code of all packages, the libraries
and the machine, as `validation.unchanged` hashes them, and of every file of the results. Left out
is only what no figure shows: when and by which command the cases were run, whether they were taken
over from an earlier run, and the comparison with the baselines, whose run times are measured each
time.
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
from reports.style import FORMATS
from validation.files import hash_of_file, write_whole
from validation.store import ResultsFolder
from validation.unchanged import Code, hash_sources

NOTE = ".drawn.json"
"""The note, in the folder of the figures."""

NOT_SHOWN = ("report.md", "report.html", "regression.json", ".lock", "env.json", "results.jsonl")
"""Files of a results folder that aren't hashed as they are: no figure shows them, or not all."""

OF_THE_RUN = ("date", "command", "taken_over")
"""Entries of `env.json` that are of one run, and that no figure shows."""

_TAKEN_OVER = re.compile(rb'"taken_over":(?:true|false)')


def kept_figures(
    results: ResultsFolder, folder: PurePosixPath, asked: Collection[str]
) -> Drawn | None:
    """Return the figures that lie in `folder` of the results, or None where they must be drawn.

    Parameters
    ----------
    results : ResultsFolder
    folder : PurePosixPath
        Within that of the results.
    asked : collection of str
        Kinds of figures that would be drawn; a kind without anything to show has none.
    """
    try:
        note = json.loads((results.path / folder / NOTE).read_text(encoding="utf-8"))
        files = {name: str(found) for name, found in note["files"].items()}
        kinds = [str(kind) for kind in note["kinds"]]
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    drawn = {kind: folder / kind for kind in kinds}
    if files != _files(results.path, drawn) or note.get("inputs") != (
        inputs_hash(results, asked) or None
    ):
        return None
    return drawn


def keep_figures(
    results: ResultsFolder, folder: PurePosixPath, asked: Collection[str], drawn: Drawn
) -> None:
    """Note what the figures were drawn from, so that a next report may keep them."""
    inputs = inputs_hash(results, asked)
    if inputs:
        note = {"inputs": inputs, "kinds": list(drawn), "files": _files(results.path, drawn)}
        write_whole(results.path / folder / NOTE, json.dumps(note, indent=2) + "\n")


def inputs_hash(results: ResultsFolder, asked: Collection[str]) -> str:
    """Return the hash of all that figures are drawn from; "" where the code can't be told.

    That is so where a file of it was edited after it was loaded.
    """
    code, ours = Code.now().hash, Path(__file__).parent
    states = [path.stat() for path in ours.rglob("*.py")]
    changes = [one.st_mtime_ns if os.name == "nt" else one.st_ctime_ns for one in states]
    if not code or max(changes) > _IMPORTED_NS:
        return ""
    environment: dict[str, Any] = {
        key: value for key, value in results.environment.items() if key not in OF_THE_RUN
    }
    path = results.path
    # Several processes end their cases in any order; those taken over are in that of the plan.
    lines = sorted(_TAKEN_OVER.sub(b"", (path / "results.jsonl").read_bytes()).splitlines())
    inputs = {
        "code": [code, hash_sources([ours])],
        "versions": {name: version(name) for name in ("matplotlib", "pillow", "contourpy")},
        "asked": list(asked),
        "environment": environment,
        "cases": hashlib.sha256(b"\n".join(lines)).hexdigest(),
        "files": {
            name: hash_of_file(file)
            for file in sorted(path.rglob("*"))
            if (name := file.relative_to(path).as_posix()) not in NOT_SHOWN
            and not name.startswith("figures/")
            and file.is_file()
        },
    }
    return hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()


def _files(path: Path, drawn: Drawn) -> dict[str, str]:
    """Return the hash of each file of the figures; "" where it is missing."""
    files = [path / f"{stem}.{ending}" for stem in drawn.values() for ending in FORMATS]
    return {file.name: hash_of_file(file) if file.is_file() else "" for file in files}
