"""Fails where a stored board is shown with other cells, rows or signs than it has."""

import json
import re
from pathlib import Path

import pytest

from ghostball.reports import style
from ghostball.reports.board import (
    LOOKS,
    about,
    board_beside,
    cell_text,
    draw_board,
    measured,
)
from ghostball.reports.page.board import board_html
from ghostball.validation.board.asking import board_scene
from ghostball.validation.board.board import Board, load, run_board
from ghostball.validation.board.cell import Cell
from ghostball.validation.board.column import COLUMNS
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.files import BOARD
from ghostball.validation.results.records import ACCURACY_KINDS
from ghostball.validation.results.store import ResultsWriter

CELLS = [
    Cell(row="my:Engine", column="cut", kind="failed", note="it took <too> long"),
    Cell(row="pymunk", column="cut", kind="millimetres", value=4.35e-3),
    Cell(row="pymunk", column="line", kind="good", value=0.0, note="Moreau"),
    Cell(row="pymunk", column="um", kind="bad", note="not reached: pymunk is the last"),
    Cell(row="pymunk", column="break", kind="bad", value=0.33),
    Cell(row="pymunk", column="slow", kind="fair", value=0.005),
    Cell(row="ghostball", column="cut", kind="exact", value=3.8e-16),
    Cell(row="ghostball", column="exact-steps", kind="none", note="it has no exact steps"),
    Cell(row="ghostball", column="break", kind="good", value=1e-15),
    Cell(row="ghostball", column="slow", kind="good", value=0.0),
    Cell(row="ghostball", column="um", kind="good", value=2.7e-6),
    Cell(row="ghostball", column="line", kind="bad", value=0.17, note="another law: 0.1, 0.9"),
    Cell(row="my:Engine", column="exact-steps", kind="another shot"),
    Cell(row="ghostball", column="table", kind="beside", value=2.67, note="rebound 2.7"),
    Cell(row="my:Engine", column="table", kind="partly", value=1.44, earlier=0),
]
TEXTS = {
    ("my:Engine", "cut"): "! failed",
    ("pymunk", "cut"): "4.35 mm",
    ("pymunk", "line"): "● Moreau",
    ("pymunk", "um"): "✗ not reached",
    ("pymunk", "break"): "✗ 3.3e-01",
    ("pymunk", "slow"): "◐ 0.005",
    ("ghostball", "cut"): "exact",
    ("ghostball", "exact-steps"): "–",
    ("ghostball", "break"): "● kept",
    ("ghostball", "slow"): "● none",
    ("ghostball", "um"): "● 2.7 µs",
    ("ghostball", "line"): "✗ 1.7e-01",
    ("my:Engine", "exact-steps"): "other shot",
    ("ghostball", "table"): "2.7",
    ("my:Engine", "table"): "1.4 in part",
}

ELSEWHERE = {"cpu": "Z80", "cores": 1, "date": "1976-07-01"}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    ids = {cell.column for cell in CELLS}
    stored = Board(
        environment=describe_environment(),
        earlier=(ELSEWHERE,),
        columns=tuple(one for one in COLUMNS.values() if one.id in ids),
        cells=tuple(CELLS),
    )
    (tmp_path / "board").mkdir()
    (tmp_path / "board" / BOARD).write_text(stored.model_dump_json())
    return tmp_path


def test_a_board_reads_back_in_the_order_of_the_rows(folder: Path) -> None:
    board = board_beside(folder)
    assert board is not None
    assert board.rows == ("ghostball", "pymunk", "my:Engine")
    assert board.cells == tuple(CELLS)
    assert board_beside(folder / "board") is None
    assert load(folder / BOARD) is None


def test_cells_say_their_class_or_have_the_sign_of_their_shade(folder: Path) -> None:
    board = board_beside(folder)
    assert {
        (cell.row, cell.column): cell_text(board, cell.row, COLUMNS[cell.column]) for cell in CELLS
    } == TEXTS
    assert cell_text(board, "my:Engine", COLUMNS["line"]) == ""


def test_every_class_and_shade_has_a_look_of_its_own() -> None:
    assert list(LOOKS)[: len(ACCURACY_KINDS)] == list(ACCURACY_KINDS)
    assert len({(look.sign, look.paper) for look in LOOKS.values()}) == len(LOOKS)


def test_what_is_beside_right_and_wrong_looks_like_neither() -> None:
    judged = {LOOKS[kind].slug for kind in ("good", "fair", "bad", *ACCURACY_KINDS)}
    assert LOOKS["beside"].slug not in judged
    assert LOOKS["partly"].slug not in judged


def test_engines_that_were_measured_elsewhere_are_named(folder: Path) -> None:
    board = board_beside(folder)
    cells = tuple(
        Cell(row=row, column=one.id, kind="good", earlier=0)
        for one in board.columns
        for row in ("planck", "planck:config=naive")
    )
    joined = board.model_copy(update={"cells": (*board.cells, *cells)})
    there = measured(ELSEWHERE)
    assert about(joined, [COLUMNS["cut"]]).endswith(f"planck: {there}")


def test_it_says_where_most_was_measured_and_which_columns_elsewhere(folder: Path) -> None:
    board = board_beside(folder)
    here, there = measured(board.environment), measured(ELSEWHERE)
    assert there == "Z80, 1 cores, 1976-07-01, at unknown"
    assert about(board) == f"{here}; like a table: {there}"
    assert about(board, [COLUMNS["cut"]]) == here
    assert f"Measured on {there}. Again: " in board_html(folder)


def test_a_picture_has_every_cell(folder: Path) -> None:
    board = board_beside(folder)
    with style.drawing():
        (axes,) = draw_board(board).axes
        texts = [text.get_text() for text in axes.texts]
    assert sorted(texts) == sorted(TEXTS.values())


def test_the_page_has_values_to_sort_by_and_leads_to_each_scene(folder: Path) -> None:
    html = board_html(folder)
    assert 'data-value="0.005"' in html
    assert "it took &lt;too&gt; long" in html
    assert "ghostball leaderboard --only -e pymunk --column line --rerun" in html
    assert html.count('<details id="board-') == len({cell.column for cell in CELLS})
    assert 'href="#board-line"' in html
    assert "data-replay" not in html  # no motion was kept
    assert board_html(folder / "nowhere") == ""


@pytest.mark.usefixtures("in_this_process")
def test_the_page_replays_what_was_recorded(tmp_path: Path) -> None:
    columns = [COLUMNS[name] for name in ("throw", "um", "physx-351")]
    run_board(["ghostball", "pymunk"], tmp_path / "board", columns=columns)
    html = board_html(tmp_path)
    assert html.count("data-replay=") == 2
    assert "github.com/NVIDIAGameWorks/PhysX/issues/351" in html
    assert 'data-row="pymunk"' in html
    (content,) = re.findall(r'<script [^>]*id="replay-board-throw">(.*?)</script>', html)
    data = json.loads(content)
    assert data["scene"] == board_scene("throw").name
    assert [engine["label"] for engine in data["engines"]] == ["ghostball", "pymunk"]
    assert all(engine["motion"] for engine in data["engines"])


def test_results_may_be_written_beside_a_board(folder: Path) -> None:
    (folder / "board" / "more").write_text("")
    with pytest.raises(Exception, match="not a results folder of ours"):
        ResultsWriter(folder)
    (folder / "board" / "more").unlink()
    ResultsWriter(folder)
