"""`ghostball accept`: accepted and rejected results, and the required reason."""

from __future__ import annotations

import re
from dataclasses import replace

from commands import accept, cli, contents, edit_engine, refused, regress

from ghostball.validation.baselines import ComparedRun, load_baseline, load_regression
from ghostball.validation.baselines.baseline import Baseline, baseline_path


def test_results_that_fail_limits_are_rejected_and_listed(accepted, planted):
    # A bug must not be accepted silently.
    found = regress("--rerun")
    assert found.exit_code == 1
    assert "ghostball accept" not in found.stderr
    assert "Limits failed. Fix the engine instead of accepting these results: cut" in found.stderr
    before = contents(accepted / "accepted" / "ghostball")
    refused = accept()
    assert refused.exit_code == 1
    assert refused.stdout == ""
    assert re.search(r"cut: .*must be at most .*, got ", refused.stderr)
    assert "--even-though-limits-fail" in refused.stderr
    assert contents(accepted / "accepted" / "ghostball") == before
    page = cli("report", "out", "--format", "markdown").stdout
    assert "fails until the engine is fixed" in page


def test_accepting_needs_a_reason_and_a_comparison(here):
    assert cli("accept").exit_code == 2
    assert refused(accept(), "contains no comparison", "`ghostball regress")
    regress()
    assert refused(accept(reason=" "), "`reason`")
    assert refused(accept("--out", "cut.toml"), "cut.toml")
    assert not (here / "accepted").exists()


def test_the_gate_of_an_engine_of_ones_own_from_none_to_a_change_and_its_acceptance(project):
    first = cli("regress")
    assert first.exit_code == 4, first.output
    assert cli("accept", "--reason", "The first.").exit_code == 0
    baseline = load_baseline(project / "baselines/my_engine/stop.json", "my_engine")
    assert baseline.record.engine == "my_engine"
    second = cli("regress")
    assert second.exit_code == 0, second.output
    assert "passed: 2 unchanged" in second.stdout
    edit_engine("1e-3", "2e-3")
    assert refused(
        cli("accept", "--reason", "Unseen."), "the code has changed since that comparison"
    )
    third = cli("regress")
    assert third.exit_code == 1, third.output
    assert "2 ms" not in third.stdout
    assert load_regression(project / "out").scene("head-on").failed
    assert cli("accept", "--reason", "A longer step.").exit_code == 0
    assert cli("regress").exit_code == 0


def test_results_of_validate_can_be_accepted(here):
    assert cli("regress", "cut.toml").exit_code == 4
    assert cli("accept", "--reason", "The first.").exit_code == 0
    path = baseline_path(here / "baselines" / "ghostball", "cut")
    whole = load_baseline(path)
    record = replace(whole.record, work={**whole.record.work, "bounds": 1})
    path.write_text(
        Baseline.of(ComparedRun(record, whole.played.log), whole.accepted).text, "utf-8"
    )
    options = ("cut.toml", "-e", "ghostball", "--no-report")
    assert cli("validate", *options).exit_code == 1
    assert cli("accept", "--reason", "As it was.").exit_code == 0
    assert '"bounds": 1,' not in path.read_text("utf-8")
    assert cli("validate", *options).exit_code == 0


def test_a_scene_that_did_not_finish_is_named_and_is_no_success(project):
    fails = 'if scene.name == "head-on":\n        raise RuntimeError("lost it")\n    while v.any()'
    edit_engine("while v.any()", fails)
    assert cli("regress").exit_code == 1
    done = cli("accept", "--reason", "The first.")
    assert done.exit_code == 1
    assert done.stdout.startswith("accepted: stop\n")
    assert (
        "not accepted: head-on: the engine did not run the scene: RuntimeError: lost it"
        in done.stderr
    )
    assert [path.name for path in (project / "baselines/my_engine").glob("*.json")] == ["stop.json"]
