"""Fails where a case that nothing judged is called passed, or a chaotic number an error."""

from __future__ import annotations

from dataclasses import replace

import pytest

from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.checks.verdict import (
    RestError,
    Verdict,
    few_ends_judged,
    is_nothing_judged,
    is_outcome_judged,
    is_own_measure,
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
    return CaseRecord(
        scene="shot",
        title="",
        tags=(),
        definition={},
        label=engine,
        engine=engine,
        outcome="ran",
        status="rest",
        truth=truth,
        metrics={"rest_error_max": 272.0},
        checks=checks,
    )


@pytest.mark.parametrize(
    "judging",
    [
        check("rest_error_max"),
        check("rest_error_ulps"),
        check("rest_time_error"),
        check("collision_count", kind="equals"),
        check("ball_cushion_count_error"),
        check("matching_events", kind="equals"),
    ],
    ids=lambda check: check.metric,
)
def test_a_pass_needs_a_judged_outcome(judging: Check) -> None:
    assert verdict_of(case(check("energy_drift"), judging)) is Verdict.PASS


@pytest.mark.parametrize(
    "weak",
    [
        check("energy_drift"),
        check("energy_rise"),
        check("energy_difference_max"),
        check("overlap_max"),
        check("wall_time"),
        check("first_divergence_time", kind="at_least"),
        check("matching_events", kind="at_least"),
        check("collision_count", kind="at_least"),
    ],
    ids=lambda check: check.metric,
)
def test_weak_limits_alone_are_no_pass(weak: Check) -> None:
    assert verdict_of(case(weak)) is Verdict.LIMITS_HOLD
    assert verdict_of(case(weak, check("overlap_max", passed=False))) is Verdict.FAIL
    # A check that compares our engine with itself judges nothing.
    assert verdict_of(case(weak, check("rest_error_max", passed=None))) is Verdict.LIMITS_HOLD


def test_our_engine_is_the_reference_where_it_is_the_truth_and_can_still_fail() -> None:
    ours = case(check("energy_rise"), truth=OUR_ENGINE, engine="ghostball")
    assert is_own_measure(ours)
    assert verdict_of(ours) is Verdict.REFERENCE
    assert verdict_of(replace(ours, checks=())) is Verdict.REFERENCE
    assert verdict_of(replace(ours, checks=(check("energy_rise", False),))) is Verdict.FAIL
    assert verdict_of(replace(ours, truth=CLOSED_FORM)) is Verdict.LIMITS_HOLD
    assert rest_error_standing(ours) is RestError.OWN


def test_what_did_not_run_or_has_no_limit() -> None:
    assert verdict_of(None) is Verdict.MISSING
    assert verdict_of(case()) is Verdict.SHOWN
    for outcome, verdict in (
        ("failed", Verdict.CRASHED),
        ("unavailable", Verdict.UNAVAILABLE),
        ("not-representable", Verdict.NOT_REPRESENTABLE),
    ):
        assert verdict_of(replace(case(), outcome=outcome)) is verdict


def test_a_run_that_stops_early_did_not_finish_whatever_it_keeps() -> None:
    early = replace(case(), status="step-limit", reason="too many")
    assert verdict_of(early) is Verdict.CRASHED
    assert unfinished_text(early) == "it stopped early: step-limit: too many"
    kept = replace(early, checks=(check("rest_error_max"),))
    assert verdict_of(kept) is Verdict.CRASHED
    broken = replace(early, checks=(check("rest_error_max", False),))
    assert verdict_of(broken) is Verdict.CRASHED
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
    # Breaks where an engine that moves nothing passes, for nothing that it does is limited.
    kept = check("energy_rise")
    silent, ours = replace(case(kept), unstated=True), case(check("rest_error_max"), engine="mine")
    assert unjudged_engines([silent, ours]) == ("pymunk",)
    assert not_judged([silent, ours]).startswith(
        "no shot of pymunk was judged by its final positions"
    )
    # One shot with a limit on how it ends is enough, whether it holds or not.
    for passed in (True, False):
        limited = replace(case(kept, check("rest_error_max", passed)), unstated=True)
        assert unjudged_engines([silent, limited]) == ()
    # Who states a step isn't judged in chaos, and who is excused or asked for energy isn't either.
    stepping = replace(silent, unstated=False)
    assert unjudged_engines([replace(stepping, horizon=0.5)]) == ()
    assert unjudged_engines([stepping]) == ("pymunk",)  # with a step that allows anything
    assert unjudged_engines([replace(silent, excused="a default")]) == ()
    assert unjudged_engines([replace(silent, left_out=("accuracy",))]) == ()
    assert unjudged_engines([replace(silent, outcome="not-representable"), ours]) == ()


def test_how_many_ends_were_judged_is_said_unless_all_were() -> None:
    judged, free = case(check("rest_error_max")), case(check("energy_rise"))
    assert few_ends_judged([judged, judged]) == ""
    said = "the end of the shot was judged in 1 of 3 scenes"
    assert few_ends_judged([judged, free, free]) == said
    # A shot that fails was judged; one that the engine can't play wasn't run.
    failed = case(check("rest_error_max", False))
    unable = replace(free, outcome="not-representable")
    assert few_ends_judged([failed, free, free, unable]) == said
    assert few_ends_judged([judged, replace(free, excused="a default")]) == ""
    assert few_ends_judged([judged, replace(free, left_out=("rest_error_max",))]) == ""
    assert few_ends_judged([judged, replace(free, varied_from="stop")]) == ""


def test_a_limit_wider_than_a_ball_is_none() -> None:
    balls = {"balls": [{"radius": 0.03}, {"radius": 0.02}]}
    for limit, verdict in ((0.02, Verdict.PASS), (0.021, Verdict.LIMITS_HOLD)):
        wide = replace(check("rest_error_max"), limit=limit)
        found = replace(case(wide, check("ball_ball_count_error", kind="equals")), definition=balls)
        assert verdict_of(found) is verdict
        failed = replace(found, checks=(replace(wide, passed=False),))
        assert verdict_of(failed) is Verdict.FAIL
    assert not_judged([found])
    # A tight limit beside the wide one judges, whichever of the two is stated first.
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


def test_a_rest_error_is_judged_by_limits_on_it_alone() -> None:
    counted = case(check("collision_count", kind="equals"))
    assert rest_verdict_of(counted) is Verdict.SHOWN
    assert rest_error_standing(counted) is RestError.UNJUDGED
    for passed, verdict in ((True, Verdict.PASS), (False, Verdict.FAIL)):
        judged = case(check("rest_error_max", passed))
        assert rest_verdict_of(judged) is verdict
        assert rest_error_standing(judged) is RestError.JUDGED
    assert rest_error_standing(None) is RestError.NONE
    assert rest_error_standing(replace(case(), metrics={"rest_error_max": None})) is RestError.NONE


def test_past_the_horizon_an_unjudged_distance_is_no_error() -> None:
    chaotic = replace(case(check("energy_rise"), truth=OUR_ENGINE), horizon=0.5, metrics={})
    assert rest_error_standing(chaotic) is RestError.CHAOTIC
    assert rest_error_standing(replace(chaotic, horizon=None)) is RestError.NONE
    assert rest_error_standing(replace(chaotic, engine="ghostball")) is RestError.NONE
    before = replace(case(check("energy_rise"), truth=OUR_ENGINE), horizon=None)
    assert rest_error_standing(before) is RestError.UNJUDGED
    judged = replace(chaotic, checks=(check("rest_error_max"),), metrics=before.metrics)
    assert rest_error_standing(judged) is RestError.JUDGED


def test_every_verdict_reads_without_colour() -> None:
    signs = {verdict.symbol for verdict in Verdict}
    assert len(signs) == len(Verdict) - 1  # what can't run here shares one sign
    assert len({verdict.words for verdict in Verdict}) == len(Verdict)


def test_our_engine_is_no_reference_in_a_scene_that_it_cannot_represent() -> None:
    refused = replace(case(engine="ghostball"), outcome="not-representable", truth=None)
    assert not is_own_measure(refused)
    assert rest_error_standing(replace(refused, metrics={})) is RestError.NONE
