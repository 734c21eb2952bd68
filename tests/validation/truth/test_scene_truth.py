"""The reference of a scene: its kind, its precision, and its independent parts."""

from __future__ import annotations

import pickle
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from shots import crowded_table

import ghostball.validation.truth.certificates
import ghostball.validation.truth.scene_truth
from ghostball.engine import simulate
from ghostball.model import Ball, EventKind, Physics, Scene, Table
from ghostball.reference_adapters.certified import certify
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.results.store import CERTIFIED, CLOSED_FORM, OUR_ENGINE
from ghostball.validation.runs import engine_runs
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.case import truth_or_failure
from ghostball.validation.suite.judge import TruthFailure
from ghostball.validation.suite.plan import shipped_criteria
from ghostball.validation.truth.closed_forms import DIGITS, closed_form
from ghostball.validation.truth.scene_truth import Truth, TruthError, check_truth, truth_of

BB = int(EventKind.BALL_BALL)


def shot(**changes: Any) -> Scene:
    """Return a shot with too many balls for a closed form."""
    return Scene(
        **{
            "name": "no-closed-form",
            "table": Table(length=2.0, width=1.0),
            "balls": [
                Ball(id="a", position=(0.5, 0.5), velocity=(1.0, 0.0)),
                Ball(id="b", position=(1.0, 0.5)),
                Ball(id="c", position=(0.3, 0.9)),
                Ball(id="d", position=(1.7, 0.1)),
            ],
        }
        | changes
    )


def test_a_closed_form_is_kept_to_twice_double_precision() -> None:
    # With a reference in doubles, errors in ulps would contain its rounding.
    scene = find_scene("half-ball-cut")
    form, truth = closed_form(scene), truth_of(scene)
    assert form is not None
    assert truth.kind == CLOSED_FORM
    assert truth.rest_positions is not None
    with mpmath.workdps(DIGITS):
        for i, exact in enumerate(form.rest_positions):
            for axis in (0, 1):
                kept = mpmath.mpf(truth.rest_positions[i, axis]) + mpmath.mpf(
                    truth.rest_positions_low[i, axis]
                )
                assert abs(kept - exact[axis]) <= 2.0**-104 * abs(exact[axis])
    assert np.array_equal(truth.rest_positions[:, 2], scene.radii)


def unproved(scene: Scene, settings: object) -> tuple[None, str]:
    return None, "made to be refused"


def test_a_closed_form_takes_energy_and_times_from_our_engine_and_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(ghostball.validation.truth.scene_truth, "certificate_of", unproved)
    truth = truth_of(find_scene("head-on"))
    assert truth.collisions == ((BB, 0, 1),)
    assert len(truth.collision_times) == 1
    assert truth.motion is not None
    assert truth.motion.engine == "ghostball"
    independent = {
        part
        for part in ("rest", "time", "events", "conditioning", "energy")
        if not truth.is_own_measure("ghostball", part)
    }  # type: ignore[arg-type]
    assert independent == {"rest", "time", "events", "conditioning"}
    assert not truth.is_own_measure("pymunk", "energy")


def test_a_closed_form_takes_energy_and_times_from_the_proof_where_there_is_one() -> None:
    scene = find_scene("half-ball-cut")
    truth, proof = truth_of(scene), certify(scene, motion=True)
    assert truth.certificate is not None
    assert truth.certificate.to_json() == proof.to_json()
    assert truth.kind == CLOSED_FORM
    assert truth.collision_times.tolist() == [float(proof.events[0].t)]
    for part in ("rest", "time", "events", "energy", "conditioning", "certificate"):
        assert not truth.is_own_measure("ghostball", part)  # type: ignore[arg-type]
    assert truth.motion is not None
    assert truth.motion.engine == "certified"


def test_without_a_closed_form_the_proof_is_the_truth_and_independent() -> None:
    scene = shot()
    truth, ours, proof = truth_of(scene), simulate(scene, record="trajectory"), certify(scene)
    assert truth.kind == CERTIFIED
    assert truth.rest_positions is not None
    assert truth.rest_time is not None
    for ball, enclosures in enumerate(proof.positions):
        for axis, enclosure in enumerate(enclosures):
            high = Fraction(truth.rest_positions[ball, axis])
            low = Fraction(truth.rest_positions_low[ball, axis])
            # Twice double precision, because a reference in doubles would add its rounding to
            # errors.
            assert abs(high + low - enclosure.mid) <= Fraction(2) ** -104 * abs(enclosure.mid)
    assert np.array_equal(truth.rest_positions[:, 2], scene.radii)
    time = Fraction(truth.rest_time) + Fraction(truth.rest_time_low)
    assert abs(time - proof.t_end.mid) <= Fraction(2) ** -104 * proof.t_end.mid
    assert truth.collisions is not None
    assert truth.collisions[0] == (BB, 0, 1)
    assert truth.collision_times[0] == float(proof.events[0].t)
    assert truth.collision_counts == ours.collision_counts
    assert truth.motion is not None
    assert truth.motion.engine == "certified"
    for part in ("rest", "time", "events", "energy", "certificate"):
        assert not truth.is_own_measure("ghostball", part)  # type: ignore[arg-type]
    assert truth.meetings is not None
    assert truth.conditioning is None
    assert "closed form" in truth.why_not("conditioning")
    copy: Truth = pickle.loads(pickle.dumps(truth))
    assert copy.certificate is not None
    assert copy.certificate.events == proof.events


def test_without_a_closed_form_and_a_proof_our_engine_is_the_truth_and_not_independent(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(ghostball.validation.truth.scene_truth, "certificate_of", unproved)
    scene = shot()
    truth, ours = truth_of(scene), simulate(scene)
    assert truth.kind == OUR_ENGINE
    assert truth.rest_positions is not None
    assert np.array_equal(truth.rest_positions, ours.rest_positions)
    assert truth.rest_time == ours.rest_time
    assert truth.collision_counts == ours.collision_counts
    assert truth.collisions is not None
    assert truth.collisions[0] == (BB, 0, 1)
    for part in ("rest", "time", "events", "energy", "conditioning"):
        assert truth.is_own_measure("ghostball", part)  # type: ignore[arg-type]
    assert not truth.is_own_measure("ghostball", None)  # a metric without a reference
    assert not truth.is_own_measure("pymunk", "rest")
    assert truth.conditioning is None


def test_criteria_may_ask_for_the_engine_though_there_is_a_form() -> None:
    truth = truth_of(find_scene("head-on"), "engine")
    assert truth.kind == OUR_ENGINE
    assert truth.certificate is not None  # the certified result still judges the engine
    assert truth_of(find_scene("head-on"), "engine", frozenset({"rest"})).certificate is None


def test_criteria_may_ask_for_the_proof_though_there_is_a_form() -> None:
    truth = truth_of(find_scene("head-on"), "certified")
    assert truth.kind == CERTIFIED
    form = truth_of(find_scene("head-on"))
    np.testing.assert_allclose(truth.rest_positions, form.rest_positions, rtol=0, atol=1e-16)


def test_a_part_of_a_shot_that_is_proved_is_no_truth_of_the_whole() -> None:
    scene = find_scene("frozen-break")
    truth = truth_of(scene)
    assert truth.kind == OUR_ENGINE
    assert truth.certificate is not None
    assert truth.certificate.ending == "ambiguous"
    said = r'"frozen-break".*can\'t be certified: ambiguous: can\'t determine'
    with pytest.raises(TruthError, match=said):
        truth_of(scene, "certified")


def test_a_proof_of_physics_without_a_closed_form_is_refused_before_anything_runs() -> None:
    with pytest.raises(TruthError, match=r"Mathavan 2014.*`truth` = \"engine\""):
        check_truth(find_scene("mathavan-cut"), "certified")
    truth = truth_of(find_scene("mathavan-cut"))
    assert (truth.kind, truth.certificate) == (OUR_ENGINE, None)
    assert "Mathavan 2014" in truth.why_not("certificate")


def test_no_truth_at_all_says_why() -> None:
    physics = Physics(motion="sliding", cushion="mathavan2010")
    truth = truth_of(shot(physics=physics, table=crowded_table()))
    assert truth.kind is None
    assert "at most 53 obstacles" in truth.why_not("rest")


def test_only_the_parts_that_are_asked_for_are_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any, **__: Any) -> Any:
        raise AssertionError("computed for nothing")

    scene = find_scene("half-ball-cut")
    whole = truth_of(scene)
    monkeypatch.setattr(ghostball.validation.truth.scene_truth, "growth_along_certificate", refuse)
    events = truth_of(scene, parts=frozenset({"events"}))
    assert events.rounding is None
    assert np.array_equal(events.collision_times, whole.collision_times)
    assert truth_of(shot(), parts=frozenset({"rest"})).rest_positions is not None
    monkeypatch.setattr(engine_runs, "simulate", refuse)
    rest = truth_of(scene, parts=frozenset({"rest", "time", "conditioning"}))
    assert np.array_equal(rest.rest_positions, whole.rest_positions)
    assert rest.collisions == whole.collisions


def test_a_scene_that_states_its_truth_is_proved_to_its_end_or_as_far_as_it_states() -> None:
    # Fails if a proof that ends early silently leaves events of a scene unjudged.
    scene = find_scene("frozen-break")
    stated = shipped_criteria(scene)
    assert (stated.proved, stated.least_certified) == (4, 4)
    assert isinstance(truth_or_failure(scene, stated), Truth)
    for proved, must in ((None, "all"), (5, "5")):
        failure = truth_or_failure(scene, stated.model_copy(update={"proved": proved}))
        assert isinstance(failure, TruthFailure)
        assert f"only 4 of its events are certified, but {must} are required" in failure.reason
    # A scene without a required proof, such as a user's scene, gets any available reference.
    assert isinstance(truth_or_failure(scene, Criteria()), Truth)


def test_in_air_the_horizon_and_what_lateness_does_are_those_of_the_proof() -> None:
    """Fails if error growth ignores air: the horizon of this cut would be 0.98 s, not 8.9 s."""
    balls = [
        Ball(id="a", position=(0.5, 0.6), velocity=(5.0, 0.0)),
        Ball(id="b", position=(1.0, 0.63)),
    ]
    scene = Scene(name="cut-in-air", balls=balls, physics=Physics(preset="paper", air_drag=0.1))
    truth = truth_of(scene)
    assert truth.kind == CERTIFIED
    assert truth.horizon_of(0.0) == np.inf
    assert truth.meetings is not None
    assert np.isfinite(truth.meetings.largest).all()
    assert truth.lateness is not None
    assert np.isfinite(truth.lateness.places).all()
    assert truth.graded is not None
    assert truth.graded.extent == "whole"
    assert truth.graded.sizes is not None
    assert np.isfinite(truth.graded.sizes).all()
    late = truth.lateness.places[np.array(truth.lateness.kinds) == EventKind.BALL_BALL]
    assert 100.0 < late.max() < 1000.0  # the normal turns by v / 2R
