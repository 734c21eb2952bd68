"""What `ghostball leaderboard` does: run the board's scenes and show what they come to."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ghostball.cli.measure.verdicts import failures, headline
from ghostball.cli.shared.options import Plain, check_plot
from ghostball.cli.shared.progress import COMPILING, Steps
from ghostball.cli.shared.tables import table_of
from ghostball.cli.shared.terminal import say, stdout
from ghostball.model import GhostballError
from ghostball.reference_adapters import parse_spec
from ghostball.reports import style
from ghostball.reports.board import LOOKS, about, draw_board, move_text, value_text
from ghostball.validation.board.board import ROWS, Board, command, run_board
from ghostball.validation.board.column import COLUMNS, FAULTS, LIKENESS, QUESTIONS, Column
from ghostball.validation.board.history import Move, entries_of, remember
from ghostball.validation.checks.verdict import not_judged
from ghostball.validation.exit_status import ExitStatus, worst
from ghostball.validation.suite.suite import Outcome

BESIDE = "real tables"
"""The step that puts engines beside real tables."""


def run(
    engine: Sequence[str] | None,
    only: bool,
    column: Sequence[str] | None,
    reported: bool,
    sort: str | None,
    out: Path,
    jobs: int,
    rerun: bool,
    time_limit: float,
    plot: Path | None,
    form: Plain,
) -> ExitStatus:
    """Measure, and return the exit status; see the options of the command."""
    if plot is not None:
        check_plot(plot)
    engines = tuple(engine or ())
    rows = engines if only else (*ROWS, *(one for one in engines if one not in ROWS))
    if not rows:
        raise GhostballError("`--only` needs at least one `--engine`")
    chosen = _chosen("--column", [*(column or ()), *(FAULTS if reported else ())])
    if sort is not None:
        _chosen("--sort", [sort])
    started = time.perf_counter()
    with Steps(COMPILING, "measuring", BESIDE).bar() as step:
        count, put = step("measuring"), step(BESIDE)
        board, outcome = run_board(
            rows,
            out,
            columns=chosen,
            jobs=jobs,
            rerun=rerun,
            time_limit=time_limit,
            progress=lambda done, planned, case: count(
                done, planned, f"{case.scene} on {case.label}"
            ),
            compiling=step(COMPILING),
            beside=lambda done, planned, one: put(done, planned, one.label),
        )
    asked = [row for row in dict.fromkeys(rows) if row not in board.absent]
    shown = [row for row in (board.sorted_rows(sort) if sort else asked) if row in asked]
    ids = {one.id for one in chosen}
    fresh = [one for one in board.cells if one.earlier is None and one.row in asked]
    moves = remember(out, entries_of(board, [one for one in fresh if one.column in ids]))
    failed = list(_failed_beside(board, shown, chosen))
    if plot is not None:
        with style.drawing():
            style.save_one(draw_board(board, chosen), plot, about(board))
    if form is Plain.JSON:
        typer.echo(_plain(board, shown, chosen, moves))
    else:
        console = stdout()
        for table in _blocks(board, shown, chosen, console):
            console.print(table, crop=False)
        for line in _reasons(board, [row for row in shown if row in engines], chosen):
            console.print(line, soft_wrap=True)
        for one in chosen:
            unit = f" [{one.unit}]" if one.unit else ""
            stdout().print(f"{one.id}{unit}: {one.question}", markup=False, style="dim")
        for move in moves:
            stdout().print(move_text(move), soft_wrap=True, markup=False)
        for line in (*([] if outcome is None else failures(outcome.cases)), *failed):
            stdout().print(line, soft_wrap=True)
        if outcome is not None:
            console.print(headline(outcome, time.perf_counter() - started), soft_wrap=True)
    counted = None if outcome is None else _without_settings(outcome)
    if why := not_judged([] if counted is None else counted.cases):
        say(f"[bold yellow]{escape(why)}[/]")
    for row, why in board.absent.items():
        say(f"[bold]{escape(row)}[/] is absent: {escape(why)}")
    return worst(
        ExitStatus.NOT_JUDGED if counted is None else counted.exit_status,
        ExitStatus.CHECK_FAILED if failed else ExitStatus.PASSED,
    )


def _without_settings(outcome: Outcome) -> Outcome:
    """Return the outcome with labels without settings.

    An engine counts as judged if one of its shots is, at any step that a column chose.
    """
    cases = [replace(one, label=parse_spec(one.label)[0]) for one in outcome.cases]
    return replace(outcome, cases=cases)


def _chosen(option: str, names: Sequence[str]) -> list[Column]:
    """Return the columns of these names, or those that distinguish engines where there is none."""
    for name in names:
        if name not in COLUMNS:
            raise GhostballError(f"`{option}` must be one of {', '.join(COLUMNS)}, got {name!r}")
    return [COLUMNS[name] for name in dict.fromkeys(names)] or list(QUESTIONS.values())


def _blocks(
    board: Board, rows: Sequence[str], columns: Sequence[Column], console: Console
) -> Iterator[Table]:
    """Yield the board as tables, each of as many columns as there is room for."""
    unlimited = console.options.update(width=1000)

    def made(some: Sequence[Column]) -> Table:
        table = _table(board, rows, some)
        # A cell that is cut short says nothing.
        table.width = console.measure(table, options=unlimited).maximum
        return table

    block: list[Column] = []
    for column in columns:
        if block and (made([*block, column]).width or 0) > console.width:
            yield made(block)
            block = []
        block.append(column)
    yield made(block)


def _reasons(board: Board, rows: Sequence[str], columns: Sequence[Column]) -> Iterator[str]:
    """Yield why cells of some rows are empty, each reason once."""
    for row in rows:
        empty: dict[str, list[str]] = {}
        for column in columns:
            cell = board.cell(row, column.id)
            if cell is not None and cell.note and not value_text(column, cell):
                empty.setdefault(cell.note, []).append(column.id)
        for note, names in empty.items():
            yield f"[dim]– of {escape(row)} in {', '.join(names)}: {escape(note)}[/]"


def _table(board: Board, rows: Sequence[str], columns: Sequence[Column]) -> Table:
    names = [column.id for column in columns]
    cells = ((escape(row), *(_shown(board, row, column) for column in columns)) for row in rows)
    return table_of(("engine", *names), cells, right=names, whole=("engine", *names))


def _failed_beside(board: Board, rows: Sequence[str], columns: Sequence[Column]) -> Iterator[str]:
    """Say which engines failed beside real tables: that is no case, which would say so."""
    for row, column in product(rows, columns):
        cell = board.cell(row, column.id) if column.metric == LIKENESS else None
        if cell is not None and cell.kind == "failed":
            where, why = escape(f"{column.title} on {row}"), escape(cell.note)
            yield f"[bold red]did not finish[/] {where}: {why}"


def _shown(board: Board, row: str, column: Column) -> str:
    cell = board.cell(row, column.id)
    if cell is None:
        return ""
    return f"[{LOOKS[cell.kind].terminal}]{escape(value_text(column, cell)) or '–'}[/]"


def _plain(
    board: Board, rows: Sequence[str], columns: Sequence[Column], moves: Sequence[Move]
) -> str:
    ids = [column.id for column in columns]
    cells = [cell for row in rows for name in ids if (cell := board.cell(row, name)) is not None]
    return json.dumps(
        {
            "environment": dict(board.environment),
            "absent": dict(board.absent),
            "moved": [
                {
                    "row": one.row,
                    "column": one.column,
                    "before": one.before.model_dump(),
                    "since": one.since.model_dump(exclude={"row", "cells"}),
                    "now": one.now.model_dump(),
                }
                for one in moves
            ],
            "rows": {
                row: {
                    cell.column: cell.model_dump() | {"again": command(cell)}
                    for cell in cells
                    if cell.row == row
                }
                for row in rows
            },
        },
        indent=1,
    )
