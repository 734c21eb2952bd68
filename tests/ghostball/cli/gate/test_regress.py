"""`ghostball regress` and `accept`: options, exit statuses, and output."""

from __future__ import annotations

import json
import re
from xml.etree import ElementTree

import pytest
from commands import BASELINES, accept, cli, contents, refused, regress, write_config
from stored_records import in_database

from ghostball.validation.baselines import load_regression
from ghostball.validation.baselines.accept import CHANGES_FILE
from ghostball.validation.baselines.baseline import baseline_path
from ghostball.validation.baselines.regression import Regression

# --- the whole workflow -----------------------------------------------------------------------


def test_no_baseline_then_accepted_then_passed(here):
    first = regress()
    assert first.exit_code == 4, first.output
    assert "no baseline: cut, roll" in first.stdout
    assert first.stdout.splitlines()[-1].startswith("no baseline yet for 2 scenes, which ran")
    assert '`ghostball accept --baselines accepted --reason "..."`' in first.stderr
    assert not (here / "accepted").exists()
    done = accept()
    assert done.exit_code == 0, done.output
    assert "accepted: cut, roll" in done.stdout
    assert CHANGES_FILE in done.stdout
    second = regress()
    assert second.exit_code == 0, second.output
    assert "passed: 2 unchanged" in second.stdout
    assert "accept" not in second.stderr


def test_changes_are_reported_and_fail(accepted, planted):
    result = regress("--rerun")
    assert result.exit_code == 1, result.output
    assert re.search(
        r"cut +worse +rounding -> 1\.\d+ nm +exact: .* -> nanometres: position error 1\.\d+ nm",
        result.stdout,
    )
    assert result.stdout.splitlines()[-1].startswith("failed: 1 worse, 1 unchanged")
    assert "`ghostball report out` shows old and new" in result.stderr
    compared = load_regression(accepted / "out").scenes
    assert [one.scene for one in compared if one.can_be_accepted] == ["cut"]


def test_json_is_one_object_and_all_else_is_on_stderr(accepted, planted):
    result = regress("--rerun", "--format=json")
    assert result.exit_code == 1
    assert result.stdout.count("\n") == 1
    (one,) = json.loads(result.stdout)["regressions"]
    printed = Regression.model_validate(one)
    assert printed == load_regression(accepted / "out")
    assert printed.scene("cut").failed


# --- exit statuses and input ------------------------------------------------------------------


def test_a_baseline_that_is_nonsense_is_refused_before_anything_runs(accepted):
    path = baseline_path(accepted / "accepted" / "ghostball", "cut")
    path.write_text(path.read_text("utf-8").replace('"roll-to-rest"', '"fatal"', 1), "utf-8")
    before = contents(accepted / "accepted" / "ghostball")
    in_database(accepted / "out", "DELETE FROM documents WHERE name = 'regression'")
    assert refused(regress("--rerun"), "accepted/ghostball/cut.json", "'fatal'", "git checkout")
    assert contents(accepted / "accepted" / "ghostball") == before
    assert load_regression(accepted / "out") is None


# --- anyone's engine ---------------------------------------------------------------------------


def test_each_of_several_engines_has_its_own_gate(project):
    found = cli("regress", "stop", "-e", "my_engine:simulate", "-e", "ghostball", "--format=junit")
    assert found.exit_code == 4, found.output
    names = {one.get("name") for one in ElementTree.fromstring(found.stdout).iter("testcase")}
    assert {"my_engine:simulate: baseline", "ghostball: baseline"} <= names
    both = ["-e", "my_engine:simulate", "-e", "ghostball"]
    printed = cli("regress", "stop", *both, "--format=json")
    assert printed.stdout.count("\n") == 1
    document = json.loads(printed.stdout)
    assert [Regression.model_validate(one).label for one in document["regressions"]] == both[1::2]
    assert {case["label"] for case in document["cases"]} == set(both[1::2])
    assert cli("accept", "--reason", "Both.", *both).exit_code == 0
    folders = sorted(path.name for path in (project / "baselines").iterdir())
    assert folders == ["ghostball", "my_engine"]
    assert refused(cli("accept", "--reason", "Again.", *both), "no change to accept")


# --- validate ---------------------------------------------------------------------------------


def validate(*arguments):
    return cli("validate", "stop", "-e", "ghostball", "--no-report", *arguments)


@pytest.fixture
def ours(here):
    """Give the project baselines of Ghostball's engine."""
    write_config(here, baselines=str(BASELINES))
    return here


def test_validate_compares_with_the_projects_baselines(ours):
    here = ours
    result = validate()
    assert result.exit_code == 0, result.output
    assert "changed since" not in result.output
    found = load_regression(here / "out")
    assert found.scene("stop").change == "unchanged"
    assert refused(cli("accept", "--reason", "None.", "--out", "out"), "no change to accept")


def test_validate_reports_changes_and_fails(ours, busier):
    here, before = ours, contents(BASELINES / "ghostball")
    result = validate()
    assert result.exit_code == 1, result.output
    assert "ghostball changed since its baselines were accepted: stop" in result.stdout
    assert "`ghostball regress` shows how" in result.stdout
    assert load_regression(here / "out").scene("stop").failed
    assert contents(BASELINES / "ghostball") == before


# --- what fails -------------------------------------------------------------------------------


def test_an_option_or_the_project_decides_which_changes_fail(accepted, planted):
    assert regress("--rerun", "--fail-on", "worse").exit_code == 1  # the result is worse
    settings = accepted / "pyproject.toml"
    settings.write_text('[tool.ghostball]\nfail_on = "wors"\n', "utf-8")
    refused = regress()
    assert refused.exit_code == 2
    said = "`tool.ghostball.fail_on` must be 'changed', 'worse' or 'limits', got 'wors'"
    assert said in refused.stderr
    settings.write_text('[tool.ghostball]\nfail_on = "limits"\n', "utf-8")
    assert regress().exit_code == 1  # the planted nanometre also fails a limit


def test_changes_without_larger_errors_may_pass(accepted, busier):
    assert regress("--rerun").exit_code == 1
    for asked in ("worse", "limits"):
        passed = regress("--fail-on", asked)
        assert passed.exit_code == 0, passed.output
        assert "count as failures" in passed.stdout.splitlines()[-1]
    page = cli("report", "out", "--format", "markdown").stdout
    assert "1 of 2 scenes changed as allowed" in page
    assert "only failed limits count as failures" in page


def test_limits_alone_need_no_baseline(here):
    passed = regress("--fail-on", "limits")
    assert passed.exit_code == 0, passed.output
    assert passed.stdout.splitlines()[-1].startswith("passed: 2 no baseline")
