"""The values of a scene determine its features; messages name features that an engine lacks."""

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

F = Feature
PLAIN = (F.ROLLING, F.UNBOUNDED_CLOTH)
SLIDES = (F.SLIDING, F.UNBOUNDED_CLOTH)
SLIDING = {"motion": "sliding"}
MOVES, STILL, MIDDLE = ball((0, 0), (1, 0)), ball((1, 0)), ball((1, 1))
PAIR = (MOVES, STILL)
ON_TABLE = {"table": POOL_TABLE, **SLIDING}
BETWEEN = {"ball_restitution": 0.5, "ball_impact": "mathavan2014"}

NEEDED = [
    ((MOVES,), {}, PLAIN),
    # The physics.
    (PAIR, {"ball_restitution": 0.9}, {*PLAIN, F.BALL_RESTITUTION}),
    (PAIR, {"rolling_friction": 0.0, "t_max": 1.0}, {*PLAIN, F.FRICTIONLESS_CLOTH}),
    (PAIR, {"air_drag": 0.004}, {*PLAIN, F.AIR_DRAG}),
    (PAIR, {"rolling_friction_quadratic": 0.004}, {*PLAIN, F.QUADRATIC_ROLLING}),
    # Laws between balls: an engine with a friction coefficient must not accept a law.
    (PAIR, {**SLIDING, "ball_friction": 0.05}, {*SLIDES, F.BALL_FRICTION}),
    (PAIR, {**SLIDING, "ball_friction": "alciatore"}, {*SLIDES, F.SPEED_DEPENDENT_FRICTION}),
    (PAIR, {**SLIDING, "ball_impact": "mathavan2014"}, {*SLIDES, F.MATHAVAN_BALL}),
    (
        PAIR,
        {**SLIDING, "ball_impact": "mathavan2014", "ball_friction": 0.05},
        {*SLIDES, F.MATHAVAN_BALL, F.BALL_FRICTION},
    ),
    (PAIR, {**SLIDING, "impacts": "sequential"}, SLIDES),
    # Features of ball impacts need two balls.
    *(
        ((ball((0, 0)),), {**BETWEEN, **motion, "ball_friction": friction}, features)
        for friction in (0.1, "alciatore")
        for motion, features in (({}, PLAIN), (SLIDING, SLIDES))
    ),
    # A cloth is frictionless if it is for one ball.
    (
        (MOVES, ball((1, 0), rolling_friction=0.0)),
        {"t_max": 1.0},
        {*PLAIN, F.PER_BALL_FRICTION, F.FRICTIONLESS_CLOTH},
    ),
    (
        (ball((0, 0), (1, 0), rolling_friction=0.01),),
        {"rolling_friction": 0.0},
        {*PLAIN, F.PER_BALL_FRICTION},
    ),
    (
        (ball((0, 0), mass=1.0), ball((1, 0), radius=2 * R)),
        {},
        {*PLAIN, F.UNEQUAL_MASSES, F.UNEQUAL_RADII},
    ),
    *(
        ((ball((0, 0), angular_velocity=(0, 0, side)),), SLIDING, {*SLIDES, F.VERTICAL_SPIN})
        for side in (-3.0, 3.0)
    ),
    # Laws of cushions: a number that the chosen law doesn't use needs no feature.
    *(
        ((MIDDLE,), {**ON_TABLE, **fields}, {F.SLIDING, *features})
        for fields, features in (
            ({}, {F.MIRROR_CUSHION}),
            ({"cushion": "restitution", "cushion_restitution": 0.8}, {F.CUSHION_RESTITUTION}),
            (
                {"cushion": "restitution", "cushion_restitution_loss": 0.1},
                {F.CUSHION_RESTITUTION, F.FALLING_RESTITUTION},
            ),
            (
                {"cushion": "restitution", "cushion_tangential_restitution": 0.8},
                {F.CUSHION_RESTITUTION, F.CUSHION_TANGENTIAL},
            ),
            ({"cushion": "frictional"}, {F.FRICTIONAL_CUSHION}),
            ({"cushion": "han2005"}, {F.HAN_CUSHION}),
            ({"cushion": "mathavan2010"}, {F.MATHAVAN_CUSHION}),
            (
                {"preset": "carom", "rolling_friction_quadratic": 0.0, "cushion": "mirror"},
                {F.MIRROR_CUSHION},
            ),
        )
    ),
    (
        (MIDDLE,),
        {"table": Table(length=2, width=2, cushions=("left",))},
        {F.ROLLING, F.OPEN_SIDES, F.MIRROR_CUSHION},
    ),
    ((MIDDLE,), {"table": Table(length=2, width=2, cushions=()), "cushion": "han2005"}, PLAIN),
    # A ball's own friction needs a feature if it has an effect, even if all balls have it: an
    # engine with one friction would use the scene's.
    *(
        (
            [ball((0, 0), (1, 0), **{field: 0.5}), ball((1, 0), **{field: 0.5})][:count],
            {"motion": motion},
            {
                *(SLIDES if motion == "sliding" else PLAIN),
                *([F.PER_BALL_FRICTION] if motion in motions else []),
            },
        )
        for field, motions in (
            ("rolling_friction", ("rolling", "sliding")),
            ("sliding_friction", ("sliding",)),
            ("spinning_friction_rate", ("sliding",)),
        )
        for motion in ("rolling", "sliding")
        for count in (1, 2)
    ),
]
"""Balls, fields of the scene, and the features that these need."""


@pytest.mark.parametrize(("balls", "fields", "features"), NEEDED)
def test_a_scene_needs_the_features_of_its_values_and_no_other(balls, fields, features):
    assert set(scene_features(scene_of(*balls, **fields))) == set(features)


def test_every_law_but_the_plain_one_has_a_feature_of_its_own():
    # Otherwise another engine would silently use the plain law.
    laws = [law for law in (*BALL_LAWS, *CUSHION_LAWS) if law is not BALL_LAWS[0]]
    assert len({Feature[law.feature] for law in laws}) == len(laws)


def test_an_engine_lacks_what_it_does_not_mention_and_what_it_says_it_lacks():
    scene = scene_of(ball((0, 0), (1, 0)), ball((1, 0)), ball_restitution=0.5)
    capabilities = {
        Feature.ROLLING: EXACT,
        Feature.UNBOUNDED_CLOTH: Capability("none", "walls are built in"),
    }
    assert missing_features(capabilities, scene) == (
        "no ball-ball restitution below 1",
        "no unbounded cloth (walls are built in)",
    )


def test_an_approximate_feature_is_not_missing():
    capabilities = dict.fromkeys(PLAIN, Capability("approximate", "by small steps"))
    check_supported("any", capabilities, scene_of(ball((0, 0), (1, 0))))


def test_the_refusal_names_the_engine_and_the_features():
    with pytest.raises(UnsupportedSceneError, match=r"`toy` can't represent .*: no pure rolling"):
        check_supported("toy", {}, scene_of(ball((0, 0))))
