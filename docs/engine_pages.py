"""The page of an engine: what is committed of it, gathered."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from pathlib import Path

from benchmarks.board import BoardMeasurement
from benchmarks.measurements import measured
from docs.measured_tables import rebounds
from docs.tables import any_engine, table
from ghostball.cli.show.engines import recipe_names, recipe_of
from ghostball.reference_adapters import engine_class

DOCS = Path(__file__).resolve().parent

NAMED = {"physx": "sapien"}
"""What findings call an engine, where that isn't its name."""


def page(name: str) -> str:
    """Return all that is committed of an engine, as Markdown beneath its name."""
    return "\n\n".join(_parts(name))


def _parts(name: str) -> Iterator[str]:
    paragraphs = (inspect.getdoc(inspect.getmodule(engine_class(name))) or "").split("\n\n")
    yield "\n\n".join(paragraphs[:2])
    yield from _on_board(name)
    if rows := rebounds(name):
        yield (
            "## Beside real tables\n\nDifference from the [rebounds of a match]"
            f"(../real-tables.md), in standard errors:\n\n{rows}"
        )
    found = sorted((DOCS / "findings").glob(f"{NAMED.get(name, name)}-*.md"))
    if found:
        links = (f"[{path.stem}](../findings/{path.name})" for path in found)
        yield f"Found here: {', '.join(links)}."
    rows = [
        (feature.value, {"approximate": "nearly", "none": "no"}[one.support], one.how)
        for feature, one in any_engine(name).capabilities.items()
        if one.support != "exact"
    ]
    if rows:
        yield f"## What it doesn't represent exactly\n\n{table(('physics', '', 'how'), rows)}"
    if name in recipe_names():
        yield f"## Its best settings, as code\n\n```python\n{recipe_of(name).rstrip()}\n```"


def _on_board(name: str) -> Iterator[str]:
    stored = measured(BoardMeasurement)
    labels = [one for one in stored.labels if one.partition(":")[0] == name]
    if not labels:
        return
    found = [stored.of(label) for label in labels]
    scenes = dict.fromkeys(scene for cases in found for scene in cases)
    rows = (
        (f"`{scene}`", *(cases[scene].text if scene in cases else "" for cases in found))
        for scene in scenes
    )
    said = "; ".join(stored.earlier.get(label, stored.where) for label in labels)
    where = dict.fromkeys(said.split("; "))
    heads = ("scene", *(f"`{label}`" for label in labels))
    yield (
        "## On the board\n\nRest error, or accuracy class, and run time in each scene of "
        f"[the board](../leaderboard.md). Measured on {'; '.join(where)}.\n\n"
        f"{table(heads, rows)}\n\n"
        f"`ghostball validate board -e {name}` measures it again."
    )
