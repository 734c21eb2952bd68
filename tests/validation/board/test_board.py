"""The board: what its columns see, and that what an engine does costs its own cells alone."""

from __future__ import annotations

import numpy as np
import pytest
from engine_facts import needs
from likenesses import likeness
from toy_engines import drifted

from ghostball.model import GhostballError
from ghostball.reference_adapters.ghostball import GhostballEngine
from ghostball.validation.board import board as boards
from ghostball.validation.board.board import Board, load, run_board
from ghostball.validation.board.cell import Cell, cell_of_likeness
from ghostball.validation.board.column import ACCURACY, COLUMNS, QUESTIONS
from ghostball.validation.results.files import BOARD
from ghostball.validation.results.motions import motion_of_case
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite import real_tables
from ghostball.validation.suite.suite import Outcome, run_suite

SLOWING, DYING = "board_engines:Slowing", "board_engines:Dying"


@pytest.fixture(autouse=True)
def _findable(monkeypatch):
    """Let the processes that measure find the engines of the tests."""
    from pathlib import Path

    import board_engines

    monkeypatch.setenv("PYTHONPATH", str(Path(board_engines.__file__).parent))


def ask(folder, rows, *names, **options):
    return run_board(rows, folder, columns=[COLUMNS[name] for name in names], **options)


@pytest.fixture
def ran(monkeypatch):
    """List the cases that are run."""
    pairs = []
    run = boards.run_suite

    def listing(*args, progress, **options):
        def note(done, planned, case):
            pairs.append((case.scene, case.label))

        return run(*args, progress=note, **options)

    monkeypatch.setattr(boards, "run_suite", listing)
    return pairs


@pytest.mark.slow
@pytest.mark.usefixtures("in_this_process")
def test_our_engine_is_right_in_every_column(tmp_path):
    board, outcome = run_board(["ghostball"], tmp_path, columns=COLUMNS.values())
    kinds = {
        one.id: "exact" if (one.metric, one.pick) == (ACCURACY, "worst") else "good"
        for one in COLUMNS.values()
    }
    kinds |= {"exact-steps": "none", "table": "beside"}  # it has no steps
    assert {cell.column: cell.kind for cell in board.cells} == kinds
    assert outcome.counts.checks_failed == outcome.counts.unfinished == 0


@pytest.mark.usefixtures("in_this_process")
def test_an_error_of_our_own_engine_shows(tmp_path, monkeypatch):
    """The planted error: our engine's balls drift off on their way, wherever it is asked."""
    simulate = GhostballEngine.simulate

    def off(self, scene, *, record="rest"):
        return drifted(simulate(self, scene, record=record), np.array([3e-3, 3e-3, 0.0]))

    monkeypatch.setattr(GhostballEngine, "simulate", off)
    asked = [one.id for one in COLUMNS.values() if ACCURACY in (one.metric, one.within)]
    asked = [name for name in asked if name not in ("exact-steps", "pocket")] + ["mm", "um"]
    board, outcome = ask(tmp_path, ["ghostball"], *asked)
    seen = {"mm": "bad", "um": "bad"}
    assert {cell.column: cell.kind for cell in board.cells} == {
        name: seen.get(name, "millimetres") for name in asked
    }
    assert outcome.exit_status == 1


@pytest.mark.usefixtures("in_this_process")
def test_steps_show_where_there_are_some(tmp_path):
    board, _ = ask(tmp_path, ["pymunk"], "cut", "exact-steps", "slow", "um")
    cut, exact = board.cell("pymunk", "cut"), board.cell("pymunk", "exact-steps")
    assert (cut.kind, exact.kind) == ("millimetres", "nanometres")
    assert cut.value == pytest.approx(0.00435, rel=0.01)
    assert board.cell("pymunk", "slow").value == 0.0
    assert board.cell("pymunk", "um").label == "pymunk:contact_steps=exact"
    # Of each cell the suite keeps the motion, as its column plays it.
    starts = [
        motion_of_case(tmp_path, one.scene, one.label).positions[0, 0] for one in (cut, exact)
    ]
    assert not np.array_equal(*starts)


@pytest.mark.usefixtures("in_this_process")
def test_the_least_run_time_is_of_a_configuration_that_is_right(tmp_path):
    board, _ = ask(tmp_path, ["paper-discrete"], "mm", "um")
    assert board.cell("paper-discrete", "mm").label == "paper-discrete:dt=0.0001"
    cell = board.cell("paper-discrete", "um")
    assert (cell.kind, cell.value) == ("bad", None)
    assert cell.note.startswith("not reached: paper-discrete:dt=0.0001")


@pytest.mark.usefixtures("in_this_process")
def test_the_widest_angle_is_that_up_to_which_all_are_right(tmp_path):
    board, _ = ask(tmp_path, ["ghostball", "paper-discrete", "pymunk"], "pocket")
    ours, refused, other = (
        board.cell(row, "pocket") for row in ("ghostball", "paper-discrete", "pymunk")
    )
    assert (ours.kind, ours.value, ours.note) == ("good", 68.28, "all of them")
    assert refused.kind == "none"
    assert other.kind in ("good", "fair")
    assert 60.0 <= other.value <= 68.28


def test_what_is_wrong_is_not_taken_for_another_law(tmp_path):
    # The planted error: speed that is lost.
    board, _ = ask(tmp_path, ["ghostball", SLOWING], "line", "cut")
    line, wrong = (board.cell(row, "line") for row in ("ghostball", SLOWING))
    assert (line.kind, line.note) == ("good", "sequential")
    assert (wrong.kind, wrong.note) == ("bad", "another law: 0.091, 0.099, 0.810")
    assert board.cell("ghostball", "cut").kind == "exact"
    assert board.cell(SLOWING, "cut").kind == "centimetres"


def test_a_cell_that_crashes_costs_itself_alone(tmp_path):
    board, outcome = ask(tmp_path, ["ghostball", DYING], "line", "throw")
    assert board.cell(DYING, "line").kind == "failed"
    assert "crashed" in board.cell(DYING, "line").note
    assert board.cell("ghostball", "line").kind == "good"
    assert board.cell("ghostball", "throw").kind == "exact"
    assert outcome.exit_status == 1


@pytest.mark.usefixtures("in_this_process")
def test_a_later_run_continues_where_an_earlier_one_ended(tmp_path, ran):
    ask(tmp_path, ["ghostball"], "line")
    board, _ = ask(tmp_path, ["ghostball", SLOWING], "line", "throw")
    # Nobody knows the code of a stranger's engine: it is measured anew.
    ask(tmp_path, ["ghostball", SLOWING], "line", "throw")
    assert ran.count(("frozen-line", "ghostball")) == ran.count(("throw", "ghostball")) == 1
    assert ran.count(("frozen-line", SLOWING)) == 2
    assert len(board.cells) == 4


@pytest.mark.usefixtures("in_this_process")
def test_a_rerun_of_one_cell_leaves_all_others_and_their_motions(tmp_path, ran):
    first, _ = ask(tmp_path, ["ghostball", "pymunk"], "line", "throw")
    del ran[:]
    board, outcome = ask(tmp_path, ["ghostball"], "line", rerun=True)
    assert ran == [("frozen-line", "ghostball")]
    assert [case.scene for case in outcome.cases] == ["frozen-line"]
    assert set(board.cells) == set(first.cells)
    assert load(tmp_path / BOARD) == board
    for cell in board.cells:
        if cell.scene:
            assert motion_of_case(tmp_path, cell.scene, cell.label) is not None
    results = Results.open(tmp_path)
    assert results.planned == len(results.cases) == 4


@pytest.mark.usefixtures("in_this_process")
def test_results_beside_a_board_leave_it_its_motions(tmp_path):
    board, _ = ask(tmp_path / "board", ["ghostball"], "throw")
    run_suite([find_scene("stop")], ["ghostball"], tmp_path)
    (cell,) = board.cells
    assert motion_of_case(tmp_path / "board", cell.scene, cell.label) is not None


@pytest.mark.usefixtures("in_this_process")
def test_a_cell_of_a_scene_that_changed_is_none(tmp_path, monkeypatch):
    _, outcome = ask(tmp_path, ["ghostball"], "throw")
    assert outcome.exit_status == 0

    def lost(*_, **__):
        return Outcome(tmp_path, interrupted=True)

    monkeypatch.setattr(boards, "run_suite", lost)
    monkeypatch.setattr(boards, "_is_of", lambda *_: False)
    (tmp_path / BOARD).unlink()
    board, _ = ask(tmp_path, ["ghostball"], "throw")
    assert board.cells == ()


@pytest.mark.usefixtures("in_this_process")
def test_a_shot_that_comes_to_no_end_has_failed(tmp_path):
    board, outcome = ask(tmp_path, ["pymunk:max_steps=10"], "slide")
    cell = board.cell("pymunk:max_steps=10", "slide")
    assert cell.kind == "failed"
    assert "stopped early" in cell.note
    assert outcome.exit_status == 1


@pytest.mark.usefixtures("in_this_process")
def test_an_engine_beside_real_tables_is_neither_right_nor_wrong(tmp_path):
    few = "ghostball.validation.examples.stepper:Stepper"
    board, outcome = ask(tmp_path, ["ghostball", SLOWING, "pymunk:config=naive", few], "table")
    assert outcome is None  # nothing was judged
    ours = board.cell("ghostball", "table")
    assert ours.kind == "beside"
    assert f"rebound against speed {ours.value:.1f}" in ours.note
    assert board.cell(SLOWING, "table").value == ours.value  # one ball alone tells nothing of two
    assert board.cell("pymunk:config=naive", "table").kind == "none"
    assert board.cell(few, "table").kind == "none"
    assert board.cell(few, "table").note.startswith(
        "no rebound, rebound against speed, bank: it has"
    )
    assert load(tmp_path / BOARD) == board


def test_what_is_played_in_part_comes_after_what_is_played_whole():
    column = QUESTIONS["table"]
    found = [
        likeness("lacking", rebound="no", rolling="no"),
        likeness("part", rebound="no", rolling=0.1),
        likeness("far", rebound=30.0, rolling=1.0),
        likeness("near", rebound=3.0, rolling=1.0),
    ]
    cells = tuple(cell_of_likeness(column, one) for one in found)
    board = Board(environment={}, columns=(column,), cells=cells)
    assert board.sorted_rows("table") == ("near", "far", "part", "lacking")


@pytest.mark.usefixtures("in_this_process")
def test_an_interrupt_beside_real_tables_keeps_what_is_done(tmp_path, monkeypatch):
    real = real_tables.likeness

    def interrupting(label, *rest):
        if label == "paper-discrete":
            raise KeyboardInterrupt
        return real(label, *rest)

    monkeypatch.setattr(real_tables, "likeness", interrupting)
    board, outcome = ask(tmp_path, ["ghostball", "paper-discrete"], "table", "line")
    assert outcome.exit_status == 130
    assert len(outcome.cases) == 2
    assert board.cell("ghostball", "table").kind == "beside"
    assert board.cell("paper-discrete", "table") is None


@pytest.mark.usefixtures("in_this_process")
def test_a_board_from_elsewhere_is_continued_and_says_what_was_measured_where(tmp_path):
    elsewhere = {"cpu": "Z80", "date": "1976-07-01", "versions": {"pooltool": "0.6.0"}}
    kept = Cell(row="pooltool", column="cut", kind="exact")
    replaced = Cell(row="ghostball", column="line", kind="bad", value=1.0)
    columns = (QUESTIONS["cut"], QUESTIONS["line"])
    before = Board(environment=elsewhere, columns=columns, cells=(kept, replaced))
    (tmp_path / BOARD).write_text(before.model_dump_json())
    board, _ = ask(tmp_path, ["ghostball"], "table", "line")
    assert board.environment_of(board.cell("pooltool", "cut")) == elsewhere
    for name in ("table", "line"):
        assert board.environment_of(board.cell("ghostball", name)) == board.environment
    again, _ = ask(tmp_path, ["ghostball"], "table", "throw")
    assert again.cell("pooltool", "cut") == board.cell("pooltool", "cut")
    assert (again.earlier, again.cell("ghostball", "line").earlier) == ((elsewhere,), None)
    assert [one.id for one in again.columns] == ["cut", "line", "throw", "table"]


def test_a_cell_of_an_environment_that_is_not_there_is_refused(tmp_path):
    cell = '{"row": "a", "column": "cut", "kind": "good", "earlier": 0}'
    (tmp_path / BOARD).write_text(f'{{"environment": {{}}, "columns": [], "cells": [{cell}]}}')
    with pytest.raises(GhostballError, match="`earlier` must be below 0"):
        load(tmp_path / BOARD)


@pytest.mark.parametrize(
    ("engine", "name"),
    [
        pytest.param("physx", "physx-351", marks=needs("physx")),
        pytest.param("pybullet", "bullet3-1530", marks=needs("pybullet")),
        pytest.param("box2d", "physx-351", marks=needs("box2d")),
    ],
)
@pytest.mark.usefixtures("in_this_process")
def test_the_cure_cures_what_the_naive_configuration_shows(tmp_path, engine, name):
    naive = f"{engine}:config=naive"
    board, _ = ask(tmp_path, [engine, naive], name)
    assert board.cell(engine, name).size < board.cell(naive, name).size
    assert board.cell(engine, name).kind in ("good", "nanometres", "micrometres", "millimetres")
    assert board.cell(naive, name).kind in ("bad", "centimetres", "another shot", "broken")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{}", "`environment` is missing"),
        ('{"environment": {}, "columns": [], "cells": [{"row": "a"}]}', r"`cells\[0\].column`"),
        ("no board", "JSON"),
    ],
)
def test_a_damaged_board_is_refused(tmp_path, text, says):
    (tmp_path / BOARD).write_text(text)
    with pytest.raises(GhostballError, match=says):
        ask(tmp_path, ["ghostball"], "line")


@pytest.mark.usefixtures("in_this_process")
def test_a_folder_that_cant_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(GhostballError, match="file"):
        ask(tmp_path / "file", ["ghostball"], "throw")
    ask(tmp_path / "board", ["ghostball"], "throw")
    (tmp_path / "board" / (BOARD + ".part")).mkdir()
    with pytest.raises(GhostballError, match="can't write the results folder"):
        ask(tmp_path / "board", ["ghostball"], "throw")


def test_rows_are_sorted_by_class_then_by_size():
    kinds = {"a": ("broken", None), "b": ("nanometres", 1e-7), "c": ("exact", 1e-5)}
    kinds |= {"d": ("nanometres", 1e-9), "e": ("none", None)}
    cells = tuple(
        Cell(row=row, column="cut", kind=kind, value=value) for row, (kind, value) in kinds.items()
    )
    board = Board(environment={"cpu": "a processor"}, columns=(QUESTIONS["cut"],), cells=cells)
    assert board.sorted_rows("cut") == ("c", "d", "b", "a", "e")
