"""`ghostball regress`, `accept`: options, exit statuses, what is printed where."""

from __future__ import annotations

import re
from dataclasses import replace
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
from ghostball.validation.baselines import NotComparableError, RevisionError, load_regression
from ghostball.validation.baselines.accept import CHANGES_FILE
from ghostball.validation.baselines.baseline import FOLDER, baseline_path
from ghostball.validation.baselines.regression import Regression


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
    assert first.stdout.splitlines()[-1].startswith("no baseline: 2 no baseline, against the acc")
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


def test_a_scene_of_ones_own_is_accepted_into_ones_own_folder_only(here):
    # Breaks where a user is told to accept into the package that is installed.
    result = cli("regress", "cut.toml")
    assert result.exit_code == 4, result.output
    assert "no baselines of scenes of your own, such as cut" in result.stderr
    assert "--baselines DIR" in result.stderr
    assert "ghostball accept" not in result.stderr


def test_what_moved_is_told_and_fails(accepted, planted):
    result = regress("--rerun")
    assert result.exit_code == 1, result.output
    assert re.search(r"cut +worse against truth +.*rests 1\.\d+e-09 m", result.stdout)
    assert result.stdout.splitlines()[-1].startswith("failed: 1 identical, 1 worse against truth")
    assert "`ghostball report out/regress` shows it" in result.stderr
    compared = load_regression(accepted / "out" / "regress").scenes
    assert [one.scene for one in compared if one.candidate] == ["cut"]


def test_one_of_two_is_accepted_by_its_pattern(accepted, busier):
    assert regress("--rerun").exit_code == 1
    nothing = accept("--only", "x*")
    assert nothing.exit_code == 2
    assert 'nothing to accept matches "x*"; what there is to accept: cut' in nothing.stderr
    done = accept("--only", "c*", reason="Counts one more.")
    assert done.exit_code == 0
    assert "accepted: cut" in done.stdout
    assert regress("--rerun").exit_code == 0
    changelog = (accepted / "accepted" / CHANGES_FILE).read_text("utf-8")
    assert changelog.index("Counts one more.") < changelog.index("It is right.")


def test_what_breaks_limits_of_truth_is_refused_and_listed(accepted, planted):
    # Breaks where a bug is accepted without a word.
    found = regress("--rerun")
    assert found.exit_code == 1
    assert "ghostball accept" not in found.stderr
    assert "Limits of truth are broken, so this is to be mended, not accepted: cut" in found.stderr
    before = contents(accepted / "accepted")
    refused = accept()
    assert refused.exit_code == 1
    assert refused.stdout == ""
    assert re.search(r"cut: .*must be <= .*, got ", refused.stderr)
    assert "--even-though-limits-fail" in refused.stderr
    assert contents(accepted / "accepted") == before
    page = cli("report", "out/regress", "--summary", "-").stdout
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
    result = regress("--rerun", "--json")
    assert result.exit_code == 1
    assert result.stdout.count("\n") == 1
    printed = Regression.model_validate_json(result.stdout)
    assert printed == load_regression(accepted / "out" / "regress")
    assert printed.scene("cut").failed


def test_what_changed_is_written_as_junit(accepted, planted):
    result = regress("--rerun", "--junit", "changed.xml")
    assert result.exit_code == 1
    suites = ElementTree.parse(accepted / "changed.xml").getroot().findall("testsuite")
    assert {one.get("name"): int(one.get("failures")) > 0 for one in suites} == {
        "cut": True,
        "roll": False,
    }


def test_another_folder_is_named_in_the_advice(here):
    result = regress("--out", "other")
    assert "`ghostball accept --from other --baselines accepted" in result.stderr
    assert accept("--from", "other").exit_code == 0


# --- exit statuses and input ------------------------------------------------------------------


def refused(result, *parts):
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    for part in parts:
        assert part in result.stderr
    return True


def test_a_baseline_that_is_nonsense_is_refused_before_anything_runs(accepted):
    path = baseline_path(accepted / "accepted", "cut")
    path.write_text(path.read_text("utf-8").replace('"error"', '"fatal"', 1), "utf-8")
    before = contents(accepted / "accepted")
    in_database(accepted / "out" / "regress", "DELETE FROM documents WHERE name = 'regression'")
    assert refused(regress("--rerun"), "accepted/cut.toml", "'fatal'", "git checkout")
    assert contents(accepted / "accepted") == before
    assert load_regression(accepted / "out" / "regress") is None


def test_a_baseline_of_another_version_cannot_be_compared(accepted):
    path = baseline_path(accepted / "accepted", "cut")
    path.write_text(path.read_text("utf-8").replace("schema = 1", "schema = 2"), "utf-8")
    result = regress()
    assert result.exit_code == 4, result.output
    assert "not comparable" in result.stdout
    assert "`schema` must be 1, got 2" in result.stdout


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
        (["--junit", "none/such.xml"], "--junit"),
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
    assert refused(accept("--from", "cut.toml"), "cut.toml")
    assert not (here / "accepted").exists()


def test_a_comparison_that_was_cut_short_is_not_accepted(here):
    regress()
    cut_short(here / "out" / "regress")
    assert refused(accept(), "is cut short or damaged", "Move the file away")
    assert not (here / "accepted").exists()


def test_what_can_not_be_compared_exits_with_4_and_prints_no_result(accepted, monkeypatch):
    def fail(*_, **__):
        raise NotComparableError("revision abc can't be built [here]")

    monkeypatch.setattr(ghostball._regress, "compare_revisions", fail)
    result = regress("--against", "abc")
    assert result.exit_code == 4
    assert result.stdout == ""
    assert "error: revision abc can't be built [here]" in result.stderr
    # What was compared before is not of these results.
    assert load_regression(accepted / "out" / "regress") is None


def test_a_revision_that_there_is_not_exits_with_2(accepted, monkeypatch):
    def fail(*_, **__):
        raise RevisionError("`--against` must name a commit")

    monkeypatch.setattr(ghostball._regress, "compare_revisions", fail)
    assert refused(regress("--against", "abc"), "`--against` must name a commit")


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


@pytest.mark.parametrize("where", ["compare_results", "save_regression"])
def test_an_interrupt_leaves_no_comparison(accepted, monkeypatch, where):
    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(ghostball._regress, where, stop)
    result = cli("regress", "cut.toml", "--baselines", "accepted")
    assert result.exit_code == 130
    assert "Interrupted" in result.stderr
    assert load_regression(accepted / "out" / "regress") is None
    assert refused(accept(), "holds no comparison")


def test_an_interrupt_of_the_runs_compares_nothing(here, monkeypatch):
    def stop(scene, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(ghostball.reference_adapters.ghostball, "simulate", stop)
    result = regress()
    assert result.exit_code == 130, result.output
    assert "nothing was compared" in result.stderr
    assert result.stdout == ""


# --- validate ---------------------------------------------------------------------------------


def validate(*arguments):
    return cli("validate", "stop", "--engines", "ghostball", "--no-report", *arguments)


def test_validate_compares_with_the_shipped_baselines(here):
    result = validate()
    assert result.exit_code == 0, result.output
    assert "moved since" not in result.output
    found = load_regression(here / "out")
    assert found.scene("stop").change == "identical"
    assert refused(accept("--from", "out"), "nothing to accept")


def test_validate_says_what_moved_and_judges_by_truth_alone(here, busier):
    before = contents(FOLDER)
    result = validate()
    assert result.exit_code == 0, result.output
    assert "our engine moved since its baselines were accepted: stop" in result.stdout
    assert "`ghostball regress` says how" in result.stdout
    assert load_regression(here / "out").scene("stop").failed
    assert contents(FOLDER) == before


def test_validate_without_our_engine_compares_nothing(here):
    validate()
    result = cli("validate", "stop", "--engines", "pymunk", "--no-report")
    assert result.exit_code in (0, 1), result.output
    assert load_regression(here / "out") is None, "of an earlier run"


# --- help -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("command", "parts"),
    [
        (
            "regress",
            ["--against", "--baselines", "--junit", "--no-times", "Exit status 1", "4 where"],
        ),
        ("accept", ["--reason", "--only", "--from", "--baselines"]),
    ],
)
def test_help_names_every_option(command, parts):
    result = cli(command, "--help")
    assert result.exit_code == 0
    words = " ".join(result.stdout.split())
    for part in parts:
        assert part in words
