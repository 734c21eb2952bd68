"""The limits for an engine: from files, from its declared accuracy, and for every engine."""

from dataclasses import replace

import pytest
from right_shots import checks_on
from shots import kept_scene
from toy_engines import ToyEngine
from wrong_runs import framed, with_late_events, with_slow_middle

from ghostball.model.features import Capability, Feature
from ghostball.reference_adapters import make_engine
from ghostball.validation.checks.criteria import Criteria, common_criteria
from ghostball.validation.checks.requirements import asked_of, is_unstated
from ghostball.validation.results.records import ACCURACY_KINDS
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.case import plain_settings
from ghostball.validation.suite.plan import shipped_criteria
from ghostball.validation.truth.scene_truth import truth_of

HALF_BALL = find_scene("half-ball-cut")


def limit(engine, metric="overlap_max", at_most=1.0):
    return {"engines": [engine], "metric": metric, "at_most": at_most, "reason": "because"}


def criteria(*limits):
    return Criteria.model_validate({"criteria": limits})


class Coarse(ToyEngine):
    def resolution(self, scene):
        return 5e-4


class Finer(Coarse):
    def resolution(self, scene):
        return 1e-4


class Silent(ToyEngine):
    def resolution(self, scene):
        return None


class Approximate(ToyEngine):
    @property
    def capabilities(self):
        return dict(super().capabilities) | {Feature.ROLLING: Capability("approximate", "roughly")}


def limits_of(engine, scene=HALF_BALL, own=None, for_all=None, names=None) -> dict[str, float]:
    asked = asked_of(names or [(engine.name, {})], own or Criteria(), for_all)
    found = asked.limits(engine, scene, truth_of(scene))
    return {one.metric: one.limit for one in found}


EXACTNESS = {"ball_ball_count_error", "ball_cushion_count_error"}
PROVED = {"events_missing", "events_invented", "quality_factor"}
NANOMETRES, ANOTHER_SHOT = map(ACCURACY_KINDS.index, ("nanometres", "another shot"))


def test_who_claims_to_err_by_rounding_alone_is_asked_for_all():
    asked = limits_of(ToyEngine())
    assert set(asked) > EXACTNESS | PROVED
    assert asked["overlap_max"] == pytest.approx(1e-12, rel=0.1)
    assert asked["energy_rise"] == 5e-13
    assert asked["accuracy"] == NANOMETRES


def test_how_deep_balls_may_overlap_grows_with_the_scene():
    """Fails if the limit is a constant length: the rounding grows with the scene."""
    large = limits_of(ToyEngine(), kept_scene("radius"))["overlap_max"]  # 28 575 m, 6e4 m across
    assert large == pytest.approx(2.0**-37 * 57_150.0 + 1024 * 2.0**-52 * 54_764.5, rel=1e-4)


def test_who_states_nothing_but_exact_features_must_be_right_to_nanometres():
    asked = limits_of(Silent())
    assert asked["accuracy"] == NANOMETRES
    assert set(asked) > EXACTNESS
    assert PROVED.isdisjoint(asked)
    assert asked["energy_rise"] == 1e-6


def test_who_claims_less_is_asked_for_less():
    asked = limits_of(Approximate())
    assert EXACTNESS.isdisjoint(asked)
    assert asked["accuracy"] == ANOTHER_SHOT


def test_who_states_a_step_is_held_to_what_that_allows():
    asked, finer = limits_of(Coarse()), limits_of(Finer())
    assert asked["accuracy"] == ANOTHER_SHOT
    assert asked["rest_error_max"] > 2.0 * finer["rest_error_max"] > 0.0
    assert asked["energy_rise"] == 1e-6
    assert "overlap_max" in asked


def test_a_resolution_of_a_ball_counts_as_no_resolution():
    coarse = Coarse()
    for resolution, unstated in ((5e-4, False), (0.03, True), (10.0, True), (None, False)):
        coarse.resolution = lambda _, stated=resolution: stated
        assert is_unstated(coarse, HALF_BALL) == unstated
        asked = limits_of(coarse)
        assert ("rest_error_max" in asked) == (resolution == 5e-4)
        assert ("event_time_error" in asked) == (resolution == 5e-4)


def test_every_engine_is_asked_the_same_whatever_its_name_and_package():
    ours = limits_of(make_engine("ghostball"))
    assert ours == limits_of(ToyEngine())


def test_naive_settings_are_excused_by_the_file_and_no_others():
    naive = make_engine("pymunk:config=naive")
    settings = plain_settings(naive)
    assert limits_of(naive, names=[("pymunk", settings)]) == {}
    tuned = [("pymunk", settings | {"config": "tuned"})]
    assert "accuracy" in limits_of(naive, names=tuned)
    assert "a newcomer types" in common_criteria().excuse("pymunk", settings)
    # The excuse doesn't apply to a different engine with a setting of the same name.
    assert "accuracy" in limits_of(naive, names=[("mine", settings)])
    assert common_criteria().excuse("mine", settings) == ""


def test_excused_settings_name_the_limits_that_do_not_apply():
    naive, tuned = make_engine("pymunk:config=naive"), make_engine("pymunk")
    truth = truth_of(HALF_BALL)
    asked, all_of_it = (
        asked_of([("pymunk", plain_settings(one))], Criteria()) for one in (naive, tuned)
    )
    left = {one.metric for one in asked.not_asked(naive, HALF_BALL, truth)}
    assert {"accuracy", "energy_rise", "energy_drift", "overlap_max"} <= left
    assert all_of_it.not_asked(tuned, HALF_BALL, truth) == ()


def test_the_scene_wins_then_the_file_for_all_then_the_step_then_the_law():
    own = criteria(limit("toy", "overlap_max", 1.0))
    for_all = criteria(limit("*", "overlap_max", 2.0), limit("toy", "energy_rise", 3.0))
    asked = limits_of(Coarse(), own=own, for_all=for_all)
    assert (asked["overlap_max"], asked["energy_rise"]) == (1.0, 3.0)
    assert asked["accuracy"] == ANOTHER_SHOT
    asked = limits_of(Coarse(), for_all=for_all)
    assert (asked["overlap_max"], asked["energy_rise"]) == (2.0, 3.0)


def test_a_scene_says_more_of_an_engine_that_it_names():
    # With fixed steps, balls pass through each other here: the criteria leave overlaps and counts
    # open.
    galperin = find_scene("galperin-3")
    pymunk = make_engine("pymunk")
    names = [("pymunk", plain_settings(pymunk))]
    asked = limits_of(pymunk, galperin, shipped_criteria(galperin), names=names)
    assert asked["energy_drift"] == 1e-12
    assert asked["accuracy"] == ACCURACY_KINDS.index("broken")
    assert {"rest_error_max", "overlap_max"}.isdisjoint(asked)


def test_judged_as_another_its_limits_hold_but_own_ones_first():
    for_all = criteria(limit("toy", "rest_error_ulps", 1e6))
    names = [("toy", {}), ("ghostball", {})]
    asked = limits_of(ToyEngine(), HALF_BALL, shipped_criteria(HALF_BALL), for_all, names)
    assert asked["rest_error_ulps"] == 1e6
    assert asked["rest_time_error_ulps"] == 4  # for `ghostball`, from the scene
    assert asked["quality_factor"] == 32  # for every engine that declares this accuracy


# --- planted faults of an engine that claims to be exact


WRONG = {
    "collisions 50 ms late": (lambda run: with_late_events(run, 0.05), "event_time_factor"),
    "rest half a second late": (
        lambda run: replace(run, rest_time=run.rest_time + 0.5),
        "rest_time_factor",
    ),
    "velocities 30 % low in mid-shot": (
        lambda run: with_slow_middle(run, 0.3),
        "energy_difference_factor",
    ),
    "velocities 0.1 % low in mid-shot": (
        lambda run: with_slow_middle(run, 1e-3),
        "energy_difference_factor",
    ),
}


def broken_limits(engine, result):
    truth, own = truth_of(result.scene), shipped_criteria(result.scene)
    checks = checks_on(engine, result, truth, asked_of([("toy", {})], own))
    return {one.metric for one in checks if one.passed is False}


@pytest.mark.parametrize("engine", [ToyEngine(), Silent()], ids=["rounding", "exact"])
@pytest.mark.parametrize("scene", ["half-ball-cut", "throw-slip", "restitution-bounce"])
def test_who_claims_to_be_exact_is_held_to_times_and_energy(engine, scene):
    right = engine.simulate(find_scene(scene), record="trajectory")
    assert broken_limits(engine, right) == set()
    assert broken_limits(engine, framed(right)) == set()
    for name, (plant, metric) in WRONG.items():
        assert metric in broken_limits(engine, plant(right)), name


def test_events_1_us_late_are_no_rounding():
    right = ToyEngine().simulate(HALF_BALL, record="trajectory")
    for run in (right, framed(right)):
        assert "event_time_factor" in broken_limits(ToyEngine(), with_late_events(run, 1e-6))
        assert "event_time_factor" not in broken_limits(Silent(), with_late_events(run, 1e-7))


def test_ends_500_nm_off_are_no_rounding_also_where_frames_are_all_there_is():
    right = ToyEngine().simulate(HALF_BALL, record="trajectory")
    end = right.final_state
    off = replace(right, final_state=end._replace(positions=end.positions + 5e-7))
    for run in (off, framed(off)):
        assert "quality_factor" in broken_limits(ToyEngine(), run)
