"""`ghostball regress`, `accept`: options, exit statuses, what is printed where."""

from __future__ import annotations

import importlib
import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import gate
import pytest
from stored_results import cut_short, in_database
from typer.testing import CliRunner

import ghostball._regress
import ghostball.reference_adapters.ghostball
import ghostball.validation.runs.our_run
from ghostball.cli import app
from ghostball.engine import simulate
from ghostball.validation.baselines import (
    load_baseline,
    load_regression,
)
from ghostball.validation.baselines.accept import CHANGES_FILE
from ghostball.validation.baselines.baseline import baseline_path
from ghostball.validation.baselines.regression import Regression
from ghostball.validation.results.store import Results

BASELINES = Path(__file__).parents[2] / "benchmarks" / "baselines"
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


def test_baselines_lie_in_the_project_unless_told(here):
    # Breaks where a user's baselines are written into the package that is installed.
    assert cli("regress", "cut.toml").exit_code == 4
    assert cli("accept", "--reason", "The first.").exit_code == 0
    assert (here / "baselines" / "ghostball" / "cut.toml").exists()


def test_what_moved_is_told_and_fails(accepted, planted):
    result = regress("--rerun")
    assert result.exit_code == 1, result.output
    assert re.search(r"cut +worse against truth +.*rests 1\.\d+e-09 m", result.stdout)
    assert result.stdout.splitlines()[-1].startswith("failed: 1 identical, 1 worse against truth")
    assert "`ghostball report out` shows it" in result.stderr
    compared = load_regression(accepted / "out").scenes
    assert [one.scene for one in compared if one.candidate] == ["cut"]


def test_one_of_two_is_accepted_by_its_pattern(accepted, busier):
    assert regress("--rerun").exit_code == 1
    nothing = accept("x*")
    assert nothing.exit_code == 2
    assert 'nothing to accept matches "x*"; what there is to accept: cut' in nothing.stderr
    done = accept("c*", reason="Counts one more.")
    assert done.exit_code == 0
    assert "accepted: cut" in done.stdout
    assert regress("--rerun").exit_code == 0
    changelog = (accepted / "accepted" / "ghostball" / CHANGES_FILE).read_text("utf-8")
    assert changelog.index("Counts one more.") < changelog.index("It is right.")


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
    page = cli("report", "out", "--format", "github").stdout
    assert "fails until that is mended" in page


def test_what_broke_the_limits_of_truth_still_fails_once_it_is_accepted(accepted, planted):
    regress("--rerun")
    done = accept("--even-though-limits-fail")
    assert done.exit_code == 0
    assert "accepted though limits of truth are broken: cut: " in done.stderr
    assert "accepted: cut" in done.stdout
    result = regress("--rerun")
    assert result.exit_code == 1
    assert result.stdout.splitlines()[-1].startswith("failed: 2 identical")
    assert "limits of truth broken" in result.stdout


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


def test_another_folder_is_named_in_the_advice(here):
    result = regress("--out", "other")
    assert "`ghostball accept --out other --baselines accepted" in result.stderr
    assert accept("--out", "other").exit_code == 0


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


def test_a_comparison_that_was_cut_short_is_not_accepted(here):
    regress()
    cut_short(here / "out")
    assert refused(accept(), "is cut short or damaged", "Move the file away")
    assert not (here / "accepted").exists()


def test_a_crash_of_the_engine_exits_with_3_and_is_told(accepted, monkeypatch):
    def crash(scene, **options):
        raise ZeroDivisionError("planted")

    monkeypatch.setattr(ghostball.reference_adapters.ghostball, "simulate", crash)
    result = regress("--rerun")
    assert result.exit_code == 3, result.output
    assert result.stdout.splitlines()[-1].startswith("failed: 2 worse against truth, 2 did not")
    assert "planted" in result.stdout


def test_limits_of_truth_that_are_broken_fail_though_no_bit_moved(accepted):
    (accepted / "cut.expect.toml").write_text(
        '[[criteria]]\nengines = ["ghostball"]\nmetric = "collision_count"\nequals = 99\n'
        'reason = "planted"\n',
        "utf-8",
    )
    result = regress("--rerun")
    assert result.exit_code == 1, result.output
    last = result.stdout.splitlines()[-1]
    assert last.startswith("failed: 2 identical, 1 limits of truth broken")


@pytest.mark.parametrize("where", ["compare_results", "save_regressions"])
def test_an_interrupt_leaves_no_comparison(accepted, monkeypatch, where):
    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(ghostball._regress, where, stop)
    result = cli("regress", "cut.toml", "--baselines", "accepted")
    assert result.exit_code == 130
    assert "Interrupted" in result.stderr
    assert load_regression(accepted / "out") is None
    assert refused(accept(), "holds no comparison")


def test_an_interrupt_of_the_runs_compares_nothing(here, monkeypatch):
    def stop(scene, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(ghostball.reference_adapters.ghostball, "simulate", stop)
    result = regress()
    assert result.exit_code == 130, result.output
    assert "nothing was compared" in result.stderr
    assert result.stdout == ""


# --- anyone's engine ---------------------------------------------------------------------------


@pytest.fixture
def project(tmp_path, monkeypatch, in_this_process):
    """A folder with an engine and its settings, as `ghostball init` writes them."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.delitem(sys.modules, "my_engine", raising=False)
    assert cli("init").exit_code == 0
    write_config(tmp_path, engines=["my_engine:MyEngine"], scenes=["stop", "head-on"])
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
    baseline = load_baseline(project / "baselines/my-engine/stop.toml", "my-engine")
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


def test_another_last_bit_of_an_engine_of_ones_own_is_told_and_passes(project):
    # Its bits may differ from machine to machine; whoever promises them edits the level.
    guard()
    cli("accept", "--reason", "The first.")
    edit_engine("self.settings.dt", "self.settings.dt * (1 + 4e-16)")
    found = guard()
    assert found.exit_code == 0, found.output
    assert "rounding only" in found.stdout
    for path in (project / "baselines/my-engine").glob("*.toml"):
        path.write_text(
            path.read_text("utf-8").replace('level = "warn"', 'level = "error"'), "utf-8"
        )
    assert guard().exit_code == 1


def test_an_engine_of_ones_own_that_gives_other_bits_each_time_is_never_accepted(project):
    guard()
    cli("accept", "--reason", "The first.")
    edit_engine("import numpy as np", "import random\n\nimport numpy as np")
    edit_engine("self.settings.dt", "self.settings.dt * (1.0 + 1e-3 * random.random())")
    found = guard()
    assert found.exit_code == 1, found.output
    assert "2 not deterministic" in found.stdout
    done = cli("accept", "--reason", "Chance.")
    assert done.exit_code == 1
    said = "engine `my-engine` gives other bits each time that it plays stop, head-on"
    assert said in done.stderr
    shutil.rmtree("baselines")
    assert guard().exit_code == 1
    done = cli("accept", "--reason", "Chance.")
    assert done.exit_code == 1
    assert said in done.stderr
    assert not Path("baselines").exists()


def test_numbers_that_are_not_finite_fail_and_are_not_accepted(project):
    edit_engine("t, x = t + dt, x + dt * v", "t, x = t + dt, x + dt * v * np.nan")
    edit_engine("while v.any():", "while v.any() and t < 1.0:")
    found = guard()
    assert found.exit_code == 1, found.output
    assert "finite" in found.stdout
    assert refused(cli("accept", "--reason", "No."), "nothing to accept")


def test_a_baseline_of_another_engine_is_refused(project):
    guard("stop")
    cli("accept", "--reason", "The first.")
    path = project / "baselines/my-engine/stop.toml"
    path.write_text(path.read_text("utf-8").replace('"my-engine"', '"other"'), "utf-8")
    assert refused(guard("stop"), "`engine` must be `my-engine`, got `other`")


def test_each_of_several_engines_has_its_own_gate(project):
    found = guard("stop", "-e", "my_engine:MyEngine", "-e", "ghostball", "--format=junit")
    assert found.exit_code == 4, found.output
    names = {one.get("name") for one in ElementTree.fromstring(found.stdout).iter("testcase")}
    assert {"my_engine:MyEngine: baseline", "ghostball: baseline"} <= names
    both = ["-e", "my_engine:MyEngine", "-e", "ghostball"]
    printed = guard("stop", *both, "--format=json")
    assert printed.stdout.count("\n") == 1
    document = json.loads(printed.stdout)
    assert [Regression.model_validate(one).label for one in document["regressions"]] == both[1::2]
    assert {case["label"] for case in document["cases"]} == set(both[1::2])
    assert cli("accept", "--reason", "Both.", *both).exit_code == 0
    folders = sorted(path.name for path in (project / "baselines").iterdir())
    assert folders == ["ghostball", "my-engine"]
    assert refused(cli("accept", "--reason", "Again.", *both), "nothing to accept")


def test_a_baseline_of_a_scene_that_is_no_more_is_told_where_all_scenes_run(project):
    guard()
    cli("accept", "--reason", "The first.")
    write_config(project, engines=["my_engine:MyEngine"], scenes=["stop"])
    for all_scenes in ([], ["stop"]):
        assert "baselines of scenes that are no more: head-on" in guard(*all_scenes).stdout
    assert "no more" not in guard("thin-cut").stdout


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('engins = ["ghostball"]', "`tool.ghostball.engins` is not a known setting. Did you mean"),
        ("engines = [1]", "`engines.0` must be a valid string, got 1"),
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


def test_settings_hold_below_the_folder_of_their_file(here, monkeypatch):
    write_config(here, scenes=["cut.toml"], baselines="kept")
    (here / "below").mkdir()
    monkeypatch.chdir(here / "below")
    assert guard().exit_code == 4
    assert (here / "out").is_dir()
    assert cli("accept", "--reason", "The first.").exit_code == 0
    assert (here / "kept/ghostball/cut.toml").exists()


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
    edit_engine("x = t + dt, x + dt * v", "x = t + dt, x + 1.5 * dt * v")
    found = against()
    assert found.returncode == 1, found.stdout + found.stderr
    assert re.search(r"stop +my_engine:MyEngine +", found.stdout)
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


def test_validate_without_baselines_compares_nothing(here):
    assert validate().exit_code == 0
    assert load_regression(here / "out") is None


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


def test_what_breaks_a_limit_alone_has_not_moved(ours):
    # Breaks where a limit that fails is told as a change since the baselines were accepted.
    limit = '[[criteria]]\nengines = ["ghostball"]\nmetric = "collision_count"\nequals = 99\n'
    (ours / "cut.expect.toml").write_text(f'{limit}reason = "planted"\n', "utf-8")
    write_config(ours, scenes=["cut.toml"])
    assert cli("regress").exit_code == 1
    assert cli("accept", "--reason", "No.", "--even-though-limits-fail").exit_code == 0
    result = cli("validate", "-e", "ghostball", "--no-report")
    assert result.exit_code == 1, result.output
    assert "moved since" not in result.output


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


def test_regress_leaves_what_validate_found_of_other_engines(ours):
    assert cli("validate", "stop", "-e", "ghostball", "-e", "pymunk", "--no-report").exit_code == 0
    result = cli("regress", "stop", "-e", "ghostball")
    assert result.exit_code == 0, result.output
    assert "passed: 1 identical" in result.stdout
    assert Results.open(ours / "out").labels == ["ghostball", "pymunk"]


def test_validate_without_an_engine_that_is_guarded_compares_nothing(ours):
    here = ours
    validate()
    result = cli("validate", "stop", "-e", "pymunk", "--no-report")
    assert result.exit_code in (0, 1), result.output
    assert load_regression(here / "out") is None, "of an earlier run"


# --- help -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("command", "parts"),
    [
        (
            "regress",
            ["--against", "--baselines", "--format", "Exit status 1", "4 where"],
        ),
        ("accept", ["--reason", "--engine", "--out", "--baselines"]),
    ],
)
def test_help_names_every_option(command, parts):
    result = cli(command, "--help")
    assert result.exit_code == 0
    words = " ".join(result.stdout.split())
    for part in parts:
        assert part in words
