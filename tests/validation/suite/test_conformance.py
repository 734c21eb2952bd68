"""What is asked of an engine: by whom it is named, and what no engine may break."""

import pytest
from step_rules import limit_of_step
from toy_engines import NoSettings, OtherShotEngine, ToyEngine

from ghostball.engine.scene.features import Capability, Feature
from ghostball.reference_adapters import EngineError
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.conformance import (
    COMPLETES,
    Asked,
    Finding,
    asked_of,
    asked_of_any,
    engine_under_test,
    run_scene,
)
from ghostball.validation.suite.suite import shipped_criteria

TOY = "toy_engines:ToyEngine"
HALF_BALL = find_scene("half-ball-cut")


def limit(engine, metric="overlap_max", at_most=1.0):
    return {"engines": [engine], "metric": metric, "at_most": at_most, "reason": "because"}


def criteria(*limits):
    return Criteria.model_validate({"criteria": limits})


def limits_of(asked: Asked) -> dict[str, float]:
    return {one.metric: one.limit for one in (*asked.stated, *asked.of_any)}


class Coarse(ToyEngine):
    def resolution(self, scene):
        return 1e-3


class Silent(ToyEngine):
    def resolution(self, scene):
        return None


class Approximate(ToyEngine):
    @property
    def capabilities(self):
        return dict(super().capabilities) | {Feature.ROLLING: Capability("approximate", "roughly")}


def metrics_of_any(engine, scene) -> dict[str, float]:
    return {criterion.metric: criterion.limit for criterion in asked_of_any(engine, scene)}


EXACTNESS = {
    "ball_ball_count_error",
    "ball_cushion_count_error",
    "events_missing",
    "events_invented",
}


def test_who_claims_to_be_exact_is_asked_for_every_collision():
    asked = metrics_of_any(ToyEngine(), HALF_BALL)
    assert set(asked) > EXACTNESS
    assert asked["overlap_max"] == 1e-12


@pytest.mark.parametrize("engine", [Coarse(), Approximate(), Silent()])
def test_who_claims_less_is_asked_for_less(engine):
    assert EXACTNESS.isdisjoint(metrics_of_any(engine, HALF_BALL))


def test_who_claims_to_be_exact_makes_no_energy_but_by_rounding():
    # A gain of 1e-12 at an impact is beyond it; a solver's noise isn't asked of who claims none.
    assert metrics_of_any(ToyEngine(), HALF_BALL)["energy_rise"] == 5e-13
    assert metrics_of_any(Coarse(), HALF_BALL)["energy_rise"] == 1e-6


def test_two_balls_may_be_off_by_what_is_stated_each():
    assert metrics_of_any(Coarse(), HALF_BALL)["overlap_max"] == 2e-3 + 1e-12


def test_who_states_nothing_is_not_taken_to_be_exact():
    asked = metrics_of_any(Silent(), HALF_BALL)
    assert asked["overlap_max"] == min(HALF_BALL.radii)
    assert asked["energy_rise"] == 1e-6


def test_energy_must_hold_where_nothing_takes_it_and_one_ball_overlaps_none():
    assert "energy_drift" in metrics_of_any(ToyEngine(), find_scene("galperin-1"))
    assert "energy_drift" not in metrics_of_any(ToyEngine(), HALF_BALL)
    assert "overlap_max" not in metrics_of_any(ToyEngine(), find_scene("stop"))


def test_the_scene_wins_then_the_file_for_all_and_what_no_engine_may_break():
    engine = engine_under_test(TOY)
    own = criteria(limit("toy", "overlap_max", 1.0))
    for_all = criteria(limit("toy", "overlap_max", 2.0), limit("toy", "energy_rise", 3.0))
    asked = limits_of(asked_of(engine, HALF_BALL, own, for_all))
    assert asked == {"overlap_max": 1.0, "energy_rise": 3.0}
    asked = limits_of(asked_of(engine, HALF_BALL, Criteria(), for_all))
    assert asked["overlap_max"] == 2.0
    assert asked["energy_rise"] == 3.0
    assert asked["events_missing"] == 0


def test_who_is_judged_as_another_engine_may_err_by_that_ones_step():
    # What is computed of pymunk, not of the toy, which states that it is exact.
    judged = engine_under_test(TOY, "pymunk")
    own = shipped_criteria(HALF_BALL)
    asked = asked_of(judged, HALF_BALL, own)
    assert "rest_error_max" in asked.metrics
    run = run_scene(judged, HALF_BALL, own, asked)
    (limit,) = [one.limit for one in run.record.checks if one.metric == "rest_error_max"]
    assert limit == limit_of_step(HALF_BALL, "pymunk")
    assert run.finding("rest_error_max").outcome == "passed"
    # Of what the step says nothing, nothing is asked.
    galperin = find_scene("galperin-2")
    asked = asked_of(judged, galperin, Criteria())
    assert run_scene(judged, galperin, Criteria(), asked).finding("rest_error_max") == Finding(
        "skipped", "galperin-2: no limit on this follows from the engine's step"
    )


def test_limits_on_other_engines_are_no_limits_of_this_one():
    engine = engine_under_test(TOY)
    asked = asked_of(engine, HALF_BALL, shipped_criteria(HALF_BALL))
    assert asked.stated == ()
    assert asked.metrics[0] == COMPLETES


def test_who_is_named_in_a_scene_is_asked_what_validate_asks():
    # Where native steps pass through everything, their criteria leave overlaps and counts open.
    galperin = find_scene("galperin-3")
    asked = asked_of(engine_under_test("pymunk"), galperin, shipped_criteria(galperin))
    assert limits_of(asked) == {"energy_drift": 1e-12}


def test_judged_as_another_its_limits_hold_but_own_ones_first():
    engine = engine_under_test(TOY, "ghostball")
    for_all = criteria(limit("toy", "rest_error_ulps", 1e6))
    asked = limits_of(asked_of(engine, HALF_BALL, shipped_criteria(HALF_BALL), for_all))
    assert asked["rest_error_ulps"] == 1e6
    assert asked["rest_time_error_ulps"] == 4  # of `ghostball`, in the scene
    assert asked["quality_factor"] == 32  # of `ghostball`, in all scenes


def test_an_engine_is_found_by_where_its_class_is_with_settings():
    engine = engine_under_test(f"{TOY}:dt=1e-3")
    assert engine.make().name == "toy"
    assert engine.make().settings.dt == 1e-3
    assert engine_under_test("pymunk:mode=landed").make().settings.mode == "landed"


def test_a_class_that_is_none_or_has_no_such_setting_is_refused():
    assert OtherShotEngine.Settings is NoSettings
    with pytest.raises(EngineError, match="`speed` is not a setting of engine `other-shot`"):
        engine_under_test("toy_engines:OtherShotEngine:speed=1")
    with pytest.raises(EngineError, match="Did you mean `toy_engines:ToyEngine`"):
        engine_under_test("toy_engines:NoEngine")
