"""Fails where a stored board is shown with other cells, rows or signs than it has."""

import json
import re
from pathlib import Path

import pytest

from ghostball.engine import simulate
from ghostball.reports import style
from ghostball.reports.board import board_beside, board_markdown, cell_text, draw_board
from ghostball.reports.page.board import board_html
from ghostball.validation.board.board import ROWS, StoredBoard, StoredCell, load_board
from ghostball.validation.board.columns import COLUMNS, Cell
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.files import BOARD
from ghostball.validation.results.motions import save_motion
from ghostball.validation.results.store import ResultsWriter
from ghostball.validation.runs.sampling import motion_of

CELLS = {
    ("my:Engine", "cut"): Cell(None, "died", "failed", "it took <too> long"),
    ("pymunk", "cut"): Cell(0.7, "0.7", "fair"),
    ("pymunk", "line"): Cell(0.0, "Moreau", "design", "-0.333, 0.667, 0.667"),
    ("ghostball", "cut"): Cell(7e-14, "7e-14", "good"),
    ("ghostball", "landed"): Cell(None, "", "none", "it has no steps"),
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    cells = tuple(
        StoredCell(row=row, column=column, code="x", cell=cell)
        for (row, column), cell in CELLS.items()
    )
    stored = StoredBoard(environment=describe_environment(), cells=cells)
    (tmp_path / "board").mkdir()
    (tmp_path / "board" / BOARD).write_text(stored.model_dump_json())
    return tmp_path


def test_a_board_reads_back_in_the_order_of_the_rows(folder: Path) -> None:
    board = board_beside(folder)
    assert board is not None
    assert board.rows == ("ghostball", "pymunk", "my:Engine")
    assert dict(board.cells) == CELLS
    assert board_beside(folder / "board") is None
    assert load_board(folder / BOARD) is None


def test_cells_have_the_sign_of_what_they_are_worth(folder: Path) -> None:
    board = board_beside(folder)
    texts = {place: cell_text(board, *place) for place in CELLS}
    assert texts == {
        ("my:Engine", "cut"): "! died",
        ("pymunk", "cut"): "◐ 0.7",
        ("pymunk", "line"): "◇ Moreau",
        ("ghostball", "cut"): "● 7e-14",
        ("ghostball", "landed"): "–",
    }
    assert cell_text(board, "ghostball", "line") == ""
    assert "`pymunk` | ◐ 0.7 |  | ◇ Moreau" in board_markdown(board)


def test_a_picture_has_every_cell(folder: Path) -> None:
    board = board_beside(folder)
    with style.drawing():
        (axes,) = draw_board(board).axes
        texts = [text.get_text() for text in axes.texts]
    assert sorted(texts) == sorted(cell_text(board, *place) for place in CELLS)


def test_the_page_has_values_to_sort_by_and_leads_to_each_scene(folder: Path) -> None:
    html = board_html(folder)
    assert 'data-value="0.7"' in html
    assert "it took &lt;too&gt; long" in html
    assert "ghostball leaderboard --only -e pymunk --column line --rerun" in html
    assert html.count('<details id="board-') == 3
    assert 'href="#board-line"' in html
    assert "ghostball leaderboard" in board_html(folder / "nowhere")


def test_the_page_replays_what_was_recorded(folder: Path) -> None:
    assert "data-replay" not in board_html(folder)  # no motion was kept
    scene = COLUMNS["cut"].shot
    motion = motion_of(simulate(scene, record="trajectory"))
    for row in ("ghostball", "pymunk"):
        save_motion(folder / "board", motion, scene="cut", side=row)
    html = board_html(folder)
    assert html.count("data-replay=") == 1
    assert 'data-row="pymunk"' in html
    (content,) = re.findall(r'<script [^>]*id="replay-board-cut">(.*?)</script>', html)
    data = json.loads(content)
    assert data["scene"] == scene.name
    assert [engine["label"] for engine in data["engines"]] == ["ghostball", "pymunk"]
    assert all(engine["motion"] for engine in data["engines"])


def test_results_may_be_written_beside_a_board(folder: Path) -> None:
    (folder / "board" / "more").write_text("")
    with pytest.raises(Exception, match="not a results folder of ours"):
        ResultsWriter(folder)
    (folder / "board" / "more").unlink()
    ResultsWriter(folder)


def test_every_row_and_column_says_what_it_is() -> None:
    assert len(set(ROWS)) == len(ROWS)
    for column in COLUMNS.values():
        assert column.title
        assert column.asks[0].isupper()
        assert not column.asks.endswith(".")
