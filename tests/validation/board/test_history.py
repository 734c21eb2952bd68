"""What the board said before is kept in a line for each run and row, and what moved is told."""

import pytest

from ghostball.model import GhostballError
from ghostball.reports.board import move_text
from ghostball.validation.board.board import Board
from ghostball.validation.board.cell import Cell
from ghostball.validation.board.column import QUESTIONS
from ghostball.validation.board.history import HISTORY, entries_of, load_history, remember


def board(version, *cells):
    environment = {
        "date": "2026-11-28T00:00:00+00:00",
        "versions": {"pyb2d3": version},
        "git": {"revision": "9d353a3d6ab6", "dirty": False},
    }
    return Board(environment=environment, columns=tuple(QUESTIONS.values()), cells=cells)


def cell(value, kind="millimetres", column="cut"):
    return Cell(row="box2d3", column=column, kind=kind, value=value)


def remembered(folder, made):
    return remember(folder, entries_of(made, made.cells))


def test_a_new_version_of_an_engine_is_compared_with_the_last_that_is_known(tmp_path):
    first = board("0.11.1", cell(4.3e-3), cell(0.46, "bad", "break"))
    assert remembered(tmp_path, first) == []
    assert remembered(tmp_path, first) == []  # nothing new: no line is added
    assert len(load_history(tmp_path)) == 1
    # A part alone, of another version: the other column stays known.
    assert remembered(tmp_path, board("0.12.0", cell(4.301e-3))) == []  # below a percent
    (move,) = remembered(tmp_path, board("0.13.0", cell(1e-9, "exact"), cell(0.46, "bad", "break")))
    assert (move.row, move.column, move.since.version) == ("box2d3", "cut", "0.12.0")
    assert (
        move_text(move)
        == "moved: box2d3, cut: 4.3 mm to exact, since 0.12.0, 2026-11-28, at 9d353a3"
    )
    assert [one.version for one in load_history(tmp_path)] == ["0.11.1", "0.12.0", "0.13.0"]


def test_times_are_no_history(tmp_path):
    timed = next(one.id for one in QUESTIONS.values() if one.unit == "s")
    assert remembered(tmp_path, board("1", cell(1.0, "good", timed))) == []
    assert load_history(tmp_path) == ()


def test_a_damaged_line_is_named(tmp_path):
    remembered(tmp_path, board("1", cell(1e-3)))
    with (tmp_path / HISTORY).open("a") as file:
        file.write("{}\n")
    with pytest.raises(GhostballError, match=r"history\.jsonl, line 2: `row` is missing"):
        load_history(tmp_path)
