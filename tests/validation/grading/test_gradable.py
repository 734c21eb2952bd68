"""The end of grading: the horizon, the lowest bounce, or the end of the proof."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from grades import clean, grade, run_and_proof, without_event
from shots import kept_scene

from ghostball.engine import simulate
from ghostball.reference_adapters.certified import CertifiedSettings, certify
from ghostball.validation.grading.certified_growth import growth_of_certificate
from ghostball.validation.grading.tolerances import ROUNDINGS
from ghostball.validation.scenes.library import find_scene


def test_only_what_comes_before_the_horizon_is_graded() -> None:
    result, certificate, growth = run_and_proof("break-7")
    times = [float(event.t) for event in certificate.events]
    cut = 0.5 * (times[9] + times[10])
    made = grade(result, certificate, growth, until=cut)
    assert (made.extent, made.events) == ("horizon", 10)
    assert f"{cut:.6g} s" in made.why
    assert made.until == made.compared_at < cut
    assert len(made.time_errors) == 10
    assert made.position_errors.max() < 1e-14
    # Faults after the horizon don't count; faults before the horizon do.
    assert clean(grade(without_event(result, 12), certificate, growth, until=cut))
    assert grade(without_event(result, 7), certificate, growth, until=cut).missing[0] == 7


def test_an_event_on_the_other_side_of_the_horizon_is_no_difference() -> None:
    result, certificate, growth = run_and_proof("break-7")
    assert result.events is not None
    cut = float(certificate.events[9].t)
    until = math.nextafter(cut, 1.0)
    made = grade(result, certificate, growth, until=until)
    assert made.events == 10
    late = result.events.copy()
    late["t"][9] = cut * (1 + 1e-9)
    assert clean(grade(replace(result, events=late), certificate, growth, until=until))


@pytest.mark.parametrize("name", ["frozen-break", "push-line", "frozen-triangle"])
def test_what_is_proved_is_graded_where_the_proof_ends_early(name: str) -> None:
    result, certificate, growth = run_and_proof(name)
    made = grade(result, certificate, growth)
    assert made.extent == "certified part"
    assert made.why == f"{certificate.ending}: {certificate.reason}"
    assert made.events > 0
    assert clean(made)
    assert made.quality_factor is not None
    assert made.quality_factor < 32
    assert made.until == float(certificate.t_end)
    if name == "push-line":
        assert grade(without_event(result, 0), certificate, growth).missing[0] == 0


@pytest.mark.parametrize("settings", [{"max_events": 4}, {"max_precision": 60}])
def test_a_cap_leaves_what_was_proved_until_then(settings: dict[str, Any]) -> None:
    scene = find_scene("break-7")
    certificate = certify(scene, CertifiedSettings(start_precision=53, **settings), motion=True)
    made = grade(simulate(scene, record="trajectory"), certificate)
    assert made.extent == "certified part"
    assert made.why.startswith(certificate.ending)
    assert made.events == len(certificate.events)
    assert clean(made)


def test_where_nothing_is_proved_nothing_is_graded() -> None:
    made = grade(*run_and_proof("push", amplification=0.0))
    assert (made.extent, made.events, made.until) == ("certified part", 0, 0.0)
    assert made.quality_factor is None


def test_events_are_compared_beyond_the_end_of_the_tangent_map() -> None:
    # A ball that is frozen to a cushion is hit into it: the collisions are simultaneous, without a
    # derivative.
    scene = find_scene("frozen-to-cushion")
    result, certificate = simulate(scene, record="trajectory"), certify(scene, motion=True)
    ends = growth_of_certificate(scene, certificate).derivative_ends
    made = grade(result, certificate)
    assert (made.extent, made.events) == ("whole", 4)
    assert clean(made)
    assert made.compared_at < ends <= float(certificate.events[2].t)
    assert result.events is not None
    shortened = replace(result, events=result.events[:-1])
    assert grade(shortened, certificate).missing == (3,)


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_bounces_that_die_out_are_graded_until_they_do(number: int) -> None:
    # Random shots with ever lower bounces of a ball on another ball or a cushion.
    scene = kept_scene(f"bounces-die-out-{number}")
    result, certificate = simulate(scene, record="trajectory"), certify(scene, motion=True)
    made = grade(result, certificate)
    assert made.extent == "low bounce"
    assert "bounce stays below" in made.why
    assert 0 < made.events < len(certificate.events)
    assert clean(made)
    assert made.quality_factor is not None
    assert made.quality_factor < ROUNDINGS
    wrong = replace(result, events=np.delete(result.events, 1))
    assert grade(wrong, certificate).missing[0] == 1


def test_positions_are_not_graded_against_a_proof_that_is_wider_than_a_rounding() -> None:
    """Fails if the middle of a wide enclosure counts as the reference position."""
    scene = find_scene("break-7")
    result = simulate(scene, record="trajectory")
    wide = certify(scene, CertifiedSettings(start_precision=53, max_precision=53), motion=True)
    assert wide.ending == "precision cap"
    assert len(wide.events) > 3
    made = grade(result, wide)
    assert clean(made)
    assert made.quality_factor is None
    narrow = certify(scene, CertifiedSettings(max_events=len(wide.events)), motion=True)
    assert grade(result, narrow).quality_factor is not None
