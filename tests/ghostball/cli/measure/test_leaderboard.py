"""What `ghostball leaderboard` shows of strangers' engines, and its verdict."""

from __future__ import annotations

import json

import pytest
from commands import refused
from typer.testing import CliRunner

from ghostball.cli import app
from ghostball.validation.board.board import load
from ghostball.validation.board.column import COLUMNS, scene_path
from ghostball.validation.checks.verdict import is_outcome_judged
from ghostball.validation.results.files import BOARD
from ghostball.validation.results.store import Results

SLOWING, DYING = "board_engines:Slowing", "board_engines:Dying"


@pytest.fixture(autouse=True)
def _findable(monkeypatch):
    """Let the processes that measure find the engines of the tests."""
    from pathlib import Path

    import board_engines

    monkeypatch.setenv("PYTHONPATH", str(Path(board_engines.__file__).parent))


@pytest.mark.slow
def test_an_engine_that_dies_beside_real_tables_did_not_finish(tmp_path):
    arguments = ["leaderboard", "--only", "-e", "ghostball", "-e", DYING, "--out", str(tmp_path)]
    done = CliRunner().invoke(app, [*arguments, "--column", "table"])
    assert done.exit_code == 1, done.output
    assert f"did not finish like a table on {DYING}: no rebound" in done.output
    assert load(tmp_path / BOARD).cell("ghostball", "table").kind == "beside"


@pytest.mark.usefixtures("in_this_process")
def test_the_command_shows_a_strangers_row_and_its_verdict(tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "20")  # a narrow window cuts no cell short
    arguments = ["leaderboard", "--only", "-e", "ghostball", "-e", SLOWING, "--out", str(tmp_path)]
    done = CliRunner().invoke(app, [*arguments, "--column", "line", "--column", "throw"])
    assert done.exit_code == 1, done.output  # a restitution of 0.8 where 1 is asked
    assert "sequential" in done.output
    assert "exact" in done.output
    assert "checks passed" in done.output
    again = CliRunner().invoke(app, [*arguments, "--column", "line", "--format", "json"])
    rows = json.loads(again.stdout)["rows"]
    assert rows[SLOWING]["line"]["again"] == (
        f"ghostball leaderboard --only -e {SLOWING} --column line --rerun"
    )


@pytest.mark.slow
def test_a_coarse_step_of_a_column_is_no_claim_of_the_engine(tmp_path):
    engine = "ghostball.validation.examples.first_engine:simulate"
    arguments = ["leaderboard", "--only", "-e", engine, "--out", str(tmp_path)]
    done = CliRunner().invoke(app, [*arguments, "--column", "mm"])
    assert done.exit_code == 0, done.output
    assert "no shot of" not in done.output
    coarse = [case for case in Results.open(tmp_path).cases if case.settings["dt"] == 0.01]
    assert not any(map(is_outcome_judged, coarse))
    alone = CliRunner().invoke(
        app,
        [
            "validate",
            "-e",
            f"{engine}:dt=0.01",
            str(scene_path("cut-to-rest")),
            "--no-report",
            "-o",
            str(tmp_path / "alone"),
        ],
    )
    assert alone.exit_code == 4, alone.output


@pytest.mark.usefixtures("in_this_process")
def test_validate_says_the_same_of_the_same_runs(tmp_path):
    engines = ["-e", "ghostball", "-e", "pymunk", "-e", SLOWING]
    board = ["leaderboard", "--only", *engines, "--column", "line"]
    scenes = [str(scene_path(one)) for one in COLUMNS["line"].scenes]
    statuses = [
        CliRunner().invoke(app, [*command, "--out", str(tmp_path / command[0])]).exit_code
        for command in (board, ["validate", *scenes, *engines, "--no-report"])
    ]
    assert statuses == [1, 1]
    one, other = (
        {(case.scene, case.label): case.checks for case in Results.open(tmp_path / name).cases}
        for name in ("leaderboard", "validate")
    )
    assert one == other


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--column", "speed"], "`--column` must be one of cut"),
        (["--sort", "speed"], "`--sort` must be one of cut"),
        (["--only"], "needs at least one"),
    ],
)
def test_what_is_no_board_is_refused(tmp_path, options, says):
    done = CliRunner().invoke(app, ["leaderboard", *options, "--out", str(tmp_path)])
    assert refused(done, says)
