"""`ghostball validate --ensemble`: what it prints, keeps and refuses."""

from collections.abc import Sequence
from pathlib import Path

import pytest
from stored_results import in_database, stored
from typer.testing import CliRunner

import ghostball.validation.ensembles.run as run_module
from ghostball.cli import app
from ghostball.validation.ensembles import Ensembles, Size

# How perturbed shots run in other processes is tested where they run; here one test does it.
pytestmark = pytest.mark.usefixtures("without_run_figures")

ENGINES = [f"-e{name}" for name in ("ghostball", "paper-discrete", "paper-continuous")]


@pytest.fixture
def cli_with_processes(monkeypatch):
    """Run a command in this process, with lines of a length of its own; its engines in others."""
    monkeypatch.setenv("COLUMNS", "200")

    def run(*arguments):
        return CliRunner().invoke(app, [str(argument) for argument in arguments])

    return run


@pytest.fixture
def cli(cli_with_processes, in_this_process):
    """Run a command and its engines in this process: to start another one takes a second."""
    return cli_with_processes


def validate(cli, out: Path, *more: object, engines: Sequence[str] = ENGINES):
    return cli("validate", "stop", *engines, "--out", out, *more)


def test_ensembles_are_run_shown_reported_and_taken_over(cli, tmp_path):
    out = tmp_path / "out"
    result = validate(cli, out, "--ensemble", 12)
    assert result.exit_code == 0, result.output
    for part in (
        "ghostball (null test)   12 of 12",
        "paper-discrete          12 of 12",
        "≠ 0.",  # it stops 11 mm away
        "velocity=0.001,position=0.0001",
        "a comparison of codes, not with truth",
        "null test of ghostball passed",
        "checks passed",
    ):
        assert part in result.stdout
    assert "Ensemble of stop" in (out / "report.html").read_text()
    again = validate(cli, out, "--ensemble", 12)
    assert again.exit_code == 0
    assert "48 of 48 perturbed shots unchanged, taken over" in again.stderr
    rerun = validate(cli, out, "--ensemble", 3, "--rerun", "--no-report")
    assert "perturbed shots unchanged" not in rerun.stderr
    assert "null test of ghostball not judged" in rerun.stdout
    # The suite alone, later: the ensembles stay, and in the report.
    assert validate(cli, out).exit_code == 0
    assert "Ensemble of stop" in (out / "report.html").read_text()


def test_the_size_is_settable_and_stored(cli, tmp_path):
    result = validate(
        cli,
        tmp_path,
        "--ensemble",
        2,
        "--ensemble-size",
        "velocity=0.01",
        "--no-report",
    )
    assert result.exit_code == 0, result.output
    assert "velocity=0.01,position=0.0001" in result.stdout
    assert Ensembles.load(tmp_path).run.size == Size(velocity=0.01, position=1e-4)


def test_engines_that_cannot_are_named(cli, tmp_path):
    result = cli(
        *("validate", "sliding-stun", *ENGINES, "--out", tmp_path),
        *("--ensemble", 2, "--no-report"),
    )
    assert result.exit_code == 0, result.output
    assert (
        "sliding-stun: not representable (the report says why): paper-discrete, paper-continuous"
        in result.stdout
    )


def test_a_member_that_an_engine_fails_on_is_a_fault_of_that_engine(cli, tmp_path, monkeypatch):
    real = run_module.run_member

    def failing(task):
        fails = task.label == "paper-discrete" and task.index < 2
        return run_module.unended(task, "bad [luck]") if fails else real(task)

    monkeypatch.setattr(run_module, "run_member", failing)
    result = validate(cli, tmp_path, "--ensemble", 4, "--no-report")
    assert result.exit_code == 1
    assert result.stderr.count("bad [luck]") == 1
    assert "stop on paper-discrete: 2 members failed: bad [luck]" in result.stdout
    assert "2 of 4" in result.stdout


def test_a_failed_null_test_fails_the_run(cli, tmp_path, monkeypatch):
    real = run_module.perturb

    def longer(scene, size, index, stream):
        far = scene if stream == "shots" else scene.model_copy(update={"name": "another"})
        member = real(far, size, index, stream)
        if stream == "shots":
            return member
        cue = member.balls[0].model_copy(update={"velocity": (0.1, 0.0, 0.0)})
        return member.model_copy(update={"balls": (cue,), "name": scene.name})

    monkeypatch.setattr(run_module, "perturb", longer)
    result = validate(cli, tmp_path, "--ensemble", 12, "--no-report")
    assert result.exit_code == 1
    assert "null test of ghostball failed" in result.stdout


def test_ctrl_c_keeps_what_is_done(cli, tmp_path, monkeypatch):
    real = run_module.run_member

    def interrupted(task):
        if task.label == "paper-discrete" and task.index == 1:
            raise KeyboardInterrupt
        return real(task)

    monkeypatch.setattr(run_module, "run_member", interrupted)
    result = validate(cli, tmp_path, "--ensemble", 4)
    assert result.exit_code == 130
    assert "9 of 16 perturbed shots are done and kept" in result.stderr
    assert not (tmp_path / "report.html").exists()
    ensembles = Ensembles.load(tmp_path)
    assert ensembles is not None
    assert ensembles.run.state == "interrupted"
    monkeypatch.setattr(run_module, "run_member", real)
    again = validate(cli, tmp_path, "--ensemble", 4, "--no-report")
    assert again.exit_code == 0
    assert "9 of 16 perturbed shots unchanged" in again.stderr


@pytest.mark.parametrize(
    ("engines", "more", "said"),
    [
        (ENGINES, ["--ensemble", "1"], "must have 2 to 1000 members, got 1"),
        (ENGINES, ["--ensemble", "100000"], "must have 2 to 1000 members"),
        (["-e", "ghostball"], ["--ensemble", "5"], "there must be that one and another"),
        (["-epymunk", "-epaper-discrete"], ["--ensemble", "5"], "compare engines with `ghostball`"),
        (ENGINES, ["--ensemble", "5", "--ensemble-size", "velocity=-1"], "at least 0, got -1"),
        (ENGINES, ["--ensemble", "5", "--ensemble-size", "position=nan"], "finite"),
        (ENGINES, ["--ensemble", "5", "--ensemble-size", "position=1"], "could change places"),
        (ENGINES, ["--ensemble-size", "velocity=1e-3"], "needs --ensemble K"),
        (ENGINES, ["--ensemble", "few"], "should be a valid integer"),
    ],
)
def test_bad_input_is_refused_before_anything_runs(cli, tmp_path, engines, more, said):
    out = tmp_path / "out"
    result = validate(cli, out, *more, engines=engines)
    assert result.exit_code == 2, result.output
    assert said in result.stderr.replace("\n", " ")
    assert "Traceback" not in result.stderr
    assert result.stdout == ""
    assert not out.exists()


def test_damaged_ensembles_are_refused_and_nothing_is_overwritten(cli, tmp_path):
    assert validate(cli, tmp_path, "--ensemble", 2, "--no-report").exit_code == 0
    soon = "UPDATE documents SET content = json_set(content, '$.ensembles[0].times', 'soon')"
    in_database(tmp_path, soon + " WHERE name = 'ensembles'")
    before = stored(tmp_path)
    for result in (validate(cli, tmp_path, "--ensemble", 2), cli("report", tmp_path)):
        assert result.exit_code == 2
        assert "what its ensembles are of is damaged: `ensembles.0.times`" in result.stderr
    assert stored(tmp_path) == before
