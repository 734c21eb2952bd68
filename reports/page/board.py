"""The board of engines as a section of the page: sortable, each cell with what lies behind it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from markupsafe import Markup

from ghostball.model.scene.toml import dumps
from ghostball.reports.board import (
    LOOKS,
    about,
    board_beside,
    cell_text,
    columns_of,
    looks_of,
    measured,
)
from ghostball.reports.page.rendering import embedded_json, render
from ghostball.reports.page.replay_data import motions_data
from ghostball.validation.board.asking import board_scene
from ghostball.validation.board.board import Board, command
from ghostball.validation.board.column import Column
from ghostball.validation.results.database import has_database
from ghostball.validation.results.motions import motion_of_case

_CAPTIONS: Final = {
    False: "Engines on the questions that distinguish them",
    True: "Engines on the faults that people reported",
}


def board_html(results: Path) -> Markup:
    """Return the board that lies in a results folder, as a table; "" where there is none."""
    board = board_beside(results)
    if board is None:
        return Markup()
    tables = []
    for reported, caption in _CAPTIONS.items():
        if columns := columns_of(board, reported=reported):
            shown = [
                (
                    column,
                    [dumps(board_scene(name)) for name in column.scenes[:1]],
                    _replay(board, results / "board", column),
                )
                for column in columns
            ]
            rows = [(row, [_cell(board, row, column) for column in columns]) for row in board.rows]
            tables.append((caption, shown, rows))
    legend = [(one.slug, one.sign, one.says) for one in looks_of(board, board.columns)]
    return render("board.html", about=about(board), legend=legend, tables=tables)


def _replay(board: Board, folder: Path, column: Column) -> Markup | None:
    """Return the data of a column's replay, or None where nothing is to be seen."""
    if not (column.replay and column.scenes) or not has_database(folder):
        return None
    cells = [cell for row in board.rows if (cell := board.cell(row, column.id)) and cell.scene]
    found = {cell.row: motion_of_case(folder, cell.scene, cell.label) for cell in cells}
    motions = {row: motion for row, motion in found.items() if motion is not None}
    scene = board_scene(column.scenes[0])
    return embedded_json(motions_data(scene, motions)) if motions else None


def _cell(board: Board, row: str, column: Column) -> dict[str, Any]:
    cell = board.cell(row, column.id)
    shown = {"text": cell_text(board, row, column), "row": row, "name": column.id}
    if cell is None:
        return shown | {"kind": "", "value": "", "why": "not measured"}
    look = LOOKS[cell.kind]
    why = f"{row}: {column.question}. {look.says}" + (f" ({cell.note})" if cell.note else "")
    where = measured(board.environment_of(cell))
    return shown | {
        "kind": look.slug,
        "value": "" if cell.size is None else repr(cell.size),
        "why": f"{why}. Measured on {where}. Again: {command(cell)}",
    }
