"""Accuracy classes have the right words, and bars include every scene."""

from dataclasses import replace

import pytest
from stored_records import record

from ghostball.reports.accuracy import (
    CLASSES,
    accuracy_text,
    allowed_text,
    cell_text,
    length_text,
    meaning_text,
    tally,
    time_text,
    wrong_text,
)
from ghostball.validation.results.records import OUR_ENGINE, Accuracy, Check


@pytest.fixture(scope="module")
def case(results):
    return results.case("stop", "pymunk")


@pytest.mark.parametrize(
    ("found", "text"),
    [
        (Accuracy("exact", error=3e-16), "exact"),
        (Accuracy("exact", error=3e-9, at=5.45), "exact at 5.45 s"),
        (Accuracy("nanometres", error=1.6e-10), "160 pm"),
        (Accuracy("millimetres", error=3.67e-3), "3.67 mm"),
        (Accuracy("centimetres", error=0.785), "785 mm"),
        (Accuracy("another shot", at=1.21195, agree=4, of=7), "wrong at 1.21 s (4 of 7 right)"),
        (
            Accuracy("another shot", at=1.21195, agree=7, of=7),
            "wrong at 1.21 s (7 of 7 right, then extra)",
        ),
        (Accuracy("another shot", agree=0, of=1), "wrong (0 of 1 right)"),
        (Accuracy("broken", cause="energy", amount=0.088), "unphysical: energy +8.8 %"),
        (
            Accuracy("broken", cause="overlap", amount=0.0541),
            "unphysical: balls overlap by 54.1 mm",
        ),
        (Accuracy("broken", cause="not finite"), "unphysical: NaN or infinity"),
        (Accuracy("broken", cause="jump", amount=0.104), "unphysical: velocities jump"),
        (Accuracy("broken", cause="stopped"), "unphysical: stopped early"),
    ],
)
def test_a_cell_says_what_a_reader_wants(case, found, text):
    shown = replace(case, accuracy=found)
    assert accuracy_text(shown) == text
    assert cell_text(shown) == f"{text} ✓"
    assert meaning_text(shown).startswith(("exact", "wrong collisions", "unphysical", found.kind))


def test_what_nothing_proves_is_said_to_be_a_comparison(case):
    shown = replace(case, truth=OUR_ENGINE)
    assert "Ghostball's own result, which is not certified" in meaning_text(shown)


def test_the_mark_is_no_part_of_the_class(case):
    # The class doesn't depend on limits.
    failed = replace(case, checks=tuple(replace(check, passed=False) for check in case.checks))
    assert cell_text(failed) == "2 mm ✗"
    assert cell_text(replace(case, checks=())) == "2 mm"
    assert accuracy_text(failed) == accuracy_text(case)


def test_a_tally_counts_each_case_once(results):
    for label in results.labels:
        found = tally(results, label)
        classless = found.unable + found.crashed + found.compared_with
        assert found.played + classless == len(results.scene_names)
        assert list(found.counts) == [kind for kind in CLASSES if kind in found.counts]


HOLDS = Check("energy_gain_max", 0.0, "at_most", 1e-9, "1", passed=True, reason="x")
"""A limit that doesn't judge final positions."""


def cases(*kinds, checks=(HOLDS,)):
    ran = {"status": "rest", "checks": checks}
    return [record(accuracy=Accuracy(kind), **ran) for kind in kinds] + [record()]


def test_wrong_and_unphysical_cases_are_counted():
    assert wrong_text(cases("exact", "exact", "centimetres")) == ""
    one, two = cases("another shot"), cases("another shot", "broken", "another shot", "exact")
    assert wrong_text(one) == "wrong collisions in 1 case, not judged"
    said = "wrong collisions in 2 cases, unphysical motion in 1 case, not judged"
    assert wrong_text(two) == said


def test_a_wrong_case_that_fails_is_judged():
    fails = replace(HOLDS, value=1.0, passed=False)
    failing = cases("another shot", checks=(fails,))
    assert wrong_text([*failing, *cases("another shot")]) == "wrong collisions in 2 cases"


def test_a_large_error_that_passed_says_which_limit_allows_it(case):
    # A tick beside an error of millimetres needs an explanation.
    checks = tuple(
        Check("rest_error_max", 3e-3, "at_most", limit, "m", passed=True, reason="One step late.")
        for limit in (0.0172, 9.66e-3)
    )
    large = replace(case, accuracy=Accuracy("millimetres", error=3e-3), checks=checks)
    assert allowed_text(large) == "within the limit of 9.66 mm"
    assert meaning_text(large).endswith("; within the limit of 9.66 mm: One step late")
    small = replace(large, accuracy=Accuracy("micrometres", error=3e-6))
    failed = replace(large, checks=tuple(replace(check, passed=False) for check in checks))
    assert [allowed_text(one) for one in (small, failed, None)] == ["", "", ""]


def test_femtometres_are_called_rounding(case):
    exact = replace(case, accuracy=Accuracy("exact", error=3e-16))
    assert length_text(exact, 3e-16) == time_text(exact, 4e-15) == "rounding"
    assert "fm" not in meaning_text(exact)
    # A result that is exact only up to some time may end anywhere.
    until = replace(case, accuracy=Accuracy("exact", error=3e-16, at=1.0))
    assert length_text(until, 0.2) == "200 mm"
    assert time_text(exact, 1e-3) == "1 ms"
    assert length_text(exact, None) == "–"


@pytest.mark.parametrize(
    ("kinds", "text"),
    [
        (["exact"], "rounding"),
        (["exact", "exact", "millimetres"], "rounding"),
        (["exact", "millimetres"], "1 mm"),
        (["exact", "millimetres", "millimetres"], "2 mm"),
        ([], "–"),
    ],
)
def test_a_median_error_of_exact_cases_is_called_rounding(results, kinds, text):
    errors = {"exact": 0.0, "millimetres": 2e-3}
    found = [record(accuracy=Accuracy(kind, error=errors[kind]), status="rest") for kind in kinds]
    label = record().label
    shown = replace(results, cases=[replace(one, label=label) for one in found])
    assert tally(shown, label).typical_text == text
