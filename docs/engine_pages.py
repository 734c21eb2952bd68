"""The page of an engine: what is committed of it, gathered; and the hook that colours the board."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from pathlib import Path

from benchmarks.measurements import committed, committed_files
from benchmarks.pictures.gallery import committed_board
from benchmarks.rebounds import ReboundsMeasurement
from docs.replay_pages import replay_link
from docs.tables import any_engine, table
from ghostball.cli.show.lists import recipe_names, recipe_of
from ghostball.reference_adapters import engine_class, engine_names
from ghostball.reports.board import LOOKS, cell_text, columns_of, measured, move_text
from ghostball.validation.board.board import Board, command
from ghostball.validation.board.column import FAULTS, Column
from ghostball.validation.board.history import HISTORY, load_history, moves_of

DOCS = Path(__file__).resolve().parent

FAULTS_TITLE = "Reported faults"
FAULTS_ANCHOR = FAULTS_TITLE.lower().replace(" ", "-")

NAMED = {"physx": "sapien"}
"""What findings call an engine, where that isn't its name."""


def page(name: str) -> str:
    """Return all that is committed of an engine, as Markdown beneath its name."""
    board = committed_board()
    parts = [_about(name)]
    if board is not None:
        parts += _on_board(board, name)
    parts += [*_moved(name), *_beside_tables(name), *_faults(name), *_lacks(name), *_recipe(name)]
    return "\n\n".join(parts)


def cell_link(board: Board, row: str, column: Column) -> str:
    """Return a cell of the board that leads to what stands behind it, on its engine's page."""
    text = cell_text(board, row, column)
    cell = board.cell(row, column.id)
    if cell is None or not text:
        return text
    said = f"{row}, {column.id}: {LOOKS[cell.kind].says}".replace('"', "'")
    place = column.id if column.thread is None else FAULTS_ANCHOR
    return f'[{text}](engines/{row.partition(":")[0]}.md#{place} "{said}")'


def coloured(html: str) -> str:
    """Return the site's board: its cells coloured, sortable, and leading to their replays."""
    board = committed_board()
    if board is None:
        return html

    def cell(found: re.Match[str]) -> str:
        one = board.cell(found[2], found[3])
        if one is None:
            return found[0]
        size = "" if one.size is None else repr(one.size)
        look = f'style="background:{LOOKS[one.kind].paper}"'
        to = replay_link(found[2], found[3])
        link = found[1] if to is None else re.sub(r'href="[^"]*"', f'href="{to}"', found[1])
        return f'<td class="cell" {look} data-size="{size}">{link}'

    return re.sub(r'<td>(<a [^>]*title="([^",]+(?:,[^",]+=[^",]+)*), ([\w-]+): )', cell, html)


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


def _on_board(board: Board, name: str) -> Iterator[str]:
    rows = [row for row in board.rows if row.partition(":")[0] == name]
    if not rows:
        return
    where = dict.fromkeys(
        measured(board.environment_of(cell))
        for column in columns_of(board, reported=False)
        for row in rows
        if (cell := board.cell(row, column.id)) is not None
    )
    yield (
        "## On the board\n\n[The board](../leaderboard.md) has all engines. Measured on "
        f"{'; '.join(where)}."
    )
    for column in columns_of(board, reported=False):
        lines = []
        for row in rows:
            cell = board.cell(row, column.id)
            if cell is None:
                continue
            run = f"`{cell.label}` in `{cell.scene}`" if cell.scene else ""
            lines.append((f"`{row}`", cell_text(board, row, column), run, cell.note))
        if lines:
            again = next(c for row in rows if (c := board.cell(row, column.id)) is not None)
            yield (
                f"### {column.id}\n\n{column.question[0].upper()}{column.question[1:]}.\n\n"
                f"{table(('configuration', 'found', 'run', 'what it is'), lines)}\n\n"
                f"Measured again, with a replay on the page that `ghostball report` writes of its "
                f"folder, by `{command(again)}`."
            )


def _moved(name: str) -> Iterator[str]:
    """Say what moved on the board since it was first measured, and between which versions."""
    paths = committed_files(HISTORY)
    known = [
        one
        for one in (load_history(paths[0].parent) if paths else ())
        if one.row.partition(":")[0] == name
    ]
    if not known:
        return
    versions = ", ".join(dict.fromkeys(one.version for one in known if one.version))
    lines = [
        f"- {one.when}: {move_text(move)}"
        for k, one in enumerate(known)
        for move in moves_of(known[:k], one)
    ]
    said = "\n".join(lines) or "Nothing moved on the board since it was first measured."
    yield f"## Its versions\n\nMeasured: {versions or 'of unknown version'}.\n\n{said}"


def _beside_tables(name: str) -> Iterator[str]:
    stored = committed(ReboundsMeasurement)
    rows = [one.row for one in (stored.best if stored else ()) if one.engine == name]
    if rows:
        heads = ("engine", "law of cushions", "best coefficients", "typical", "most")
        yield (
            "## Beside real tables\n\nHow near it comes to [rebounds of a match]"
            f"(../real-tables.md), in standard errors:\n\n{table(heads, rows)}"
        )


def _faults(name: str) -> Iterator[str]:
    board = committed_board()
    if board is None:
        return
    rows = [row for row in board.rows if row.partition(":")[0] == name]
    lines = [
        (f"[{one.title}]({one.thread})", f"`{row}`", cell_text(board, row, one), one.cure)
        for one in FAULTS.values()
        for row in rows
        if board.cell(row, one.id) is not None
    ]
    found = [
        f"[{path.stem}](../findings/{path.name})"
        for path in sorted((DOCS / "findings").glob(f"{NAMED.get(name, name)}-*.md"))
    ]
    if lines or found:
        parts = [f"## {FAULTS_TITLE}"] * bool(lines)
        heads = ("what was reported", "configuration", "found", "cure")
        parts += [table(heads, lines)] * bool(lines)
        parts += [f"Found here: {', '.join(found)}."] * bool(found)
        yield "\n\n".join(parts)


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
