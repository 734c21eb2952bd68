"""The board of engines as a section of the page: sortable, each cell with what lies behind it."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from markupsafe import Markup

from ghostball.engine.scene.toml import dumps
from ghostball.reports.board import WORTHS, about, board_beside, cell_text, columns_of
from ghostball.reports.page.rendering import embedded_json, inline, render
from ghostball.reports.page.replay_data import motions_data
from ghostball.validation.board.board import Board
from ghostball.validation.board.columns import COLUMNS, FAULTS, QUESTIONS, Worth
from ghostball.validation.board.reported import REPORTED
from ghostball.validation.results.database import has_database
from ghostball.validation.results.motions import motion_of_side

_CLASSES: Final[dict[Worth, str]] = {
    "good": "pass",
    "fair": "holds",
    "bad": "fail",
    "design": "acc-um",
    "none": "ref",
    "failed": "acc-broken",
}

_TABLES: Final = {
    "Engines on the questions that tell them apart": QUESTIONS,
    "Engines on the faults that people reported": FAULTS,
}


def board_html(results: Path) -> Markup:
    """Return the board that lies in a results folder, as a table."""
    board = board_beside(results)
    if board is None:
        return Markup("<p>%s</p>") % inline("No board is there. `ghostball leaderboard` makes one.")
    tables = []
    for caption, among in _TABLES.items():
        if names := columns_of(board, among):
            columns = [
                (name, COLUMNS[name], dumps(COLUMNS[name].shot), _replay(board, results, name))
                for name in names
            ]
            rows = [(row, [_cell(board, row, name) for name in names]) for row in board.rows]
            tables.append((caption, columns, rows))
    return render(
        "board.html",
        about=about(board),
        legend=[(_CLASSES[worth], *look[:2]) for worth, look in WORTHS.items()],
        tables=tables,
        reported=REPORTED,
    )


def _replay(board: Board, results: Path, name: str) -> Markup | None:
    """Return the data of a column's replay, or None where nothing is to be seen."""
    folder = results / "board"
    if not has_database(folder):  # of a version that kept no motions
        return None
    found = {row: motion_of_side(folder, name, row) for row in board.rows}
    motions = {row: motion for row, motion in found.items() if motion is not None}
    return embedded_json(motions_data(COLUMNS[name].shot, motions)) if motions else None


def _cell(board: Board, row: str, name: str) -> dict[str, object]:
    cell = board.cells.get((row, name))
    if cell is None:
        why = "not measured"
        return {"kind": "", "text": "", "value": "", "row": row, "name": name, "why": why}
    why = f"{row}: {COLUMNS[name].asks}. {WORTHS[cell.worth][1]}"
    why += f" ({cell.note})" if cell.note else ""
    return {
        "kind": _CLASSES[cell.worth],
        "text": cell_text(board, row, name),
        "value": "" if cell.value is None else repr(abs(cell.value)),
        "row": row,
        "name": name,
        "why": f"{why}. Again: {board.command(row, name)}",
    }
