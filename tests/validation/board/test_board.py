"""The board: what its columns see, and that what an engine does costs its own cells alone."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest
from engine_facts import needs
from typer.testing import CliRunner

from ghostball.cli import app
from ghostball.engine import EngineFailedError, GhostballError, simulate
from ghostball.engine.running.driver import Run
from ghostball.validation.board import board as boards, shots
from ghostball.validation.board.board import run_board, sorted_rows
from ghostball.validation.board.columns import COLUMNS, FAULTS, native, with_settings
from ghostball.validation.board.right import proved_end
from ghostball.validation.board.shots import head_on
from ghostball.validation.parallel.pool import Done
from ghostball.validation.results.files import BOARD
from ghostball.validation.results.motions import motion_of_side, save_sides
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.suite import run_suite

SLOWING, DYING = "board_engines:Slowing", "board_engines:Dying"
QUICK = ("cut", "line", "two", "slow")


@pytest.fixture(autouse=True)
def _findable(monkeypatch):
    """Let the processes that measure find the engines of the tests."""
    from pathlib import Path

    import board_engines

    monkeypatch.setenv("PYTHONPATH", str(Path(board_engines.__file__).parent))


@pytest.fixture
def asked(monkeypatch):
    """Measure in this process, and list what is."""
    places = []

    def in_this_process(tasks, *_, **__):
        for task in tasks:
            places.append(task)
            yield Done(task, boards.measure(task), "", "")

    monkeypatch.setattr(boards, "run_tasks", in_this_process)
    return places


WORTHS = {"landed": "none", "line": "design", "two": "design", "size": "fair"}
"""Of our engine: it has no steps that could land, its law of impacts is one of several, and the
compiler that it needs is large."""


@pytest.mark.parametrize("name", COLUMNS)
def test_our_engine_is_right_in_every_column(name):
    cell = COLUMNS[name].measure("ghostball")
    assert cell.worth == WORTHS.get(name, "good"), cell


MEASURED_BY_PROOFS = ("slide", "mm", "um", *FAULTS)


@pytest.mark.parametrize("name", MEASURED_BY_PROOFS)
def test_an_error_of_our_own_engine_shows(name, monkeypatch):
    """The planted error: all that our engine says of the end is off, wherever it is asked."""
    end = Run.final_state

    def off(self):
        state, wrong = end(self), 3e-3
        return state._replace(
            positions=state.positions + wrong,
            velocities=state.velocities + wrong,
            angular_velocities=state.angular_velocities + wrong / shots.R,
        )

    right = COLUMNS[name].measure("ghostball")
    monkeypatch.setattr(Run, "final_state", off)
    wrong = COLUMNS[name].measure("ghostball")
    if name in ("mm", "um"):
        assert (right.worth, wrong.text) == ("good", "not reached")
    else:
        assert right.value < 1e-12
        assert wrong.value > 1e-5


@pytest.mark.parametrize("physics", [{}, {"impacts": "sequential"}, {"motion": "sliding"}])
@pytest.mark.parametrize("name", MEASURED_BY_PROOFS)
def test_what_is_measured_by_a_proof_is_proved_however_it_is_played(name, physics):
    """An engine that only slides, or takes impacts one by one, plays another scene."""
    scene = COLUMNS[name].shot
    if physics.get("motion") and not np.any(scene.rolling_frictions):
        physics = {**physics, "sliding_friction": 0.0}
    changed = scene.physics.model_copy(update=physics)
    assert proved_end(scene.model_copy(update={"physics": changed})).status.complete


def test_nothing_stands_in_for_a_proof():
    with pytest.raises(GhostballError, match="must be proved to its end, got: ambiguous"):
        proved_end(shots.one_into_two())
    law = shots.FREE.model_copy(update={"ball_impact": "mathavan2014", "motion": "sliding"})
    with pytest.raises(GhostballError, match="must be proved to its end, got: no ball impacts"):
        proved_end(shots.half_ball(physics=law))


def test_steps_show_where_there_are_some():
    cut, landed = (COLUMNS[name].measure("pymunk") for name in ("cut", "landed"))
    assert cut.value == pytest.approx(0.70, abs=0.05)
    assert cut.worth == "fair"
    assert landed.value < 1e-6
    assert landed.worth == "good"
    assert COLUMNS["slow"].measure("pymunk").worth == "good"


def test_what_is_wrong_is_told_from_what_is_another_law():
    # The planted error: speed that is lost.
    assert COLUMNS["line"].measure("ghostball").worth == "design"
    line = COLUMNS["line"].measure(SLOWING)
    assert (line.worth, line.text) == ("bad", "energy x 0.81")


def test_a_cell_that_dies_costs_itself_alone(tmp_path):
    board = run_board(["ghostball", DYING], tmp_path, columns=["cut", "slow"])
    assert board.cells[DYING, "cut"].text == "died"
    assert board.cells[DYING, "cut"].worth == "failed"
    assert board.cells["ghostball", "cut"].worth == "good"
    assert board.cells["ghostball", "slow"].worth == "good"


def test_a_cell_keeps_the_motion_that_shows_it(tmp_path, asked):
    run_board(["ghostball", "pymunk"], tmp_path, columns=["cut", "landed", "um"])
    kept = {
        (row, column): motion_of_side(tmp_path, column, row)
        for row in ("ghostball", "pymunk")
        for column in ("cut", "landed", "um")
    }
    # What our engine lacks, and what a motion doesn't show, have none.
    assert [place for place, motion in kept.items() if motion is None] == [
        ("ghostball", "landed"),
        ("ghostball", "um"),
        ("pymunk", "um"),
    ]
    cut, landed = kept["pymunk", "cut"], kept["pymunk", "landed"]

    def off(motion):
        x, y = motion.velocities[-1, 1, :2]
        return abs(math.degrees(math.atan2(-y, x)) - 30.0)

    # Each as its column plays it.
    assert off(cut) > 0.01
    assert off(landed) < 1e-6
    assert np.array_equal(kept["ghostball", "cut"].positions[0], cut.positions[0])


def test_a_cell_that_fails_keeps_no_motion_of_an_earlier_run(tmp_path, asked, monkeypatch):
    run_board([SLOWING], tmp_path, columns=["cut"])
    assert motion_of_side(tmp_path, "cut", SLOWING) is not None
    monkeypatch.setattr(boards, "measure", lambda task: boards._died(task, "no chalk"))
    run_board([SLOWING], tmp_path, columns=["cut"])
    assert motion_of_side(tmp_path, "cut", SLOWING) is None


def test_runs_into_the_same_folder_leave_the_board_its_motions(tmp_path, asked):
    """A cell that is kept isn't measured again: its motion would be gone for good."""
    run_board(["ghostball"], tmp_path, columns=["cut"])
    motion = motion_of_side(tmp_path, "cut", "ghostball")
    save_sides(tmp_path, {("stop", "base"): motion, ("stop", "head"): motion})
    assert motion_of_side(tmp_path, "cut", "ghostball") is not None
    run_suite([find_scene("stop")], ["ghostball"], tmp_path)
    assert motion_of_side(tmp_path, "cut", "ghostball") is not None
    # Those of a comparison are of other results.
    assert motion_of_side(tmp_path, "stop", "base") is None
    board = run_board(["ghostball"], tmp_path, columns=["cut"])
    assert (len(asked), board.cells["ghostball", "cut"].worth) == (1, "good")


def test_a_later_run_goes_on_where_an_earlier_one_ended(tmp_path, asked):
    run_board(["ghostball"], tmp_path, columns=["cut"])
    board = run_board(["ghostball", SLOWING], tmp_path, columns=["cut", "slow"])
    # Nobody knows the code of a stranger's engine: it is measured anew.
    run_board(["ghostball", SLOWING], tmp_path, columns=["cut", "slow"])
    ours, theirs = [(row, column) for row, column in asked if row == "ghostball"], SLOWING
    assert ours == [("ghostball", "cut"), ("ghostball", "slow")]
    assert asked.count((theirs, "cut")) == 2
    assert set(board.cells) == {(row, c) for row in ("ghostball", SLOWING) for c in ("cut", "slow")}


def test_a_rerun_of_one_cell_leaves_all_others(tmp_path, asked):
    run_board(["ghostball", "pymunk"], tmp_path, columns=["cut", "line"])
    board = run_board(["ghostball"], tmp_path, columns=["line"], rerun=True)
    assert asked[4:] == [("ghostball", "line")]
    assert set(board.cells) == {("ghostball", "cut"), ("ghostball", "line")}
    stored = boards.load(tmp_path / BOARD)
    assert [(one.row, one.column) for one in stored.cells] == asked[:4]


def test_cells_of_other_code_stay_until_they_are_measured_anew(tmp_path, asked, monkeypatch):
    for code in ("one", "another", "another"):
        monkeypatch.setattr(boards, "code_hash", lambda code=code: code)
        board = run_board(["ghostball"], tmp_path, columns=["cut"] if code == "another" else QUICK)
    assert asked == [("ghostball", column) for column in (*QUICK, "cut")]
    assert set(board.cells) == {("ghostball", "cut")}
    stored = boards.load(tmp_path / BOARD)
    assert {one.column: one.code for one in stored.cells} == dict.fromkeys(QUICK, "one") | {
        "cut": "another"
    }


def test_nothing_is_taken_over_where_nobody_knows_the_code(tmp_path, asked, monkeypatch):
    monkeypatch.setattr(boards, "code_hash", lambda: "")
    for _ in range(2):
        run_board(["ghostball"], tmp_path, columns=["cut"])
    assert len(asked) == 2


@pytest.mark.parametrize("error", [EngineFailedError("ghostball", "no chalk"), OSError("no chalk")])
def test_a_cell_that_failed_is_measured_again(tmp_path, asked, monkeypatch, error):
    def fail(spec):
        raise error

    with monkeypatch.context() as broken:
        column = dataclasses.replace(COLUMNS["cut"], measure=fail)
        broken.setattr(boards, "COLUMNS", {**COLUMNS, "cut": column})
        board = run_board(["ghostball"], tmp_path, columns=["cut"])
    cell = board.cells["ghostball", "cut"]
    assert (cell.text, cell.worth) == ("failed", "failed")
    assert "no chalk" in cell.note
    board = run_board(["ghostball"], tmp_path, columns=["cut"])
    assert board.cells["ghostball", "cut"].worth == "good"


def test_a_shot_that_comes_to_no_end_has_failed():
    _, cell, motion = boards.measure(("pymunk:max_steps=10", "cut"))
    assert motion is None
    assert cell.worth == "failed"
    assert "no end" in cell.note


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{}", "`environment` is missing"),
        ('{"environment": {}, "cells": [{"row": "a", "column": "cut"}]}', "`cells.0.code`"),
        ("no board", "JSON"),
    ],
)
def test_a_damaged_board_is_refused(tmp_path, text, says):
    (tmp_path / BOARD).write_text(text)
    with pytest.raises(GhostballError, match=says):
        run_board(["ghostball"], tmp_path, columns=["cut"])


def test_a_folder_that_cant_be_written_is_named(tmp_path, asked):
    (tmp_path / "file").write_text("")
    with pytest.raises(GhostballError, match=r"file/board\.json"):
        run_board(["ghostball"], tmp_path / "file", columns=["cut"])
    (tmp_path / (BOARD + ".part")).mkdir()
    with pytest.raises(GhostballError, match="can't write the results folder"):
        run_board(["ghostball"], tmp_path, columns=["cut"])


def test_every_straight_hit_comes_to_its_end():
    for speed in (2.1, 0.43, 0.09, 0.001):
        scene = head_on(speed)
        assert simulate(scene).final_state.velocities[0, :, 0] == pytest.approx([0.0, speed])
        assert 0.04 < scene.t_max < 5.0 + 1e-9


def test_settings_are_added_where_an_engine_has_them():
    assert with_settings("pymunk", dt=1e-3, mode="landed") == "pymunk:dt=0.001,mode=landed"
    assert with_settings("pymunk:dt=0.01", dt=1e-3) == "pymunk:dt=0.01"
    assert with_settings("ghostball", dt=1e-3) is None
    assert with_settings(SLOWING, dt=1e-3) is None


@needs("pybullet")
def test_settings_that_exclude_each_other_are_not_added():
    assert with_settings("pybullet:config=default", mode="landed") is None


def test_fixed_steps_have_the_name_that_the_engine_gives_them():
    assert native("pymunk", 1e-3) == "pymunk:dt=0.001,mode=native,max_steps=1000000"
    assert native("paper-continuous", 0.01).startswith("paper-continuous:frame=0.01,max_events=")
    assert native("ghostball", 1e-3) is None


def test_the_least_run_time_is_of_a_configuration_that_is_right():
    millimetre, micrometre = (COLUMNS[name].measure("paper-discrete") for name in ("mm", "um"))
    assert (millimetre.note, millimetre.worth != "bad") == ("steps of 0.0001 s", True)
    assert (micrometre.text, micrometre.note) == ("not reached", "with steps down to 3e-05 s")
    assert COLUMNS["um"].measure("pymunk").note == "landed"


def test_the_command_shows_a_strangers_row(tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "20")  # a narrow window cuts no cell short
    arguments = ["leaderboard", "--only", "-e", "ghostball", "-e", SLOWING, "--out", str(tmp_path)]
    done = CliRunner().invoke(app, [*arguments, "--column", "line", "--column", "slow"])
    assert done.exit_code == 0, done.output
    assert "sequential" in done.output
    assert "energy x 0.81" in done.output
    again = CliRunner().invoke(app, [*arguments, "--column", "line", "--format", "json"])
    rows = json.loads(again.stdout)["rows"]
    assert rows[SLOWING]["line"]["again"] == (
        f"ghostball leaderboard --only -e {SLOWING} --column line --rerun"
    )


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--column", "speed"], "unknown column 'speed'"),
        (["--sort", "speed"], "`--sort` must be one of cut"),
        (["--only"], "needs at least one"),
    ],
)
def test_what_is_no_board_is_refused(tmp_path, options, says):
    done = CliRunner().invoke(app, ["leaderboard", *options, "--out", str(tmp_path)])
    assert done.exit_code == 2
    assert says in done.stderr


def test_rows_are_sorted_by_a_column(tmp_path):
    board = run_board(["pymunk", "ghostball"], tmp_path, columns=["cut"])
    assert sorted_rows(board, "cut").rows == ("ghostball", "pymunk")
    assert sorted_rows(board, "slow").rows == ("pymunk", "ghostball")
