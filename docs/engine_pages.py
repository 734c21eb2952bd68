"""The page of an engine: what is committed of it, gathered."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from pathlib import Path

from benchmarks.board import BoardMeasurement
from benchmarks.measurements import committed
from benchmarks.rebounds import ReboundsMeasurement
from docs.tables import any_engine, table
from ghostball.cli.show.engines import recipe_names, recipe_of
from ghostball.reference_adapters import engine_class, engine_names

DOCS = Path(__file__).resolve().parent

NAMED = {"physx": "sapien"}
"""What findings call an engine, where that isn't its name."""


def page(name: str) -> str:
    """Return all that is committed of an engine, as Markdown beneath its name."""
    parts = [_about(name), *_on_board(name), *_beside_tables(name)]
    return "\n\n".join([*parts, *_findings(name), *_lacks(name), *_recipe(name)])


def write_pages() -> None:
    """Write the page of each engine, to be filled by `docs.outputs`, and the list of them."""
    for name in engine_names():
        code = f'from docs import engine_pages\n\nprint(engine_pages.page("{name}"))'
        text = f"# {name}\n\n<!-- run python\n{code}\n-->\n<!-- end -->\n"
        path = DOCS / "engines" / f"{name}.md"
        if not path.exists():
            path.write_text(text, encoding="utf-8")


def _about(name: str) -> str:
    module = inspect.getmodule(engine_class(name))
    said = (inspect.getdoc(module) or "").partition("\n\n")
    return f"{said[0]}\n\n{said[2].partition(chr(10) * 2)[0]}".strip()


def _on_board(name: str) -> Iterator[str]:
    stored = committed(BoardMeasurement)
    labels = [one for one in stored.labels if one.partition(":")[0] == name] if stored else []
    if stored is None or not labels:
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


def _beside_tables(name: str) -> Iterator[str]:
    stored = committed(ReboundsMeasurement)
    rows = [one.row for one in (stored.best if stored else ()) if one.engine == name]
    if rows:
        heads = ("engine", "law of cushions", "best coefficients", "typical", "most")
        yield (
            "## Beside real tables\n\nHow near it comes to [rebounds of a match]"
            f"(../real-tables.md), in standard errors:\n\n{table(heads, rows)}"
        )


def _findings(name: str) -> Iterator[str]:
    found = [
        f"[{path.stem}](../findings/{path.name})"
        for path in sorted((DOCS / "findings").glob(f"{NAMED.get(name, name)}-*.md"))
    ]
    if found:
        yield f"Found here: {', '.join(found)}."


def _lacks(name: str) -> Iterator[str]:
    known = any_engine(name).capabilities
    rows = [
        (feature.value, {"approximate": "nearly", "none": "no"}[one.support], one.how)
        for feature, one in known.items()
        if one.support != "exact"
    ]
    if rows:
        yield f"## What it doesn't represent exactly\n\n{table(('physics', '', 'how'), rows)}"


def _recipe(name: str) -> Iterator[str]:
    if name in recipe_names():
        yield f"## Its best settings, as code\n\n```python\n{recipe_of(name).rstrip()}\n```"


if __name__ == "__main__":
    write_pages()
