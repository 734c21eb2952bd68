"""What fails; as notes of GitHub: one line each, and the rest counted."""

from __future__ import annotations

from dataclasses import replace

import pytest
from regressions import regression, unchanged, uncompared, worse

from ghostball.reports.ci.findings import SHOWN, Finding, findings, note, notes
from ghostball.validation.results.store import Results


@pytest.fixture(scope="module")
def results(results_folder):
    return Results.open(results_folder)


@pytest.fixture
def passed(results):
    """Results in which nothing fails."""
    return Results(results.path, [], results.environment)


def test_a_broken_limit_says_how_to_see_it(results):
    found = findings(results, [])
    (one,) = (f for f in found if f.title == "stop breaks a limit" and "discrete" in f.message)
    assert one.level == "error"
    assert "rest_error_max must be <= 0.005 m, got 0.03 m (a tenth of a ball)" in one.message
    assert one.message.endswith("Again: ghostball explain stop --engine paper-discrete")
    (lost,) = (f for f in found if f.title == "head-on did not finish")
    assert "newcomer:dt=1e-3: did not finish: division by zero" in lost.message


def test_what_moved_says_by_how_much(passed):
    shown = worse(), unchanged("stop"), unchanged("cut", change="better", head_hash="c" * 64)
    error, warning = findings(passed, [regression(*shown)])
    assert (error.level, error.title) == ("error", "break-7: worse")
    assert "which is missing now" in error.message
    assert error.message.startswith("ghostball: worse, rest error 7 fm -> 3 mm\n")
    assert (warning.level, warning.title) == ("warning", "cut: better")


def test_limits_alone_are_said_once(passed):
    broken = unchanged("stop", failed=True, broken=("energy_rise must be <= 0, got 1",))
    assert findings(passed, [regression(broken)]) == []


def test_missing_baselines_are_one_finding_unless_limits_alone_are_asked(passed):
    many = [uncompared(f"shot-{k}") for k in range(9)]
    (one,) = findings(passed, [regression(*many, outcome="no-baseline")])
    assert (one.level, one.title) == ("error", "no baseline")
    assert "in 9 scenes. Run `ghostball regress`" in one.message
    (few,) = findings(passed, [regression(many[0], outcome="no-baseline")])
    assert "in shot-0. Run" in few.message
    assert findings(passed, [regression(*many, outcome="passed", fail_on="limits")]) == []


def test_a_note_is_one_line_that_ends_no_property_early():
    one = Finding("error", "a", "a: b, c", "100 %\nnext")
    assert notes([one]) == ("::error title=Ghostball%3A a%3A b%2C c::100 %25%0Anext\n")
    assert note("error", "x", "y") == "::error title=Ghostball%3A x::y"


def test_more_than_github_shows_are_counted():
    def some(level, count):
        return [Finding(level, "a", f"{level}-{k}", "x") for k in range(count)]

    lines = notes([*some("error", SHOWN + 3), *some("warning", SHOWN)]).splitlines()
    assert len(lines) == 2 * SHOWN
    assert lines[SHOWN - 1].startswith("::error title=Ghostball%3A 4 more::error-9, error-10")


def test_what_was_not_tried_and_an_unfinished_run_are_said_once(results):
    case = replace(results.cases[0], label="mine", outcome="unavailable", reason="no wheel")
    cases = [replace(case, scene=name) for name in ("stop", "cut")]
    run = Results(results.path, cases, results.environment | {"state": "running"})
    compared = regression(unchanged(), warnings=("slow",))
    found = findings(run, [compared])
    said = [(one.level, one.title, one.message) for one in found]
    assert said == [
        ("error", "not complete", "the run is not complete: running"),
        ("warning", "mine is unavailable", "no wheel"),
        ("warning", "comparison with baselines", "slow"),
    ]
