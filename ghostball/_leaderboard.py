"""What `ghostball leaderboard` does: measure the board and show it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Final

import typer
from rich import box
from rich.markup import escape
from rich.table import Table

from ghostball._progress import COMPILING, Steps
from ghostball._terminal import ExitStatus, say, stdout
from ghostball.engine import GhostballError
from ghostball.reports import style
from ghostball.reports.board import about, draw_board
from ghostball.validation.board.board import ROWS, Board, run_board, sorted_rows
from ghostball.validation.board.columns import COLUMNS, FAULTS, QUESTIONS, Cell, Worth

_COLOURS: Final[Mapping[Worth, str]] = {
    "good": "green",
    "fair": "yellow",
    "bad": "red",
    "design": "cyan",
    "none": "dim",
    "failed": "bold red",
}


def run(
    engines: Sequence[str],
    *,
    only: bool,
    columns: Sequence[str] | None,
    reported: bool,
    out: Path,
    jobs: int,
    rerun: bool,
    sort: str | None,
    plot: Path | None,
    as_json: bool,
) -> int:
    """Measure, and return the exit status; see the options of the command."""
    if sort is not None and sort not in COLUMNS:
        raise GhostballError(f"`--sort` must be one of {', '.join(COLUMNS)}, got {sort!r}")
    rows = tuple(engines) if only else (*ROWS, *(one for one in engines if one not in ROWS))
    if not rows:
        raise GhostballError("`--only` needs at least one `--engine`")
    chosen = [*(columns or ()), *(FAULTS if reported else ())] or list(QUESTIONS)
    with Steps(COMPILING, "measuring").bar() as step:
        count = step("measuring")
        board = run_board(
            rows,
            out,
            columns=chosen,
            jobs=jobs,
            rerun=rerun,
            progress=count,
            compiling=step(COMPILING),
        )
    if sort is not None:
        board = sorted_rows(board, sort)
    if plot is not None:
        with style.drawing():
            style.save_one(draw_board(board, chosen), plot, about(board))
    if as_json:
        typer.echo(json.dumps(_plain(board, chosen), indent=1))
    else:
        table, console = _table(board, chosen), stdout()
        # A cell that is cut short says nothing.
        table.width = console.measure(table, options=console.options.update(width=1000)).maximum
        console.print(table, crop=False)
        for name in chosen:
            column = COLUMNS[name]
            unit = f" [{column.unit}]" if column.unit else ""
            stdout().print(f"{name}{unit}: {column.asks}", markup=False, style="dim")
    for row, why in board.absent.items():
        say(f"[bold]{escape(row)}[/] is absent: {escape(why)}")
    failed = any(cell.worth == "failed" for cell in board.cells.values())
    return ExitStatus.CHECK_FAILED if failed else ExitStatus.PASSED


def _table(board: Board, columns: Sequence[str]) -> Table:
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("engine", no_wrap=True)
    for name in columns:
        table.add_column(name, justify="right", no_wrap=True)
    for row in board.rows:
        table.add_row(escape(row), *(_shown(board.cells.get((row, name))) for name in columns))
    return table


def _shown(cell: Cell | None) -> str:
    if cell is None:
        return ""
    return f"[{_COLOURS[cell.worth]}]{escape(cell.text) or '–'}[/]"


def _plain(board: Board, columns: Sequence[str]) -> dict[str, object]:
    return {
        "environment": dict(board.environment),
        "absent": dict(board.absent),
        "rows": {
            row: {
                name: asdict(cell) | {"again": board.command(row, name)}
                for name in columns
                if (cell := board.cells.get((row, name))) is not None
            }
            for row in board.rows
        },
    }
