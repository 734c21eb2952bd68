"""Words, tables and text charts of reports agree with the results."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

import pytest
from regressions import quantity, regression, unchanged, uncompared, worse
from table_agreements import likeness

from ghostball.model import Scene
from ghostball.reference_adapters.registry import make_engine
from ghostball.reports import shared_tables
from ghostball.reports.error_changes import SHOTS, WIDTH, drawn, error_text, growth, shifted
from ghostball.reports.outcome import (
    CHANGES,
    failures,
    kinds_text,
    of_comparison,
    of_limits,
    overall,
)
from ghostball.reports.reason import reason_of
from ghostball.reports.shared_tables import (
    COMPARISON_HEADS,
    ENSEMBLE_HEADS,
    comparison_cells,
    ensemble_remarks,
    ensemble_rows,
)
from ghostball.reports.shots import rest_error_text
from ghostball.reports.words import agreement_cell, many, reused_text, run_time_text
from ghostball.validation.baselines.regression import Change
from ghostball.validation.diagnose.explanation import Explanation, explain
from ghostball.validation.results.records import Accuracy
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.statistics import EnsembleVerdict, QuantityVerdict

# Words and numbers are the same in every report.


def test_plurals_of_counts():
    assert [many(count, "case") for count in (0, 1, 2)] == ["0 cases", "1 case", "2 cases"]


def test_what_an_earlier_run_measured_is_said_with_its_dates(small_folder):
    results = Results.open(small_folder)
    assert reused_text(results) == ""
    first, *rest = results.cases
    first = replace(first, reused=True, measured="2026-01-02T03:04:05")
    shown = reused_text(Results(results.path, [first, *rest], results.environment))
    assert "1 of 3 cases reused from an earlier run (on" in shown
    assert "(on 2026-01-02" in shown
    assert run_time_text(first, dated=True).endswith(" (2026-01-02)")
    assert "(" not in run_time_text(first, dated=False)
    assert "(" not in run_time_text(replace(rest[0], measured=""), dated=True)


def test_an_engine_beside_real_tables_is_so_many_errors_off_or_lacks_it():
    rebound, rolling = likeness("ghostball", rebound=-3.0, rolling="it rolls none").families
    assert agreement_cell(rebound) == "3.0 (3.0)"
    (near,) = likeness("ghostball", rebound=-1.9).families
    assert agreement_cell(near) == "1.9 (1.9) ✓"
    assert agreement_cell(rolling) == "–"
    plain = rebound.model_copy(update={"grades": False, "unit": "degrees"})
    assert agreement_cell(plain).endswith("°")


# Tables shared by the terminal and the page: comparisons with the reference, and ensembles.


ROWS = {
    ("stop", "pymunk"): ("2 mm", "cue", "0 / 0", "0 / 0", "0.002", "–"),
    ("head-on", "paper-discrete"): ("30 mm", "cue", "7 / 1 ≠", "0 / 0", "0.03", "–"),
    ("stop", "newcomer:dt=1e-3"): ("(1 mm)", "cue", "0 / 0", "0 / 0", "0.001", "–"),
    ("break-7", "ghostball"): ("the reference", "–", "2 / –", "0 / –", "–", "–"),
}
"""All cells of some stored runs, by scene and engine."""


NEAR = QuantityVerdict("rest time [s]", 3.1, 0.5, 3.0, 0.1, 1.0, 0.4)
FAR = QuantityVerdict("rest time [s]", 9.0, 0.5, 3.0, 6.0, 1e-9, 0.4)


def test_each_run_has_a_cell_for_each_heading(results):
    cases = results.cases
    for case in cases:
        cells = comparison_cells(case)
        if case.outcome != "ran":
            assert cells is None
            continue
        rest, _, *counts, _, _ = cells
        assert len(cells) == len(COMPARISON_HEADS)
        assert rest == ("the reference" if case.is_own_measure else rest_error_text(case))
        for kind, text in zip(("ball-ball", "ball-cushion"), counts, strict=True):
            found, true = case.collision_counts.get(kind, 0), case.truth_counts.get(kind, 0)
            assert text.startswith(f"{found} / ")
            if not case.is_own_measure:
                assert text == f"{found} / {true}" + " ≠" * (found != true)
    by_run = {(case.scene, case.label): case for case in cases}
    assert {key: comparison_cells(by_run[key]) for key in ROWS} == ROWS
    case = by_run["stop", "pymunk"]
    timed = replace(case, metrics=case.metrics | {"energy_difference_time": 1.25})
    assert comparison_cells(timed) == (*ROWS["stop", "pymunk"][:-1], "1.25 s")


def of(label, *found, ended=15, broken=0, reasons=()):
    spread = None if ended < 2 else 0.012
    return EnsembleVerdict("break", label, 15, ended, 15, broken, reasons, True, spread, found)


@pytest.fixture
def shown(monkeypatch):
    found = [
        of("ghostball"),
        of("near", NEAR, broken=2),
        of("far", FAR),
        of("gone", ended=1, reasons=("it hung",)),
    ]
    monkeypatch.setattr(shared_tables, "ensemble_verdicts", lambda _: found)


@pytest.mark.usefixtures("shown")
def test_a_row_has_a_cell_under_each_heading_and_a_scene_is_named_once():
    rows = list(ensemble_rows(None))
    assert {len(row) for row in rows} == {len(ENSEMBLE_HEADS)}
    assert [row[0] for row in rows] == ["break", "", "", ""]
    assert [row[-1] for row in rows] == [
        "the reference of the other engines",
        "not distinguishable with 15 runs; smallest visible difference: rest time 0.4 s",
        "different from the reference with p < 0.001 in rest time, by +6 s",
        "nothing to compare: too few runs finished",
    ]
    assert [row[2:4] for row in rows[::3]] == [["15 of 15", "12 mm"], ["1 of 15", "–"]]


@pytest.mark.usefixtures("shown")
def test_what_is_wrong_is_said():
    assert list(ensemble_remarks(None)) == [
        "break on near: 2 finished runs failed a common limit",
        "break on gone: 14 runs did not finish: it hung",
    ]


# The text chart of rest errors before and now.


def moved(scene: str, before: float | None, now: float | None):
    return worse(scene, base_error=before, head_error=now)


def test_what_got_worse_by_most_comes_first_and_what_did_not_move_is_left_out() -> None:
    better, same, lost = moved("better", 1e-3, 1e-4), moved("same", 1e-3, 1e-3), moved("x", 1, None)
    found = shifted(regression(better, same, worse(), lost, unchanged()))
    assert [one.scene for one in found] == ["break-7", "better"]
    assert [error_text(one) for one in (better, same, lost)] == ["1 mm -> 100 µm", "1 mm", ""]
    exact = worse(base_is_exact=True)
    assert error_text(exact) == "rounding -> 3 mm"
    assert growth(worse()) > 0.0 > growth(better)
    assert growth(lost) == growth(same) == 0.0


def test_a_place_on_the_line_is_a_power_of_ten() -> None:
    shown = [moved("a", 1e-3, 1e-1), moved("long-name", 1e-2, 1e-2), moved("b", 1e-1, 1e-3)]
    first, second, third, axis, *_ = drawn(shown).splitlines()
    start = len("long-name") + 2
    assert first[start] == "○"
    assert first[start + WIDTH - 1] == "●"
    assert third[start] == "●"
    assert second[start:].index("◉") == round((WIDTH - 1) / 2)
    assert axis.split() == ["1", "mm", "100", "mm"]
    assert len(axis) == start + WIDTH


def test_no_changes_and_too_many_changes_are_drawn() -> None:
    assert drawn([]) == ""
    many = [moved(f"s{k}", 0.0, 10.0**-k) for k in range(SHOTS + 3)]
    assert drawn(many).splitlines()[-1].endswith("; 3 more changed less")
    assert len(drawn([moved("none", 0.0, 0.0)]).splitlines()) == 4


# A run has one verdict, with the words of both verdicts and the worse sign.


PASSED = regression(unchanged(), outcome="passed")
FAILED = regression(worse(), unchanged())


def with_cases(results, cases, **environment):
    return Results(results.path, cases, results.environment | environment)


@pytest.fixture
def judged(small_folder):
    """One scene on three engines; the last engine fails a limit."""
    found = Results.open(small_folder)
    *good, last = found.cases
    broken = replace(last, checks=tuple(replace(one, passed=False) for one in last.checks))
    return with_cases(found, [*good, broken])


def test_a_run_fails_on_either_answer(judged):
    bad = [one.case for one in failures(judged.cases)]
    good = with_cases(judged, [case for case in judged.cases if case not in bad])
    assert (of_limits(judged).sign, of_limits(good).sign) == ("✗", "✓")
    found = {
        (kept, moved): overall(judged if not kept else good, FAILED if moved else PASSED)
        for kept in (True, False)
        for moved in (True, False)
    }
    assert {key: one.sign for key, one in found.items()} == {
        (True, False): "✓",
        (True, True): "✗",
        (False, False): "✗",
        (False, True): "✗",
    }
    assert found[True, True].short == "All limits passed, baseline check failed"
    assert found[False, True].word == "Failed, baseline check failed"


def test_wrong_collisions_that_nothing_judges_are_no_green_pass(judged):
    # The banner of a run with wrong collisions must not be green or have a tick.
    bad = [one.case for one in failures(judged.cases)]
    good = [case for case in judged.cases if case not in bad]
    other = Accuracy("another shot", at=1.0, agree=1, of=2)
    wrong = replace(good[0], scene="other", accuracy=other)
    free = tuple(replace(check, metric="energy_rise", unit="1") for check in wrong.checks)
    found = overall(with_cases(judged, [replace(wrong, checks=free), *good]))
    assert (found.sign, found.kind, found.short) == ("≈", "holds", "All limits passed")
    assert found.word == "All limits passed; wrong collisions in 1 case, not judged"
    excused = overall(with_cases(judged, [replace(wrong, checks=()), *good]))
    assert excused.word == found.word


def test_what_did_not_end_or_was_not_judged_is_no_pass(judged):
    bad = [one.case for one in failures(judged.cases)]
    good = [case for case in judged.cases if case not in bad]
    assert of_limits(with_cases(judged, good, state="interrupted")).word == "Incomplete"
    assert of_limits(with_cases(judged, [])).word == "Nothing judged"
    assert of_comparison(regression(uncompared(), outcome="no-baseline")).sign == "?"


def test_changes_are_counted_by_class_the_gravest_first():
    left = unchanged(failed=True, counters=(quantity(),))
    changes = [unchanged(), left, worse(), unchanged(change="rounding")]
    assert (
        kinds_text(changes)
        == "1 worse, 1 rounding, 1 unchanged, 1 same result, different work counters"
    )
    assert unchanged(failed=True).words == "same result, limits failed"
    assert all(unchanged(change=name).words == name for name in CHANGES)
    assert {*CHANGES} == {*get_args(Change)}


# The first sentence of an explanation claims only what was compared.


STOP: Scene = find_scene("head-on")


@pytest.fixture(scope="module")
def explained() -> Explanation:
    pytest.importorskip("pymunk")
    return explain(STOP, make_engine("pymunk"), label="pymunk")


def test_a_shot_that_was_compared_to_its_end_is_right_but_for_its_step(explained: Explanation):
    assert reason_of(explained).startswith("pymunk is right except for its time step: ")


@pytest.mark.parametrize("outcome", ["agrees", "step"])
def test_of_a_shot_that_was_compared_in_part_the_rest_is_not_called_right(
    explained: Explanation, outcome: str
):
    """A break that ends metres off isn't called right, although its first part was right."""
    assert explained.attribution is not None
    part = replace(explained.attribution, outcome=outcome, instant=0.1, until="collisions differ")
    text = reason_of(replace(explained, attribution=part))
    assert "p to t = 100 ms" in text
    assert "can't be compared: collisions differ" in text
    assert "is right" not in text


def test_a_run_that_is_wrong_on_the_way_is_not_called_right():
    """An engine that is 100 mm off during the shot isn't called right: only its end was right."""
    ours = explain(find_scene("half-ball-cut"), make_engine("ghostball"), label="mine")
    assert reason_of(ours).startswith("mine is right: ")
    assert ours.result.events is not None
    events = ours.result.events.copy()
    events["t"][:1] -= 0.01
    text = reason_of(replace(ours, result=replace(ours.result, events=events)))
    assert text.startswith("The final positions of mine are right (")
    assert 'in its events, "cue" hits "object" 0.01 s too early' in text
