"""Hints after a run: features that no case tested, and properties that failed scenes share."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import wrong_runs as runs
from right_shots import checks_on
from stored_records import record
from wrong_engines import Wrong
from wrong_physics import with_balls, with_physics

from ghostball import Feature, Table, find_scene, plays
from ghostball.model.features import scene_features
from ghostball.reference_adapters.function import engine_of
from ghostball.validation.checks.requirements import asked_of
from ghostball.validation.scenes.library import select
from ghostball.validation.suite.hints import (
    SCENES_OF_FEATURE,
    features_tested,
    shared,
    simplest,
    unsupported_features,
    untested_features,
)
from ghostball.validation.suite.plan import shipped_criteria
from ghostball.validation.truth.scene_truth import truth_of


def engine(*features):
    @plays(*features)
    def simulate(scene):
        return {}

    return engine_of(simulate, "mine:simulate")()


def case(name, *, outcome="ran", reason="", **counts):
    scene = find_scene(name)
    truth = {"ball-ball": 0, "ball-cushion": 0}
    truth |= {kind.replace("_", "-"): count for kind, count in counts.items()}
    return record(
        "mine:simulate",
        scene,
        outcome=outcome,
        reason=reason,
        truth_counts=truth,
        rest_positions=np.zeros((len(scene.balls), 3)),
    )


def test_a_feature_that_no_case_tried_is_named_with_the_scene_that_does():
    # An engine that applies restitution twice passes if all balls are elastic.
    made = engine(Feature.ROLLING, Feature.MIRROR_CUSHION, Feature.BALL_RESTITUTION)
    tried = features_tested(case("wall-bounce", ball_cushion=1)) | features_tested(
        case("head-on", ball_ball=1)
    )
    assert untested_features(made, tried) == {Feature.BALL_RESTITUTION: "restitution-head-on"}
    assert (
        untested_features(made, tried | features_tested(case("restitution-head-on", ball_ball=1)))
        == {}
    )


def test_what_needs_a_collision_is_tried_where_there_is_one():
    assert features_tested(case("stop")) == {Feature.ROLLING}
    assert features_tested(case("wall-bounce", ball_cushion=1)) == {
        Feature.ROLLING,
        Feature.MIRROR_CUSHION,
    }
    assert Feature.UNEQUAL_MASSES not in features_tested(case("unequal-masses"))
    assert Feature.UNEQUAL_MASSES in features_tested(case("unequal-masses", ball_ball=1))


def test_a_scene_that_the_engine_cannot_play_tries_nothing():
    lacking = case("galperin-1", outcome="not-representable", ball_ball=1, ball_cushion=1)
    assert features_tested(lacking) == set()


@pytest.mark.parametrize(
    ("motion", "name"),
    [(Feature.ROLLING, "cushion-restitution"), (Feature.SLIDING, "cushion-restitution-sliding")],
)
def test_a_scene_is_named_in_the_motion_that_the_engine_has(motion, name):
    made = engine(motion, Feature.CUSHION_RESTITUTION)
    assert untested_features(made, {motion}) == {Feature.CUSHION_RESTITUTION: name}


def test_a_feature_without_a_scene_that_the_engine_supports_is_listed():
    # All shipped scenes with Mathavan's ball impacts have friction between balls.
    made = engine(Feature.SLIDING, Feature.UNBOUNDED_CLOTH, Feature.MATHAVAN_BALL)
    assert untested_features(made, ())[Feature.MATHAVAN_BALL] == ""


@pytest.mark.parametrize("lacks", [Feature.ROLLING, Feature.SLIDING], ids=lambda one: one.name)
@pytest.mark.parametrize("feature", Feature, ids=lambda one: one.name)
def test_every_scene_that_is_named_exists_and_tries_the_feature(feature, lacks):
    made = engine(*(one for one in Feature if one is not lacks))
    named = untested_features(made, ()).get(feature)
    if named is None:
        assert feature is lacks
    elif named:
        assert feature in scene_features(find_scene(named))
    else:
        # In every scene with friction at contacts, side spin or flight, balls slide.
        having = [one for one in map(scene_features, select()) if feature in one]
        assert all(lacks in features for features in having)
        assert lacks is Feature.SLIDING


# --- each feature alone

PLAIN = {Feature.ROLLING, Feature.SLIDING, Feature.UNBOUNDED_CLOTH, Feature.MIRROR_CUSHION}
"""Every scene needs two of these features: a kind of motion, and a cloth or table."""

NEEDS = {
    Feature.MATHAVAN_BALL: {Feature.BALL_FRICTION},
    Feature.FALLING_RESTITUTION: {Feature.CUSHION_RESTITUTION},
    Feature.CUSHION_TANGENTIAL: {Feature.CUSHION_RESTITUTION},
}
"""Features that another feature requires; laws of cushions with friction include restitution."""


def times(factor):
    return lambda value: factor * value


def always(value):
    return lambda _: value


def with_table(**fields):
    """Return an engine function that simulates a scene on a changed table."""

    def play(scene):
        wrong = Table.model_validate(scene.table.model_dump(exclude_unset=True) | fields)
        return replace(runs.right(scene.model_copy(update={"table": wrong})), scene=scene)

    return play


def on_a_table(scene):
    """Simulate a scene with an unbounded cloth on a table with cushions."""
    corner = np.array([0.5, 0.5, 0.0])
    balls = tuple(
        ball.model_copy(update={"position": tuple((place + corner).tolist())})
        for ball, place in zip(scene.balls, scene.positions, strict=True)
    )
    table = Table(length=2.54, width=1.27)
    result = runs.right(scene.model_copy(update={"table": table, "balls": balls}))
    moved = runs.with_frames(result, positions=runs.frames_of(result).positions - corner)
    return replace(runs.with_end(moved, positions=result.rest_positions - corner), scene=scene)


def with_frictions_of_the_scene(scene):
    own = {"rolling_friction": None, "sliding_friction": None, "spinning_friction_rate": None}
    balls = tuple(ball.model_copy(update=own) for ball in scene.balls)
    return replace(runs.right(scene.model_copy(update={"balls": balls})), scene=scene)


RECTANGLE = {"vertices": (), "length": 2.0, "width": 1.0}
NO_POCKETS = {"preset": None, "pockets": None, "length": 2.54, "width": 1.27}

WRONG = {
    Feature.ROLLING: [with_physics(motion=always("sliding"))],
    Feature.SLIDING: [with_physics(sliding_friction=times(1.03))],
    Feature.FRICTIONLESS_CLOTH: [with_physics(rolling_friction=always(1e-3))],
    Feature.VERTICAL_SPIN: [with_physics(spinning_friction_rate=times(1.03))],
    Feature.BALL_RESTITUTION: [with_physics(ball_restitution=times(0.97))],
    Feature.BALL_FRICTION: [with_physics(ball_friction=times(1.03))],
    Feature.SPEED_DEPENDENT_FRICTION: [with_physics(ball_friction=always(0.06))],
    Feature.MATHAVAN_BALL: [
        with_physics(ball_impact=always("frictional")),
        with_physics(ball_restitution=times(0.97)),
    ],
    Feature.UNEQUAL_MASSES: [
        with_balls(mass=times(1.03)),
        with_balls(mass=always(0.17)),
    ],
    Feature.UNEQUAL_RADII: [
        with_balls(radius=times(0.97)),
        with_balls(radius=always(0.025)),
    ],
    Feature.PER_BALL_FRICTION: [with_frictions_of_the_scene],
    Feature.UNBOUNDED_CLOTH: [on_a_table],
    Feature.OPEN_SIDES: [
        with_table(cushions=("left", "right", "bottom", "top")),
        with_table(cushions=()),
    ],
    Feature.POLYGON: [
        with_table(vertices=((0, 0), (2, 0), (1.53, 1), (0, 1))),
        with_table(**RECTANGLE),
    ],
    Feature.POCKETS: [with_table(**NO_POCKETS)],
    Feature.POSTS: [
        with_table(posts=({"centre": (1.27, 0.635), "radius": 0.0515},)),
        with_table(posts=()),
    ],
    Feature.MIRROR_CUSHION: [
        with_physics(cushion=always("restitution"), cushion_restitution=always(0.97))
    ],
    Feature.CUSHION_RESTITUTION: [
        with_physics(cushion_restitution=times(0.97)),
        # The velocity along the cushion decreases, too.
        with_physics(cushion_tangential_restitution=times(0.8)),
    ],
    Feature.FALLING_RESTITUTION: [
        with_physics(cushion_restitution_loss=times(0.97)),
        with_physics(cushion_restitution_loss=always(0.0)),
    ],
    Feature.CUSHION_TANGENTIAL: [with_physics(cushion_tangential_restitution=times(0.97))],
    Feature.FRICTIONAL_CUSHION: [
        with_physics(cushion_friction=times(0.97)),
        with_physics(cushion_restitution=times(0.97)),
    ],
    Feature.HAN_CUSHION: [
        with_physics(cushion=always("frictional")),
        with_physics(cushion_friction=times(0.97)),
        with_physics(cushion_height=times(0.97)),
    ],
    Feature.STRONGE_CUSHION: [
        with_physics(cushion=always("han2005"), cushion_frequency_ratio=always(1.8)),
        with_physics(cushion_friction=times(0.97)),
        with_physics(cushion_frequency_ratio=times(0.97)),
    ],
    Feature.MATHAVAN_CUSHION: [
        with_physics(cushion=always("han2005")),
        with_physics(cushion_friction=times(0.97)),
        with_physics(cushion_height=times(0.97)),
    ],
    Feature.AIR_DRAG: [with_physics(air_drag=times(0.97))],
    Feature.QUADRATIC_ROLLING: [with_physics(rolling_friction_quadratic=times(0.97))],
    Feature.FLIGHT: [with_physics(table_restitution=times(0.97))],
    Feature.COMPLIANT: [
        with_physics(impacts=always("simultaneous")),
        with_physics(impacts=always("sequential")),
        with_physics(ball_youngs_modulus=times(0.5)),
    ],
}
"""Engines with one wrong feature: with a wrong coefficient, or without the feature."""


OUTCOME = {"quality_factor", "rest_error_max", "rest_time_factor", "accuracy"}
"""Metrics of rest positions and rest time."""


def broken_limits(scene, play):
    made = Wrong()
    result = replace(play(scene), engine=made.name, settings={})
    own = shipped_criteria(scene)
    truth = truth_of(scene, own.truth)
    checks = checks_on(made, result, truth, asked_of([(made.name, {})], own))
    assert any(one.passed for one in checks)
    return {one.metric for one in checks if one.passed is False}


def test_each_feature_has_a_scene_of_its_own():
    # A new feature needs a scene with this feature only, and wrong engines that fail there.
    assert set(SCENES_OF_FEATURE) == set(Feature)
    assert set(WRONG) == set(Feature)
    for feature, names in SCENES_OF_FEATURE.items():
        for features in (set(scene_features(find_scene(name))) for name in names):
            assert feature in features
            assert features - {feature} <= PLAIN | NEEDS.get(feature, set()), feature


@pytest.mark.parametrize(
    ("feature", "name"), [(one, name) for one, names in SCENES_OF_FEATURE.items() for name in names]
)
def test_who_gets_one_feature_wrong_fails_its_own_scene_and_who_is_right_passes(feature, name):
    scene = find_scene(name)
    assert broken_limits(scene, runs.right) == set()
    for play in WRONG[feature]:
        assert broken_limits(scene, play) & OUTCOME


def test_smoke_tries_restitution_of_balls_and_cushions():
    assert set(SCENES_OF_FEATURE[Feature.CUSHION_RESTITUTION]) <= {
        scene.name for scene in select(["smoke"])
    }
    tried = {one for scene in select(["smoke"]) for one in scene_features(scene)}
    assert {Feature.BALL_RESTITUTION, Feature.CUSHION_RESTITUTION, Feature.UNBOUNDED_CLOTH} <= tried


def test_what_an_engine_lacked_is_counted():
    lacking = "no sliding that becomes rolling (none yet); no air drag"
    cases = [
        case("stop"),
        case("draw-shot", outcome="not-representable", reason=lacking),
        case("sliding-stun", outcome="not-representable", reason=lacking.partition(";")[0]),
    ]
    assert unsupported_features(cases) == {"sliding that becomes rolling": 2, "air drag": 1}


def test_what_failing_scenes_share_is_said_where_the_others_lack_it():
    collided = [case("head-on", ball_ball=1), case("half-ball-cut", ball_ball=1)]
    alone = [case("stop"), case("wall-bounce", ball_cushion=1)]
    assert shared(collided, alone) == "all 2 have ball collisions; no other scene does"
    assert shared(collided, [case("thin-cut", ball_ball=1)]) == ""
    assert shared(collided[:1], alone) == ""
    assert shared(collided, []) == ""


def test_the_simplest_case_is_the_one_to_look_into():
    cases = [case("break-7", ball_ball=9), case("head-on", ball_ball=1), case("stop")]
    assert simplest(cases).scene == "stop"
    assert simplest([]) is None
