"""Integrated shots with slides in air agree with worked numbers, closed forms and our engine."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flint import arb
from mpmath import workdps
from proofs import engine_keys, in_air, integrated_once, keys, middle
from shots import R, ball, random_cloth_shot, scene_of

from ghostball.engine import simulate
from ghostball.model import Scene
from ghostball.reference_adapters.certified.arithmetic import UndecidedError, working_precision
from ghostball.reference_adapters.certified.integrated_slide import IntegratedSlide
from ghostball.reference_adapters.ghostball import GhostballEngine
from ghostball.validation.checks.accuracy import accuracy_of
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.checks.requirements import asked_of, claim_of
from ghostball.validation.checks.step_limits import LEAST_LIMIT
from ghostball.validation.results.records import INTEGRATION, OUR_ENGINE
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth import integration
from ghostball.validation.truth.closed_forms import closed_form
from ghostball.validation.truth.collocation import BITS, Collocation
from ghostball.validation.truth.integration import MOST_ERROR, integrated, may_be_integrated
from ghostball.validation.truth.scene_truth import TruthError, truth_of

K = 0.0041
POOL = {"preset": "pool", "air_drag": K, "gravity": 9.81, "sliding_friction": 0.2}

Plane = tuple[float, float]


def slide_of(v: Plane, u: Plane, drag: float = K, friction: str = "0.2") -> IntegratedSlide:
    with working_precision(BITS):
        both = [(arb(x), arb(y)) for x, y in (v, u)]
        return Collocation(12, arb((1, -2)))(*both, arb(friction) * arb("9.81"), arb(drag))


@pytest.mark.parametrize(
    ("spin", "time", "place", "velocity"),
    [
        ((0.0, 0.0), 0.43514440820822335, (1.1168116256280046, 0.0), (2.1343833222613356, 0.0)),
        (
            (-50.0, 60.0),
            0.27906760072226945,
            (0.78488866111409261, 0.056830779037561494),
            (2.6262173230896689, 0.40775401791915693),
        ),
    ],
)
def test_a_slide_ends_where_worked_numbers_say(spin, time, place, velocity):
    wx, wy = spin
    slide = slide_of((3.0, 0.0), (3.0 - R * wy, R * wx))
    found = (slide.duration, *slide.end, *slide.final_velocity)
    for number, worked in zip(found, (time, *place, *velocity), strict=True):
        assert float(number) == pytest.approx(worked, rel=1e-15)


def test_polynomials_of_a_slide_continue_each_other():
    """This includes a ball with backspin whose velocity is 0 at one time."""
    for v, u in (((2.0, 0.25), (1.5, -1.75)), ((1.5, 0.0), (6.9, 0.0)), ((0.0, 0.0), (-3.0, 1.0))):
        slide = slide_of(v, u)
        with working_precision(BITS):
            for one, after in zip(slide.pieces, slide.pieces[1:], strict=False):
                for what in ("displacement", "velocity", "slip"):
                    for p, q in zip(getattr(one, what), getattr(after, what), strict=True):
                        assert abs(p(after.start - one.start) - q[0]) < 1e-40
            # The acceleration is the derivative of the velocity.
            for s in (0.3, 0.9):
                t = slide.duration * s
                (vx, vy), (ux, uy) = slide.velocity(t), slide.slip(t)
                ax, ay = slide.slowed((vx, vy), (ux, uy))
                h = arb("1e-12")
                later = slide.velocity(t + h)
                assert abs((later[0] - vx) / h - ax) < 1e-9
                assert abs((later[1] - vy) / h - ay) < 1e-9


def test_what_air_slows_too_much_is_refused():
    with pytest.raises(UndecidedError, match="by more than rolling allows"):
        slide_of((100.0, 0.0), (1.0, 0.0), 0.01)


@pytest.mark.parametrize("name", ["air-drag-sliding", "air-slides"])
def test_an_integration_agrees_with_closed_forms(name):
    """Straight slides have a closed form."""
    scene = find_scene(name)
    form = closed_form(scene)
    shot = integrated_once(scene)
    with workdps(40):
        for place, expected in zip(shot.positions, form.rest_positions, strict=True):
            for number, exact in zip(place, expected, strict=True):
                assert abs(middle(number) - exact) < 1e-24


def test_the_error_of_an_integration_is_estimated_by_a_second_one(monkeypatch):
    scene = scene_of(ball((0.0, 0.0), (2.0, 0.5), angular_velocity=(0.0, 0.0, 0.0)), **POOL)
    found, why = integrated(scene)
    assert why == ""
    assert found is not None
    assert 0.0 < found.error < 1e-28
    monkeypatch.setattr(integration, "_RUNS", ((4, arb((1, -2))), (3, arb((1, -2)))))
    monkeypatch.setattr(integration, "_SOURCES", ("with few points",))
    found, why = integrated(scene)
    assert found is None
    assert "its estimated error is" in why


def swerve() -> Scene:
    return scene_of(
        ball((0.0, 0.0), (3.0, 0.0), angular_velocity=(60.0, -40.0, 30.0)),
        ball((0.8, -0.05)), **POOL
    )  # fmt: skip


@pytest.mark.slow
def test_our_engine_plays_every_integrated_event():
    """Sliding balls with spin about any axis hit other balls and cushions."""
    scene = in_air(random_cloth_shot(12), air_drag=1.0)
    found, why = integrated(scene)
    assert why == ""
    assert found is not None
    assert keys(found.shot) == engine_keys(scene)
    rest = np.array([[float(x) for x in place] for place in found.shot.positions])
    assert np.abs(rest - simulate(scene).rest_positions[:, :2]).max() < 1e-10


def test_the_truth_of_a_slide_in_air_is_its_integration(tmp_path, monkeypatch):
    """The reference is called not certified, and the stored integration is read again."""
    monkeypatch.setenv("GHOSTBALL_CACHE_DIR", str(tmp_path))
    scene = swerve()
    truth = truth_of(scene, "integration")
    assert truth.kind == INTEGRATION
    assert "not certified" in INTEGRATION
    assert f"{MOST_ERROR:g}" in INTEGRATION
    assert truth.certificate is None
    assert "no slides in air" in truth.no_certificate
    assert {"rest", "time", "events", "energy"} <= truth.independent
    assert truth_of(scene).kind == OUR_ENGINE
    ours = simulate(scene)
    assert np.abs(truth.rest_positions - ours.rest_positions).max() < 1e-11
    assert math.isfinite(float(truth.meetings.largest[0]))
    calls = []
    monkeypatch.setattr(integration, "prove", lambda *_, **__: calls.append(1))
    assert integrated(scene)[0] is not None
    assert calls == []


def test_what_has_no_slides_in_air_is_not_integrated():
    assert not may_be_integrated(scene_of(ball((0.0, 0.0), (1.0, 0.0)), preset="pool"))
    assert not may_be_integrated(scene_of(ball((0.0, 0.0), (1.0, 0.0)), **POOL, airborne=True))
    with pytest.raises(TruthError, match="no ball slides in air"):
        truth_of(scene_of(ball((0.0, 0.0), (1.0, 0.0)), preset="pool"), "integration")


def test_our_engine_states_its_resolution_where_balls_slide_in_air():
    engine = GhostballEngine()
    assert 1e-13 < engine.resolution(swerve()) < 2e-11
    assert engine.resolution(find_scene("air-paper")) == 0.0
    assert engine.resolution(find_scene("masse")) == 0.0


@pytest.mark.slow  # it integrates a shot again
def test_the_law_holds_our_engine_to_the_resolution_that_it_states(tmp_path, monkeypatch):
    """Fails if a resolution of nanometres counts as a time step, or limits nothing."""
    monkeypatch.setenv("GHOSTBALL_CACHE_DIR", str(tmp_path))
    engine = GhostballEngine()
    scene = scene_of(ball((0.0, 0.0), (2.0, 0.5), angular_velocity=(0.0, 9.0, 0.0)), **POOL)
    assert claim_of(engine, scene) == "exact"
    assert claim_of(engine, find_scene("masse")) == "rounding"
    truth = truth_of(scene, "integration")
    asked = asked_of([("ghostball", {})], Criteria())
    limits = {one.metric: one.limit for one in asked.limits(engine, scene, truth)}
    assert limits["rest_error_max"] == LEAST_LIMIT + engine.resolution(scene) < 1e-11
    assert limits["energy_rise"] == 5e-13
    two = scene_of(ball((0.0, 0.0), (2.0, 0.5)), ball((1.0, 0.0)), **POOL)
    limits = {one.metric: one.limit for one in asked.limits(engine, two, truth)}
    assert limits["overlap_max"] < 1e-10
    result = simulate(scene, record="trajectory")
    assert accuracy_of(result, truth).kind in ("exact", "nanometres")
