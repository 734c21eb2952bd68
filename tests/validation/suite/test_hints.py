"""What a run says beyond its verdicts: what it never tried, and what its failures share."""

from __future__ import annotations

import numpy as np

from ghostball import Feature, find_scene, plays
from ghostball.model.features import scene_features
from ghostball.reference_adapters.function import engine_of
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.scenes.library import select
from ghostball.validation.suite.hints import lacked, shared, simplest, untried


def engine(*features):
    @plays(*features)
    def simulate(scene):
        return {}

    return engine_of(simulate, "mine:simulate")()


def case(name, *, outcome="ran", reason="", **counts):
    scene = find_scene(name)
    return CaseRecord(
        scene=name,
        title=scene.title,
        tags=scene.tags,
        definition=scene.model_dump(mode="json", by_alias=True),
        label="mine:simulate",
        engine="mine",
        outcome=outcome,
        reason=reason,
        truth_counts={"ball-ball": 0, "ball-cushion": 0}
        | {k.replace("_", "-"): v for k, v in counts.items()},
        rest_positions=np.zeros((len(scene.balls), 3)),
    )


def test_a_feature_that_no_scene_tries_is_named_with_the_simplest_scene_that_does():
    # Restitution that is applied twice passes wherever balls are elastic.
    made = engine(Feature.ROLLING, Feature.MIRROR_CUSHION, Feature.BALL_RESTITUTION)
    found = untried(made, [find_scene("stop"), find_scene("half-ball-cut")])
    assert found.features == (Feature.BALL_RESTITUTION,)
    (name,) = found.scenes
    assert Feature.BALL_RESTITUTION in scene_features(find_scene(name))
    assert untried(made, [find_scene("stop"), find_scene(name)]).features == ()


def test_a_scene_that_the_engine_cannot_play_tries_nothing():
    made = engine(Feature.ROLLING, Feature.MIRROR_CUSHION, Feature.UNEQUAL_MASSES)
    assert untried(made, select(["galperin-1"])).features == (
        Feature.ROLLING,
        Feature.UNEQUAL_MASSES,
        Feature.MIRROR_CUSHION,
    )


def test_what_no_shipped_scene_has_is_said_so():
    found = untried(
        engine(Feature.ROLLING, Feature.MIRROR_CUSHION, Feature.PER_BALL_FRICTION), select()
    )
    assert found.features == (Feature.PER_BALL_FRICTION,)
    assert found.scenes == ()


def test_smoke_tries_restitution_of_balls_and_cushions():
    tried = {one for scene in select(["smoke"]) for one in scene_features(scene)}
    assert {Feature.BALL_RESTITUTION, Feature.CUSHION_RESTITUTION, Feature.UNBOUNDED_CLOTH} <= tried


def test_what_an_engine_lacked_is_counted():
    lacking = "no sliding that turns into rolling (none yet); no air drag"
    cases = [
        case("stop"),
        case("draw-shot", outcome="not-representable", reason=lacking),
        case("sliding-stun", outcome="not-representable", reason=lacking.partition(";")[0]),
    ]
    assert lacked(cases) == {"sliding that turns into rolling": 2, "air drag": 1}


def test_what_failing_scenes_share_is_said_where_the_others_lack_it():
    collided = [case("head-on", ball_ball=1), case("half-ball-cut", ball_ball=1)]
    alone = [case("stop"), case("wall-bounce", ball_cushion=1)]
    assert shared(collided, alone) == "all 2 have ball collisions, and no other has"
    assert shared(collided, [case("thin-cut", ball_ball=1)]) == ""
    assert shared(collided[:1], alone) == ""
    assert shared(collided, []) == ""


def test_the_simplest_case_is_the_one_to_look_into():
    cases = [case("break-7", ball_ball=9), case("head-on", ball_ball=1), case("stop")]
    assert simplest(cases).scene == "stop"
    assert simplest([]) is None
