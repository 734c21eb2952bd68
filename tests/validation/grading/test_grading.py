"""Grades of exact runs, of runs with one fault, and of runs that can be graded only in part."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from grades import clean, grade, run_and_proof, without_event
from shots import ball, scene_of

from ghostball.engine import simulate
from ghostball.model import EventKind, GhostballError, Result, Scene
from ghostball.reference_adapters import make_engine
from ghostball.reference_adapters.certified import CertifiedSettings, Enclosure, certify
from ghostball.validation.grading.grading import _distance
from ghostball.validation.grading.horizon import extent_of
from ghostball.validation.grading.tolerances import UNIT_ROUNDOFF
from ghostball.validation.scenes.library import find_scene


def test_an_exact_run_of_a_whole_shot() -> None:
    result, certificate, growth = run_and_proof("half-ball-cut")
    made = grade(result, certificate, growth)
    assert (made.extent, made.why, made.until, made.events) == ("whole", "", math.inf, 3)
    assert clean(made)
    assert made.compared_at == result.rest_time
    # The time error of the first event and the position error of the cue ball, computed by hand.
    t = certificate.events[0].t
    assert result.events is not None
    error = abs(Fraction(float(result.events["t"][0])) - t.mid) - t.rad
    assert made.time_errors[0] == pytest.approx(float(max(error, 0)) / math.ulp(float(t)))
    x, y = certificate.positions[0]
    between = [
        float(Fraction(float(a)) - e.mid)
        for a, e in zip(result.rest_positions[0], (x, y), strict=False)
    ]
    assert made.position_errors[0] == pytest.approx(math.hypot(*between), abs=1e-18)
    assert made.quality_factor == pytest.approx(made.position_errors.max() / UNIT_ROUNDOFF)
    assert made.time_error_max == made.time_errors.max()


def test_an_event_that_is_not_found() -> None:
    result, certificate, growth = run_and_proof("break-7")
    made = grade(without_event(result, 5), certificate, growth)
    assert made.missing[0] == 5  # and later events of its balls
    assert made.first is not None
    assert made.first.t == float(certificate.events[5].t)


def test_the_event_at_which_a_proof_ends_is_graded() -> None:
    scene = find_scene("break-7")
    certificate = certify(scene, CertifiedSettings(max_events=3), motion=True)
    result = simulate(scene, record="trajectory")
    assert float(certificate.t_end) == float(certificate.events[2].t)
    assert clean(grade(result, certificate))
    assert grade(without_event(result, 2), certificate).missing == (2,)


def test_an_event_that_is_not_so() -> None:
    result, certificate, growth = run_and_proof("break-7")
    assert result.events is not None
    extra = np.insert(result.events, 3, result.events[2])
    made = grade(replace(result, events=extra), certificate, growth)
    assert made.invented[0] == 3
    assert made.first is not None
    assert made.first.other is made.first.first


def test_a_time_and_a_place_that_are_wrong() -> None:
    result, certificate, growth = run_and_proof("half-ball-cut")
    assert result.events is not None
    events = result.events.copy()
    t = events["t"][0]
    events["t"][0] = t + 1000 * math.ulp(t)
    state = result.final_state
    moved = state.positions.copy()
    moved[0, 1, 0] += 1e-9
    made = grade(
        replace(result, events=events, final_state=state._replace(positions=moved)),
        certificate,
        growth,
    )
    assert made.time_error_max == pytest.approx(1000, abs=10)
    assert made.position_errors[1] == pytest.approx(1e-9, rel=1e-5)
    assert made.quality_factor == pytest.approx(1e-9 / UNIT_ROUNDOFF, rel=1e-5)


def test_the_quality_factor_is_in_units_of_each_balls_own_rounding() -> None:
    result, certificate, growth = run_and_proof("half-ball-cut", amplification=(1.0, 1e6))
    errors = grade(result, certificate, growth).position_errors
    made = grade(result, certificate, growth)
    assert made.quality_factor == pytest.approx(
        max(errors[0], errors[1] / 1e6) / UNIT_ROUNDOFF, rel=1e-12
    )


def test_a_ball_that_nothing_can_have_moved_may_be_off_by_the_rounding_of_its_coordinates() -> None:
    result, certificate, growth = run_and_proof("half-ball-cut", amplification=(0.0, 0.0))
    made = grade(result, certificate, growth)
    unit = UNIT_ROUNDOFF * extent_of(result.scene)
    assert made.quality_factor == pytest.approx(max(made.position_errors) / unit, rel=1e-12)


def test_a_tangent_map_that_has_ended_gives_no_quality() -> None:
    made = grade(*run_and_proof("half-ball-cut", amplification=math.inf))
    assert made.quality_factor is None
    assert "the effect of rounding on the compared positions isn't known" in made.no_quality


def test_a_position_that_is_not_finite_is_infinitely_wrong() -> None:
    result, certificate, growth = run_and_proof("half-ball-cut")
    lost = result.final_state._replace(positions=np.full((1, 2, 3), math.nan))
    made = grade(replace(result, final_state=lost), certificate, growth)
    assert made.quality_factor == math.inf


def test_a_slip_that_is_but_rounding_is_no_event() -> None:
    # In the certified engine, a stunned ball slips at 1e-17 m/s and then rolls; in ours it doesn't.
    result, certificate, growth = run_and_proof("stun-shot")
    made = grade(result, certificate, growth)
    assert result.events is not None
    assert len(certificate.events) == len(result.events) + 2
    assert made.negligible == 2
    assert clean(made)
    assert made.events == 3


def test_a_roll_that_rounding_of_the_line_of_centres_leaves_is_no_event() -> None:
    # Head-on up to the last bits: of 6.2 m/s, doubles leave 1e-14 m/s, and the exact impact 2e-15
    # m/s.
    scene = scene_of(
        ball((0.48132284911279266, 0.09179769516754445), (5.756720402189766, 2.421848082553362)),
        ball((1.6239230444679669, 0.5724887655890686)),
        rolling_friction=0.005,
        t_max=0.5,
    )
    result, certificate = simulate(scene, record="trajectory"), certify(scene, motion=True)
    assert [event.kind for event in certificate.events][1:] == [EventKind.ROLL_TO_REST]
    made = grade(result, certificate)
    assert clean(made)
    assert made.negligible == 2


def slow_slide(slip: float) -> Scene:
    """Return a ball that rolls with a small slip [m/s]."""
    radius = 0.028575
    spin = (0.0, (1.5 - slip) / radius, 0.0)
    return scene_of(ball((0.0, 0.0), (1.5, 0.0), angular_velocity=spin), motion="sliding")


@pytest.mark.parametrize("slip", [1e-12, 1e-9, 1e-3])
def test_a_slip_above_rounding_is_an_event(slip: float) -> None:
    scene = slow_slide(slip)
    result = simulate(scene, record="trajectory")
    certificate = certify(scene, motion=True)
    made = grade(result, certificate)
    assert made.events == 2
    assert clean(made)
    assert grade(without_event(result, 0), certificate).missing[0] == 0


def swap(result: Result, first: int, by: float) -> Result:
    """Move event `first` to the time `by` [s] after the next event."""
    assert result.events is not None
    events = result.events.copy()
    events["t"][first] = events["t"][first + 1] + by
    return replace(result, events=events[np.argsort(events["t"], kind="stable")])


def test_events_without_a_common_ball_may_swap_and_their_times_tell() -> None:
    result, certificate, growth = run_and_proof("thirty-degree-rule")
    pairs = [
        k
        for k, (one, two) in enumerate(
            zip(certificate.events[:-1], certificate.events[1:], strict=True)
        )
        if float(two.t) - float(one.t) > 1e-3
    ]
    made = grade(swap(result, pairs[-1], 1e-6), certificate, growth)
    assert clean(made)
    assert made.swapped == 1
    assert made.time_error_max is not None
    assert made.time_error_max > 1e9
    assert grade(result, certificate, growth).swapped == 0


def test_events_of_one_ball_may_not_swap() -> None:
    result, certificate, growth = run_and_proof("around-the-table")
    made = grade(swap(result, 3, 1e-9), certificate, growth)
    assert made.missing
    assert made.invented


def test_an_engine_of_frames_is_graded_by_its_collisions() -> None:
    scene = find_scene("half-ball-cut")
    result = make_engine("pymunk:contact_steps=exact").simulate(scene, record="trajectory")
    certificate = certify(scene, motion=True)
    made = grade(result, certificate)
    assert made.events == 1
    assert clean(made)
    assert made.quality_factor is None
    assert "frames" in made.no_quality
    assert made.position_errors.max() > 1e-9
    late = grade(result, certificate, until=1e-3)
    assert (late.extent, late.events) == ("horizon", 0)


@pytest.mark.parametrize("record", ["rest", "events"])
def test_a_run_that_recorded_too_little_is_refused(record: Any) -> None:
    scene = find_scene("half-ball-cut")
    result: Result = simulate(scene, record=record)
    if record == "events":
        result = replace(result, trajectory=None)
    with pytest.raises(GhostballError, match='record="trajectory"'):
        grade(result, certify(scene, motion=True))


def test_all_kinds_of_events_are_compared() -> None:
    result, certificate, growth = run_and_proof("follow-shot")
    assert result.events is not None
    for kind in set(EventKind) - {EventKind.POCKETED}:  # this scene has no pockets
        indices = np.flatnonzero(result.events["kind"] == kind)
        for k in indices.tolist():
            assert grade(without_event(result, k), certificate, growth).missing


@pytest.mark.parametrize(
    "enclosure",
    [Enclosure(7**60, -169, 3, -170), Enclosure(-3, 5), Enclosure(0, 0, 1, -1074), Enclosure(1, 0)],
)
@pytest.mark.parametrize("value", [0.0, -0.0, 1.0, math.nextafter(1.0, 2.0), -96.0, 5e-324, 1e300])
def test_the_distance_of_a_double_from_an_enclosure_is_that_of_rationals(
    value: float, enclosure: Enclosure
) -> None:
    between = abs(Fraction(value) - enclosure.mid) - enclosure.rad
    assert _distance(value, enclosure) == float(max(between, Fraction(0)))
    assert _distance(math.inf, enclosure) == _distance(math.nan, enclosure) == math.inf
