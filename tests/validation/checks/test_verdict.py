"""Verdicts: a case without a judgement doesn't pass, and a chaotic distance is no error."""

from __future__ import annotations

from dataclasses import replace

import pytest
from stored_records import record

from ghostball.validation.checks.metrics import METRICS
from ghostball.validation.checks.verdict import (
    RestError,
    Verdict,
    few_ends_judged,
    is_nothing_judged,
    is_outcome_judged,
    not_judged,
    rest_error_standing,
    rest_verdict_of,
    unfinished_text,
    unjudged_engines,
    verdict_of,
)
from ghostball.validation.results.records import (
    ACCURACY_KINDS,
    CLOSED_FORM,
    OUR_ENGINE,
    CaseRecord,
    Check,
)


def check(metric: str, passed: bool | None = True, kind: str = "at_most") -> Check:
    return Check(metric, 1.0, kind, 1.0, METRICS[metric].unit, passed, "by hand")  # type: ignore[arg-type]


def case(*checks: Check, truth: str = CLOSED_FORM, engine: str = "pymunk") -> CaseRecord:
    fields = {"status": "rest", "truth": truth, "metrics": {"rest_error_max": 272.0}}
    # In a scene without balls, no limit is wider than the smallest ball.
    return record(engine, "shot", definition={}, checks=checks, **fields)


@pytest.mark.parametrize(
    ("metric", "kind", "verdict"),
    [
        *((name, "at_most", Verdict.PASS) for name in ("rest_error_max", "rest_error_ulps")),
        *((name, "at_most", Verdict.PASS) for name in ("rest_time_error", "accuracy")),
        ("ball_cushion_count_error", "at_most", Verdict.PASS),
        *((name, "equals", Verdict.PASS) for name in ("collision_count", "matching_events")),
        *((name, "at_most", Verdict.LIMITS_HOLD) for name in ("energy_drift", "energy_rise")),
        *((name, "at_most", Verdict.LIMITS_HOLD) for name in ("overlap_max", "wall_time")),
        ("energy_difference_max", "at_most", Verdict.LIMITS_HOLD),
        ("first_divergence_time", "at_least", Verdict.LIMITS_HOLD),
        *((n, "at_least", Verdict.LIMITS_HOLD) for n in ("collision_count", "matching_events")),
    ],
)
def test_a_pass_needs_a_limit_on_the_outcome(metric: str, kind: str, verdict: Verdict) -> None:
    found = check(metric, kind=kind)
    assert verdict_of(case(found)) is verdict
    assert verdict_of(case(found, check("overlap_max", passed=False))) is Verdict.FAIL
    # A check that compares our engine with itself judges no result.
    assert verdict_of(case(found, check("rest_error_max", passed=None))) is verdict


def test_our_engine_is_the_reference_where_it_is_the_truth_and_can_still_fail() -> None:
    ours = case(check("energy_rise"), truth=OUR_ENGINE, engine="ghostball")
    assert ours.is_own_measure
    assert verdict_of(ours) is Verdict.REFERENCE
    assert verdict_of(replace(ours, checks=())) is Verdict.REFERENCE
    assert verdict_of(replace(ours, checks=(check("energy_rise", False),))) is Verdict.FAIL
    assert verdict_of(replace(ours, truth=CLOSED_FORM)) is Verdict.LIMITS_HOLD
    assert rest_error_standing(ours) is RestError.OWN


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({}, Verdict.SHOWN),
        ({"outcome": "failed"}, Verdict.CRASHED),
        ({"outcome": "unavailable"}, Verdict.UNAVAILABLE),
        ({"outcome": "not-representable"}, Verdict.NOT_REPRESENTABLE),
    ],
)
def test_what_did_not_run_or_has_no_limit(changes: dict[str, str], verdict: Verdict) -> None:
    assert verdict_of(replace(case(), **changes)) is verdict  # type: ignore[arg-type]
    assert verdict_of(None) is Verdict.MISSING


def test_a_run_that_stops_early_did_not_finish_whatever_it_keeps() -> None:
    early = replace(case(), status="step-limit", reason="too many")
    assert unfinished_text(early) == "stopped early: step-limit: too many"
    for checks in ((), (check("rest_error_max"),), (check("rest_error_max", False),)):
        assert verdict_of(replace(early, checks=checks)) is Verdict.CRASHED
    for ended in ("rest", "t-max"):
        assert unfinished_text(replace(early, status=ended)) == ""


def test_nothing_is_judged_where_no_check_has_a_verdict_and_nothing_failed() -> None:
    refused = replace(case(), outcome="not-representable")
    assert is_nothing_judged([case(), refused, case(check("rest_error_max", None))])
    for judged in (
        case(check("rest_error_max")),
        case(check("rest_error_max", False)),
        replace(case(), outcome="failed"),
        replace(case(), status="step-limit"),
    ):
        assert not is_nothing_judged([refused, judged])


def test_an_engine_that_says_too_little_is_not_judged_by_energy_alone() -> None:
    # Fails if an engine passes that moves no ball, because no limit applies to its result.
    kept = check("energy_rise")
    silent, ours = replace(case(kept), unstated=True), case(check("rest_error_max"), engine="mine")
    assert unjudged_engines([silent, ours]) == ("pymunk",)
    assert not_judged([silent, ours]).startswith("no case of pymunk had its final positions judged")
    # More about the engine's exactness would change nothing where only Ghostball is the reference.
    unknown = replace(silent, truth="engine")
    assert "no scene has an independent reference" in not_judged([unknown])
    assert "declare a time step" in not_judged([unknown, silent])
    # One shot with a limit on rest positions is enough, whether it passes or fails.
    for passed in (True, False):
        limited = replace(case(kept, check("rest_error_max", passed)), unstated=True)
        assert unjudged_engines([silent, limited]) == ()
    # An engine isn't listed if its shots are chaotic, excused, or run without these metrics.
    stepping = replace(silent, unstated=False)
    assert unjudged_engines([replace(stepping, horizon=0.5)]) == ()
    assert unjudged_engines([stepping]) == ("pymunk",)  # its step is so long that no limit applies
    assert unjudged_engines([replace(silent, excused="a default")]) == ()
    assert unjudged_engines([replace(silent, left_out=("accuracy",))]) == ()
    assert unjudged_engines([replace(silent, outcome="not-representable"), ours]) == ()


def test_how_many_ends_were_judged_is_said_unless_all_were() -> None:
    judged, free = case(check("rest_error_max")), case(check("energy_rise"))
    said = "the final positions were judged in 1 of 3 scenes"
    # A failed shot was judged; an unsupported shot wasn't run.
    failed = case(check("rest_error_max", False))
    unable = replace(free, outcome="not-representable")
    for cases, text in (
        ([judged, judged], ""),
        ([judged, free, free], said),
        ([failed, free, free, unable], said),
        ([judged, replace(free, excused="a default")], ""),
        ([judged, replace(free, left_out=("rest_error_max",))], ""),
        ([judged, replace(free, varied_from="stop")], ""),
    ):
        assert few_ends_judged(cases) == text


def test_a_limit_wider_than_a_ball_is_none() -> None:
    balls = {"balls": [{"radius": 0.03}, {"radius": 0.02}]}
    for limit, verdict in ((0.02, Verdict.PASS), (0.021, Verdict.LIMITS_HOLD)):
        wide = replace(check("rest_error_max"), limit=limit)
        found = replace(case(wide, check("ball_ball_count_error", kind="equals")), definition=balls)
        assert verdict_of(found) is verdict
        failed = replace(found, checks=(replace(wide, passed=False),))
        assert verdict_of(failed) is Verdict.FAIL
    assert not_judged([found])
    # A tight limit judges the case, before or after the wide limit.
    tight = replace(check("rest_error_rms"), limit=0.02)
    for checks in ((wide, tight), (tight, wide)):
        both = replace(found, checks=checks)
        assert verdict_of(both) is Verdict.PASS
        assert not not_judged([both])
    unjudged = replace(tight, passed=None)
    assert not is_outcome_judged(replace(found, checks=(*found.checks, unjudged)))
    for name in ("centimetres", "another shot", "broken"):
        end = replace(check("accuracy"), limit=ACCURACY_KINDS.index(name))
        assert not is_outcome_judged(case(end)), name


def test_a_rest_error_is_worth_what_judges_it() -> None:
    counted = case(check("collision_count", kind="equals"))
    assert rest_verdict_of(counted) is Verdict.SHOWN
    for passed, verdict in ((True, Verdict.PASS), (False, Verdict.FAIL)):
        assert rest_verdict_of(case(check("rest_error_max", passed))) is verdict
    # After the horizon, a distance without a limit is no error.
    chaotic = replace(case(check("energy_rise"), truth=OUR_ENGINE), horizon=0.5, metrics={})
    before = replace(case(check("energy_rise"), truth=OUR_ENGINE), horizon=None)
    unable = replace(case(engine="ghostball"), outcome="not-representable", truth=None)
    for found, standing in (
        (counted, RestError.UNJUDGED),
        (case(check("rest_error_max")), RestError.JUDGED),
        (case(check("rest_error_max", False)), RestError.JUDGED),
        (None, RestError.NONE),
        (replace(case(), metrics={"rest_error_max": None}), RestError.NONE),
        (chaotic, RestError.CHAOTIC),
        (replace(chaotic, horizon=None), RestError.NONE),
        (replace(chaotic, engine="ghostball"), RestError.NONE),
        (before, RestError.UNJUDGED),
        (replace(before, horizon=0.5, checks=(check("rest_error_max"),)), RestError.JUDGED),
        (replace(unable, metrics={}), RestError.NONE),  # there is no reference result
    ):
        assert rest_error_standing(found) is standing
    assert not unable.is_own_measure


def test_every_verdict_reads_without_colour() -> None:
    signs = {verdict.symbol for verdict in Verdict}
    assert len(signs) == len(Verdict) - 1  # what can't run here shares one sign
    assert len({verdict.words for verdict in Verdict}) == len(Verdict)
