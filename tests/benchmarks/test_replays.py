"""`python -m benchmarks replays`: the motions behind the board's cells, and where cells lead."""

import json
from pathlib import Path

import pytest

from benchmarks.replays import ColumnReplays, committed_replays, write_replays
from ghostball.validation.board.board import run_board
from ghostball.validation.board.column import QUESTIONS
from ghostball.validation.results.store import Results

pytestmark = pytest.mark.checkout


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    folder = tmp_path_factory.mktemp("board")
    board, _ = run_board(
        ["ghostball", "paper-continuous"], folder, columns=[QUESTIONS["line"], QUESTIONS["slide"]]
    )
    return board, Results.open(folder)


def test_cells_that_are_as_committed_have_their_run_beside_ours(ran, tmp_path: Path):
    board, results = ran
    files = write_replays(board, board, results, tmp_path)
    assert [path.stem for path in files] == ["line", "slide"]
    found = ColumnReplays.model_validate_json(files[0].read_bytes())
    assert set(found.shot_of) == {"ghostball", "paper-continuous"}
    shot = found.shots[found.shot_of["paper-continuous"]]
    assert shot["truth"]["kind"] == "closed form"
    assert all(one["motion"] for one in shot["engines"])
    # It lacks sliding: there is no run, and so its cell leads to its engine's page.
    assert set(json.loads(files[1].read_text())["shot_of"]) == {"ghostball"}


def test_a_cell_that_came_out_otherwise_is_not_replayed(ran, tmp_path: Path):
    board, results = ran
    cells = [
        one.model_copy(update={"note": "another law: 1, 2"}) if one.column == "line" else one
        for one in board.cells
    ]
    other = board.model_copy(update={"cells": tuple(cells)})
    assert [path.stem for path in write_replays(board, other, results, tmp_path)] == ["slide"]


def test_each_replay_of_the_site_is_of_a_cell_of_the_board():
    from benchmarks.pictures.gallery import committed_board
    from docs.replay_pages import page, replay_link

    board = committed_board()
    columns = {one.id: one for one in board.columns}
    replays = committed_replays()
    assert {one.id for one in columns.values() if one.replay and one.scenes} == set(replays)
    for name, found in replays.items():
        for row in found.shot_of:
            assert board.cell(row, name) is not None
            assert replay_link(row, name) == f"../replays/{name}.html#{row}"
    assert replay_link("ghostball", "gas") is replay_link("ghostball", "table") is None
    text = page(board, columns["slide"], replays["slide"])
    assert 'data-row="pymunk"' in text
    assert "mountReplay" in text
    assert " src=" not in text
