"""A run has one verdict: the word names both answers, and the sign is the worse one's."""

from dataclasses import replace
from typing import get_args

import pytest
from regressions import quantity, regression, unchanged, uncompared, worse

from ghostball.reports.outcome import (
    CHANGES,
    bad_cases,
    kinds_text,
    of_comparison,
    of_limits,
    overall,
)
from ghostball.validation.baselines.regression import Change
from ghostball.validation.results.store import Results

PASSED = regression(unchanged(), outcome="passed")
FAILED = regression(worse(), unchanged())


def with_cases(results, cases, **environment):
    return Results(results.path, cases, results.environment | environment)


@pytest.fixture
def results(small_folder):
    """One scene on three engines, the last of which breaks a limit."""
    found = Results.open(small_folder)
    *good, last = found.cases
    broken = replace(last, checks=tuple(replace(one, passed=False) for one in last.checks))
    return with_cases(found, [*good, broken])


def test_a_run_fails_on_either_answer(results):
    bad = bad_cases(results)
    good = with_cases(results, [case for case in results.cases if case not in bad])
    assert (of_limits(results).sign, of_limits(good).sign) == ("✗", "✓")
    found = {
        (kept, moved): overall(results if not kept else good, FAILED if moved else PASSED)
        for kept in (True, False)
        for moved in (True, False)
    }
    assert {key: one.sign for key, one in found.items()} == {
        (True, False): "✓",
        (True, True): "✗",
        (False, False): "✗",
        (False, True): "✗",
    }
    assert found[True, True].short == "Limits hold, the gate fails"
    assert found[False, True].word == "Failed, the gate fails"


def test_what_did_not_end_or_was_not_judged_is_no_pass(results):
    bad = bad_cases(results)
    good = [case for case in results.cases if case not in bad]
    assert of_limits(with_cases(results, good, state="interrupted")).word == "Not complete"
    assert of_limits(with_cases(results, [])).word == "Nothing judged"
    assert of_comparison(regression(uncompared(), outcome="no-baseline")).sign == "?"


def test_changes_are_counted_by_class_the_gravest_first():
    left = unchanged(failed=True, counters=(quantity(),))
    changes = [unchanged(), left, worse(), unchanged(change="rounding")]
    assert kinds_text(changes) == "1 worse, 1 rounding, 1 unchanged, 1 same bits, other work"
    assert unchanged(failed=True).words == "same bits, limits broken"
    assert all(unchanged(change=name).words == name for name in CHANGES)
    assert {*CHANGES} == {*get_args(Change)}
