"""The page of an engine: its recipe, its results and its declarations."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from benchmarks.board import BoardMeasurement
from benchmarks.measurements import measured
from docs.measured_tables import rebounds
from docs.tables import any_engine, table
from ghostball.cli.show.engines import recipe_names, recipe_of

DOCS = Path(__file__).resolve().parent

NAMED = {"physx": "sapien"}
"""The name of an engine in the files of findings, if it differs."""


def page(name: str) -> str:
    """Return the page of an engine beneath its introduction, as Markdown."""
    return "\n\n".join(_parts(name))


def _parts(name: str) -> Iterator[str]:
    if name in recipe_names():
        yield f"## Best settings as code\n\n```python\n{recipe_of(name).rstrip()}\n```"
    yield from _on_board(name)
    if measured_rows := rebounds(name):
        yield (
            "## Agreement with real tables\n\nDifference from the [rebounds of a match]"
            f"(../real-tables.md), in standard errors:\n\n{measured_rows}"
        )
    found = sorted((DOCS / "findings").glob(f"{NAMED.get(name, name)}-*.md"))
    if found:
        links = (f"[{path.stem}](../findings/{path.name})" for path in found)
        yield f"## Findings\n\nFaults that Ghostball found: {', '.join(links)}."
    rows = [
        (feature.value, {"approximate": "approximately", "none": "no"}[one.support], one.how)
        for feature, one in any_engine(name).capabilities.items()
        if one.support != "exact"
    ]
    if rows:
        heads = ("feature", "supported", "how, or why not")
        yield f"## Features not supported exactly\n\n{table(heads, rows)}"


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
    blanks = (
        ""
        if all(len(cases) == len(scenes) for cases in found)
        else "; an empty cell for a scene that was not measured"
    )
    heads = ("scene", *(f"`{label}`" for label in labels))
    yield (
        "## Results on the board\n\nRest error, or accuracy class, and run time in each scene of "
        f"[the board](../leaderboard.md), measured on {'; '.join(where)}. "
        f"`ghostball validate board -e {name}` measures them again. "
        "A dash stands for a scene that the engine doesn't support or did not finish, or that has "
        f"no independent reference{blanks}.\n\n"
        f'<div class="sortable" markdown="1">\n\n{table(heads, rows)}\n\n</div>'
    )
