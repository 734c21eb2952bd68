"""Pages of the site that replay a column of the board: one each, to which its cells lead."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Final

from markupsafe import Markup

from benchmarks.pictures.gallery import committed_board
from benchmarks.replays import ColumnReplays, committed_replays
from ghostball.reports.board import LOOKS, cell_text
from ghostball.reports.page.rendering import asset, embedded_json, replay_script, templates
from ghostball.validation.board.board import Board, command
from ghostball.validation.board.column import Column

_HERE: Final = Path(__file__).resolve().parent


@cache
def _replays() -> dict[str, ColumnReplays]:
    return committed_replays()


def replay_link(row: str, column: str) -> str | None:
    """Return where a cell's run is replayed, from the site's page of the board; None: nowhere."""
    found = _replays().get(column)
    return f"../replays/{column}.html#{row}" if found is not None and row in found.shot_of else None


def page(board: Board, column: Column, replays: ColumnReplays) -> str:
    """Return the page that replays a column, with all that it needs within."""
    rows, about = [], {}
    for row in (one for one in board.rows if one in replays.shot_of):
        cell = board.cell(row, column.id)
        assert cell is not None
        text, look = cell_text(board, row, column), LOOKS[cell.kind]
        rows.append({"row": row, "text": text, "paper": look.paper})
        shot = replays.shots[replays.shot_of[row]]
        about[row] = {
            "shot": replays.shot_of[row],
            "says": f"{row}: {text}. {shot['title']}; {replays.labels[row]}.",
            "again": command(cell),
            "page": f"../engines/{row.partition(':')[0]}/#"
            + ("reported-faults" if column.thread else column.id),
        }
    return (
        templates()
        .from_string(_text("replay_page.html"))
        .render(
            column=column,
            rows=rows,
            shots=[embedded_json(one) for one in replays.shots],
            about=embedded_json(about),
            styles=[asset("page.css"), asset("replay.css")],
            script=replay_script(),
            own=Markup(_text("replay_page.js")),
        )
    )


def _text(name: str) -> str:
    return (_HERE / name).read_text(encoding="utf-8")


def write_pages(site: Path) -> None:
    """Write the pages into the site."""
    board = committed_board()
    columns = {} if board is None else {one.id: one for one in board.columns}
    for name, found in _replays().items():
        if board is not None and name in columns:
            path = site / "replays" / f"{name}.html"
            path.parent.mkdir(exist_ok=True)
            path.write_text(page(board, columns[name], found), encoding="utf-8")
