"""`ghostball regress`, `accept`: options, exit statuses, what is printed where."""

from __future__ import annotations

import importlib
import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import gate
import pytest
from stored_results import in_database
from typer.testing import CliRunner

import ghostball.cli.gate.regress
import ghostball.reference_adapters.ghostball
import ghostball.validation.runs.our_run
from ghostball.cli import app
from ghostball.engine import simulate
from ghostball.validation.baselines import (
    load_baseline,
    load_regression,
)
from ghostball.validation.baselines.accept import CHANGES_FILE
from ghostball.validation.baselines.places import (
    baseline_path,
)
from ghostball.validation.baselines.regression import Regression

BASELINES = Path(__file__).parents[4] / "benchmarks" / "baselines"
"""Those of our own engine, in this repository."""


@pytest.fixture
def here(tmp_path, monkeypatch, in_this_process):
    """Two scenes in the working directory."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    for scene in (gate.cut_shot(), gate.roll_shot()):
        scene.save(tmp_path / f"{scene.name}.toml")
    return tmp_path


def cli(*arguments):
    result = CliRunner().invoke(app, [*map(str, arguments)])
    assert "\x1b" not in result.output, "control codes without a terminal"
    return result


def regress(*arguments, scenes=("cut.toml", "roll.toml")):
    return cli("regress", *scenes, "--baselines", "accepted", *arguments)


def accept(*arguments, reason="It is right."):
    return cli("accept", "--baselines", "accepted", "--reason", reason, *arguments)


@pytest.fixture
def accepted(here):
    assert regress().exit_code == 4
    assert accept().exit_code == 0
    return here


@pytest.fixture
def planted(monkeypatch):
    """Our engine loses a nanometre of each place where a ball of the cut comes to rest."""

    def lossy(scene, **options):
        result = simulate(scene, **options)
        if scene.name != "cut":
            return result
        state = result.final_state
        return replace(result, final_state=state._replace(positions=state.positions - 1e-9))

    for module in (ghostball.reference_adapters.ghostball, ghostball.validation.runs.our_run):
        monkeypatch.setattr(module, "simulate", lossy)


@pytest.fixture
def busier(monkeypatch):
    """Our engine counts an event more in the cut and in the shipped stop, and moves no bit."""

    def count(scene, **options):
        result = simulate(scene, **options)
        more = {"events": result.work["events"] + (scene.name in ("cut", "stop"))}
        return replace(result, work={**result.work, **more})

    monkeypatch.setattr(ghostball.reference_adapters.ghostball, "simulate", count)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


# --- the way through --------------------------------------------------------------------------


def test_no_baseline_then_accepted_then_passed(here):
    first = regress()
    assert first.exit_code == 4, first.output
    assert "without a baseline: cut, roll" in first.stdout
    assert first.stdout.splitlines()[-1].startswith("no baseline yet of 2 scenes, which ran")
    assert '`ghostball accept --baselines accepted --reason "..."`' in first.stderr
    assert not (here / "accepted").exists()
    done = accept()
    assert done.exit_code == 0, done.output
    assert "accepted: cut, roll" in done.stdout
    assert CHANGES_FILE in done.stdout
    second = regress()
    assert second.exit_code == 0, second.output
    assert "passed: 2 identical" in second.stdout
    assert "accept" not in second.stderr


def test_what_moved_is_reported_and_fails(accepted, planted):
    result = regress("--rerun")
    assert result.exit_code == 1, result.output
    assert re.search(r"cut +worse against truth +.*rests 1\.\d+e-09 m", result.stdout)
    assert result.stdout.splitlines()[-1].startswith("failed: 1 identical, 1 worse against truth")
    assert "`ghostball report out` shows it" in result.stderr
    compared = load_regression(accepted / "out").scenes
    assert [one.scene for one in compared if one.candidate] == ["cut"]


def test_what_breaks_limits_of_truth_is_refused_and_listed(accepted, planted):
    # Breaks where a bug is accepted without a word.
    found = regress("--rerun")
    assert found.exit_code == 1
    assert "ghostball accept" not in found.stderr
    assert "Limits of truth are broken, so this is to be mended, not accepted: cut" in found.stderr
    before = contents(accepted / "accepted" / "ghostball")
    refused = accept()
    assert refused.exit_code == 1
    assert refused.stdout == ""
    assert re.search(r"cut: .*must be <= .*, got ", refused.stderr)
    assert "--even-though-limits-fail" in refused.stderr
    assert contents(accepted / "accepted" / "ghostball") == before
    page = cli("report", "out", "--format", "markdown").stdout
    assert "fails until that is mended" in page


def test_json_is_one_object_and_all_else_is_on_stderr(accepted, planted):
    result = regress("--rerun", "--format=json")
    assert result.exit_code == 1
    assert result.stdout.count("\n") == 1
    (one,) = json.loads(result.stdout)["regressions"]
    printed = Regression.model_validate(one)
    assert printed == load_regression(accepted / "out")
    assert printed.scene("cut").failed


def test_what_changed_is_written_as_junit(accepted, planted):
    result = regress("--rerun", "--format", "junit")
    assert result.exit_code == 1
    suites = ElementTree.fromstring(result.stdout.encode()).findall("testsuite")
    assert {one.get("name"): int(one.get("failures")) > 0 for one in suites} == {
        "cut": True,
        "roll": False,
    }


# --- exit statuses and input ------------------------------------------------------------------


def refused(result, *parts):
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    for part in parts:
        assert part in result.stderr
    return True


def test_a_baseline_that_is_nonsense_is_refused_before_anything_runs(accepted):
    path = baseline_path(accepted / "accepted" / "ghostball", "cut")
    path.write_text(path.read_text("utf-8").replace('"error"', '"fatal"', 1), "utf-8")
    before = contents(accepted / "accepted" / "ghostball")
    in_database(accepted / "out", "DELETE FROM documents WHERE name = 'regression'")
    assert refused(regress("--rerun"), "accepted/ghostball/cut.toml", "'fatal'", "git checkout")
    assert contents(accepted / "accepted" / "ghostball") == before
    assert load_regression(accepted / "out") is None


def test_a_baseline_of_another_version_cannot_be_compared(accepted):
    path = baseline_path(accepted / "accepted" / "ghostball", "cut")
    path.write_text(path.read_text("utf-8").replace("schema = 3", "schema = 2"), "utf-8")
    result = regress()
    assert result.exit_code == 4, result.output
    assert "not comparable" in result.stdout
    assert "`schema` must be 3, got 2" in result.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["none-such"], "none-such"),
        (["--baselines", "cut.toml"], "not a folder"),
        pytest.param(
            ["--against", "none-such"],
            "`--against` must name a commit",
            marks=pytest.mark.checkout,  # elsewhere no revision is looked for
        ),
        (["--out", "cut.toml"], "cut.toml"),
        (["--format", "xml"], "--format"),
    ],
)
def test_bad_input_is_refused(here, arguments, said):
    scenes = () if arguments == ["none-such"] else ("cut.toml",)
    assert refused(cli("regress", *scenes, *arguments), said)


def test_accepting_needs_a_reason_and_a_comparison(here):
    assert cli("accept").exit_code == 2
    assert refused(accept(), "holds no comparison", "`ghostball regress")
    regress()
    assert refused(accept(reason=" "), "`reason`")
    assert refused(accept("--out", "cut.toml"), "cut.toml")
    assert not (here / "accepted").exists()


# --- anyone's engine ---------------------------------------------------------------------------


@pytest.fixture
def project(tmp_path, monkeypatch, in_this_process):
    """A folder with an engine and its settings, as `ghostball init` writes them."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.delitem(sys.modules, "my_engine", raising=False)
    assert cli("init").exit_code == 0
    write_config(tmp_path, engines=["my_engine:simulate"], scenes=["stop", "head-on"])
    yield tmp_path
    sys.modules.pop("my_engine", None)


def edit_engine(old, new):
    path = Path("my_engine.py")
    text = path.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new), "utf-8")
    # Bytecode is of a file of this size and second: an edit of the same size comes a second later.
    edited = path.stat().st_mtime + 1.0
    os.utime(path, (edited, edited))
    importlib.invalidate_caches()
    sys.modules.pop("my_engine", None)


def guard(*arguments):
    return cli("regress", *arguments)


def test_the_gate_of_an_engine_of_ones_own_from_none_to_a_change_and_its_acceptance(project):
    first = guard()
    assert first.exit_code == 4, first.output
    assert cli("accept", "--reason", "The first.").exit_code == 0
    baseline = load_baseline(project / "baselines/my_engine/stop.toml", "my_engine")
    assert baseline.hash.level == "warn"
    second = guard()
    assert second.exit_code == 0, second.output
    assert "passed: 2 identical" in second.stdout
    edit_engine("1e-3", "2e-3")
    assert refused(cli("accept", "--reason", "Unseen."), "the code changed since that comparison")
    third = guard()
    assert third.exit_code == 1, third.output
    assert "2 ms" not in third.stdout
    assert load_regression(project / "out").scene("head-on").failed
    assert cli("accept", "--reason", "A longer step.").exit_code == 0
    assert guard().exit_code == 0


def test_each_of_several_engines_has_its_own_gate(project):
    found = guard("stop", "-e", "my_engine:simulate", "-e", "ghostball", "--format=junit")
    assert found.exit_code == 4, found.output
    names = {one.get("name") for one in ElementTree.fromstring(found.stdout).iter("testcase")}
    assert {"my_engine:simulate: baseline", "ghostball: baseline"} <= names
    both = ["-e", "my_engine:simulate", "-e", "ghostball"]
    printed = guard("stop", *both, "--format=json")
    assert printed.stdout.count("\n") == 1
    document = json.loads(printed.stdout)
    assert [Regression.model_validate(one).label for one in document["regressions"]] == both[1::2]
    assert {case["label"] for case in document["cases"]} == set(both[1::2])
    assert cli("accept", "--reason", "Both.", *both).exit_code == 0
    folders = sorted(path.name for path in (project / "baselines").iterdir())
    assert folders == ["ghostball", "my_engine"]
    assert refused(cli("accept", "--reason", "Again.", *both), "nothing to accept")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('engins = ["ghostball"]', "`tool.ghostball.engins` is not a known setting. Did you mean"),
        ("engines = [1]", "`engines[0]` must be a valid string, got 1"),
        ('scenes = ["none-such"]', 'unknown scene or tag "none-such"'),
        ('scenes = ["none-such/*.toml"]', "matches no shipped scene and no TOML file"),
        ("engines = [", "not valid TOML"),
    ],
)
def test_a_configuration_that_is_wrong_is_refused(here, text, said):
    (here / "pyproject.toml").write_text(f"[tool.ghostball]\n{text}\n", "utf-8")
    for command in ("regress", "validate"):
        assert refused(cli(command), said)
    assert not (here / "out").exists()


@pytest.mark.slow
def test_an_engine_of_ones_own_is_compared_with_another_revision(project):
    def git(*arguments):
        who = ("-c", "user.name=a", "-c", "user.email=a@b")
        subprocess.run(["git", *who, *arguments], check=True, capture_output=True)

    def against(revision="HEAD"):
        # Of a shell, for both runs are commands of their own, and write to its stderr.
        words = ["regress", "stop", "--against", revision, "--jobs", "1"]
        command = [sys.executable, "-m", "ghostball", *words]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    git("init")
    assert refused(guard("stop", "--against", "HEAD"), "needs a git repository with the engine's")
    git("add", "my_engine.py")
    git("commit", "-m", "one")
    assert refused(guard("stop", "--against", "none-such"), "`--against` must name a commit")
    same = against()
    assert same.returncode == 0, same.stderr
    assert "1 of 1 cases are alike" in same.stdout
    edit_engine("x, t = x + step * v", "x, t = x + 1.5 * step * v")
    found = against()
    assert found.returncode == 1, found.stdout + found.stderr
    assert re.search(r"stop +my_engine:simulate +", found.stdout)
    worktrees = subprocess.check_output(["git", "worktree", "list"], text=True)
    assert worktrees.count("\n") == 1, "a worktree was left"


# --- validate ---------------------------------------------------------------------------------


def validate(*arguments):
    return cli("validate", "stop", "-e", "ghostball", "--no-report", *arguments)


@pytest.fixture
def ours(here):
    """The project has the baselines of our engine."""
    write_config(here, baselines=str(BASELINES))
    return here


def write_config(folder, **settings):
    lines = [f"{key} = {value!r}" for key, value in settings.items()]
    text = "\n".join(["[tool.ghostball]", *lines])
    (folder / "pyproject.toml").write_text(text, "utf-8")


def test_validate_compares_with_the_projects_baselines(ours):
    here = ours
    result = validate()
    assert result.exit_code == 0, result.output
    assert "moved since" not in result.output
    found = load_regression(here / "out")
    assert found.scene("stop").change == "identical"
    assert refused(cli("accept", "--reason", "None.", "--out", "out"), "nothing to accept")


def test_validate_says_what_moved_and_fails(ours, busier):
    here, before = ours, contents(BASELINES / "ghostball")
    result = validate()
    assert result.exit_code == 1, result.output
    assert "ghostball moved since its baselines were accepted: stop" in result.stdout
    assert "`ghostball regress` says how" in result.stdout
    assert load_regression(here / "out").scene("stop").failed
    assert contents(BASELINES / "ghostball") == before


def test_what_validate_found_can_be_accepted(here):
    assert cli("regress", "cut.toml").exit_code == 4
    assert cli("accept", "--reason", "The first.").exit_code == 0
    path = baseline_path(here / "baselines" / "ghostball", "cut")
    text = path.read_text("utf-8")
    path.write_text(re.sub(r"\nbounds = \d+", "\nbounds = 1", text), "utf-8")
    options = ("cut.toml", "-e", "ghostball", "--no-report")
    assert cli("validate", *options).exit_code == 1
    assert cli("accept", "--reason", "As it was.").exit_code == 0
    assert "\nbounds = 1\n" not in path.read_text("utf-8")
    assert cli("validate", *options).exit_code == 0


# --- help -------------------------------------------------------------------------------------


# --- what fails -------------------------------------------------------------------------------


def test_what_fails_is_asked_by_an_option_or_by_the_project(accepted, planted):
    assert regress("--rerun", "--fail-on", "worse").exit_code == 1  # it is
    settings = accepted / "pyproject.toml"
    settings.write_text('[tool.ghostball]\nfail_on = "wors"\n', "utf-8")
    refused = regress()
    assert refused.exit_code == 2
    assert "`fail_on` must be 'changed', 'worse' or 'limits', got 'wors'" in refused.stderr
    settings.write_text('[tool.ghostball]\nfail_on = "limits"\n', "utf-8")
    assert regress().exit_code == 1  # the planted nanometre breaks a limit of truth, too


def test_what_only_changed_may_pass(accepted, busier):
    assert regress("--rerun").exit_code == 1
    for asked in ("worse", "limits"):
        passed = regress("--fail-on", asked)
        assert passed.exit_code == 0, passed.output
        assert "of what moved," in passed.stdout.splitlines()[-1]
    page = cli("report", "out", "--format", "markdown").stdout
    assert "1 of 2 scenes moved as they may" in page
    assert "of what moved, nothing fails but for broken limits" in page


def test_limits_alone_need_no_baseline(here):
    passed = regress("--fail-on", "limits")
    assert passed.exit_code == 0, passed.output
    assert passed.stdout.splitlines()[-1].startswith("passed: 2 no baseline")


def test_another_revision_is_no_baseline_of_which_something_fails(here):
    refused = regress("--against", "HEAD", "--fail-on", "worse")
    assert refused.exit_code == 2
    assert "--against makes none" in refused.stderr
