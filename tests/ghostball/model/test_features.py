"""What a scene asks for is found from its values, and what an engine lacks is said in words."""

from __future__ import annotations

import pytest
from shots import POOL_TABLE, R, ball, scene_of

from ghostball.model import Table, UnsupportedSceneError
from ghostball.model.features import (
    EXACT,
    Capability,
    Feature,
    check_supported,
    missing_features,
    scene_features,
)
from ghostball.model.impact_laws import BALL_LAWS, CUSHION_LAWS

PLAIN = (Feature.ROLLING, Feature.UNBOUNDED_CLOTH)


def test_one_rolling_ball_needs_rolling_and_nothing_else():
    assert scene_features(scene_of(ball((0, 0), (1, 0)))) == PLAIN


@pytest.mark.parametrize(
    ("fields", "feature"),
    [
        ({"ball_restitution": 0.9}, Feature.BALL_RESTITUTION),
        ({"rolling_friction": 0.0, "t_max": 1.0}, Feature.FRICTIONLESS_CLOTH),
        ({"air_drag": 0.004}, Feature.AIR_DRAG),
        ({"rolling_friction_quadratic": 0.004}, Feature.QUADRATIC_ROLLING),
    ],
)
def test_a_field_of_the_physics_adds_its_feature_and_no_other(fields, feature):
    scene = scene_of(ball((0, 0), (1, 0)), ball((1, 0)), **fields)
    assert set(scene_features(scene)) == {*PLAIN, feature}


SLIDES = (Feature.SLIDING, Feature.UNBOUNDED_CLOTH)


@pytest.mark.parametrize(
    ("fields", "features"),
    [
        ({"ball_friction": 0.05}, {Feature.BALL_FRICTION}),
        # An engine that knows a constant coefficient only must not take the law for one.
        ({"ball_friction": "alciatore"}, {Feature.SPEED_DEPENDENT_FRICTION}),
        ({"ball_impact": "mathavan2014"}, {Feature.MATHAVAN_BALL}),
        (
            {"ball_impact": "mathavan2014", "ball_friction": 0.05},
            {Feature.MATHAVAN_BALL, Feature.BALL_FRICTION},
        ),
        ({"impacts": "sequential"}, set()),
    ],
)
def test_laws_between_balls(fields, features):
    scene = scene_of(ball((0, 0), (1, 0)), ball((1, 0)), motion="sliding", **fields)
    assert set(scene_features(scene)) == {*SLIDES, *features}


@pytest.mark.parametrize("friction", [0.1, "alciatore"])
def test_what_happens_between_balls_needs_two_balls(friction):
    laws = {"ball_restitution": 0.5, "ball_friction": friction, "ball_impact": "mathavan2014"}
    assert scene_features(scene_of(ball((0, 0)), **laws)) == PLAIN
    assert scene_features(scene_of(ball((0, 0)), motion="sliding", **laws)) == SLIDES


@pytest.mark.parametrize(
    ("field", "motions"),
    [
        ("rolling_friction", {"rolling", "sliding"}),
        ("sliding_friction", {"sliding"}),
        ("spinning_friction_rate", {"sliding"}),
    ],
)
@pytest.mark.parametrize("motion", ["rolling", "sliding"])
@pytest.mark.parametrize("several", [False, True])
def test_a_friction_of_a_ball_s_own_where_it_has_an_effect(field, motions, motion, several):
    # Also where all balls share it: an engine with one friction would take the scene's.
    own = {field: 0.5}
    balls = [ball((0, 0), (1, 0), **own)] + [ball((1, 0), **own)] * several
    features = scene_features(scene_of(*balls, motion=motion))
    assert (Feature.PER_BALL_FRICTION in features) == (motion in motions)


def test_a_cloth_is_frictionless_where_it_is_for_some_ball():
    free = scene_of(ball((0, 0), (1, 0)), ball((1, 0), rolling_friction=0.0), t_max=1.0)
    assert set(scene_features(free)) == {
        *PLAIN,
        Feature.PER_BALL_FRICTION,
        Feature.FRICTIONLESS_CLOTH,
    }
    slowed = scene_of(ball((0, 0), (1, 0), rolling_friction=0.01), rolling_friction=0.0)
    assert set(scene_features(slowed)) == {*PLAIN, Feature.PER_BALL_FRICTION}


def test_every_law_but_the_plain_one_has_a_feature_of_its_own():
    # Else another engine would take the law for the plain one, in silence.
    laws = [law for law in (*BALL_LAWS, *CUSHION_LAWS) if law is not BALL_LAWS[0]]
    assert len({Feature[law.feature] for law in laws}) == len(laws)


def test_unequal_balls():
    scene = scene_of(ball((0, 0), mass=1.0), ball((1, 0), radius=2 * R))
    assert {Feature.UNEQUAL_MASSES, Feature.UNEQUAL_RADII} <= set(scene_features(scene))


@pytest.mark.parametrize("side", [-3.0, 3.0])
def test_vertical_spin_of_either_sign(side):
    scene = scene_of(ball((0, 0), angular_velocity=(0, 0, side)), motion="sliding")
    assert Feature.VERTICAL_SPIN in scene_features(scene)


@pytest.mark.parametrize(
    ("fields", "features"),
    [
        ({}, {Feature.MIRROR_CUSHION}),
        (
            {"cushion": "restitution", "cushion_restitution": 0.8},
            {Feature.CUSHION_RESTITUTION},
        ),
        (
            {"cushion": "restitution", "cushion_restitution_loss": 0.1},
            {Feature.CUSHION_RESTITUTION, Feature.FALLING_RESTITUTION},
        ),
        (
            {"cushion": "restitution", "cushion_tangential_restitution": 0.8},
            {Feature.CUSHION_RESTITUTION, Feature.CUSHION_TANGENTIAL},
        ),
        ({"cushion": "frictional"}, {Feature.FRICTIONAL_CUSHION}),
        ({"cushion": "han2005"}, {Feature.HAN_CUSHION}),
        # A preset's number that the chosen law doesn't use asks for nothing.
        (
            {"preset": "carom", "rolling_friction_quadratic": 0.0, "cushion": "mirror"},
            {Feature.MIRROR_CUSHION},
        ),
        ({"cushion": "mathavan2010"}, {Feature.MATHAVAN_CUSHION}),
    ],
)
def test_cushion_laws(fields, features):
    scene = scene_of(ball((1, 1)), table=POOL_TABLE, motion="sliding", **fields)
    assert set(scene_features(scene)) == {Feature.SLIDING, *features}


def test_open_sides_and_none_at_all():
    some = scene_of(ball((1, 1)), table=Table(length=2, width=2, cushions=("left",)))
    assert {Feature.OPEN_SIDES, Feature.MIRROR_CUSHION} <= set(scene_features(some))
    none = scene_of(ball((1, 1)), table=Table(length=2, width=2, cushions=()), cushion="han2005")
    assert scene_features(none) == PLAIN


def test_an_engine_lacks_what_it_does_not_mention_and_what_it_says_it_lacks():
    scene = scene_of(ball((0, 0), (1, 0)), ball((1, 0)), ball_restitution=0.5)
    capabilities = {
        Feature.ROLLING: EXACT,
        Feature.UNBOUNDED_CLOTH: Capability("none", "walls are built in"),
    }
    assert missing_features(capabilities, scene) == (
        "no ball-ball restitution below 1",
        "no cloth without cushions (walls are built in)",
    )


def test_an_approximate_feature_is_not_missing():
    capabilities = dict.fromkeys(PLAIN, Capability("approximate", "by small steps"))
    check_supported("any", capabilities, scene_of(ball((0, 0), (1, 0))))


def test_the_refusal_names_the_engine_and_the_features():
    with pytest.raises(UnsupportedSceneError, match=r"`toy` can't represent .*: no balls that"):
        check_supported("toy", {}, scene_of(ball((0, 0))))
