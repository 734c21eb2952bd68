"""Explanations: a planted divergence is the one that is named."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from toy_engines import NoSettings, other_shot

from ghostball.engine import simulate
from ghostball.model import Ball, EventKind, Scene, Table, UnsupportedSceneError
from ghostball.model.features import EXACT, Feature
from ghostball.reference_adapters import EngineBase, make_engine
from ghostball.validation import find_scene
from ghostball.validation.diagnose.explanation import ExplanationError, explain
from ghostball.validation.grading.event_logs import Event

TABLE = Table(length=2.0, width=1.0)


def triangle():
    """The cue ball grazes "a" by 1 mm, then meets "b"."""
    balls = [
        Ball(id="cue", position=(0.3, 0.5), velocity=(2.0, 0.0)),
        Ball(id="a", position=(0.8, 0.5 + 0.05715 - 0.001)),
        Ball(id="b", position=(1.4, 0.5)),
    ]
    return Scene(name="graze", balls=balls, table=TABLE)


class BlindEngine(EngineBase):
    """Our engine, blind to one ball: it plays without it."""

    name = "blind"
    Settings = NoSettings
    blind_to = 1

    @property
    def capabilities(self):
        return dict.fromkeys(Feature, EXACT)

    def simulate(self, scene, *, record="rest"):
        far = replace_ball(scene, self.blind_to, (1.9, 0.9))
        return replace(simulate(far, record=record), engine=self.name, scene=scene)


def replace_ball(scene, index, position):
    balls = list(scene.balls)
    balls[index] = Ball(**{**dict(balls[index]), "position": position})
    return Scene(**{**dict(scene), "balls": balls})


def test_a_planted_miss_is_named_with_its_overlap_and_its_competitor():
    scene = triangle()
    found = explain(scene, BlindEngine(), attributed=False)
    parting = found.parting
    assert parting.true.key == (EventKind.BALL_BALL, 0, 1)
    assert parting.other.key == (EventKind.BALL_BALL, 0, 2)
    assert parting.t == parting.true.t == found.known.result.events["t"][0]
    overlap = next(one for one in found.margins if (one.run, one.what) == ("truth", "miss"))
    assert overlap.length == pytest.approx(1e-3, rel=1e-3)
    assert overlap.ulps == pytest.approx(1e-3 / 2.0**-53, rel=0.01)  # coordinates in [1/2, 1)
    cue = next(one for one in found.states if one.ball == "cue")
    assert cue.distance < 1e-12
    assert {one.ball for one in found.states} == {"cue", "a", "b"}


def test_a_planted_collision_is_named_with_the_gap_that_truth_leaves():
    scene = replace_ball(triangle(), 1, (0.8, 0.5 + 0.05715 + 0.002))

    class Seeing(BlindEngine):
        def simulate(self, scene, *, record="rest"):
            near = replace_ball(scene, 1, (0.8, 0.5 + 0.05715 - 0.001))
            return replace(simulate(near, record=record), engine=self.name, scene=scene)

    found = explain(scene, Seeing(), attributed=False)
    assert found.parting.other.key == (EventKind.BALL_BALL, 0, 1)
    assert found.parting.true.key == (EventKind.BALL_BALL, 0, 2)
    gap = next(one for one in found.margins if (one.run, one.what) == ("truth", "collision"))
    assert gap.length == pytest.approx(2e-3, rel=1e-3)


def test_a_planted_swap_is_named_with_the_time_between():
    # Two balls on both sides of the line, one of them 3 mm nearer.
    def scene(nearer):
        balls = [
            Ball(id="cue", position=(0.3, 0.5), velocity=(2.0, 0.0)),
            Ball(id="a", position=(0.8, 0.5 + 0.0285)),
            Ball(id="b", position=(0.8 + nearer, 0.5 - 0.0295)),
        ]
        return Scene(name="fork", balls=balls, table=TABLE)

    class Swapped(BlindEngine):
        def simulate(self, given, *, record="rest"):
            result = simulate(scene(-0.001), record=record)
            return replace(result, engine=self.name, scene=given)

    found = explain(scene(0.001), Swapped(), attributed=False)
    assert found.parting.true.key == (EventKind.BALL_BALL, 0, 1)
    assert found.parting.other.key == (EventKind.BALL_BALL, 0, 2)


def test_where_nothing_parts_the_largest_differences_are_given():
    found = explain(find_scene("half-ball-cut"), other_shot(turn=math.radians(0.01)))
    assert found.parting is None
    assert found.margins == ()
    event, late = found.latest
    assert event.key == (EventKind.BALL_BALL, 0, 1)
    assert late != 0.0
    assert 1e-5 < found.rest_distances.max() < 1e-2
    assert found.attribution.outcome == "model"


def test_chaos_parts_our_engine_from_the_certified_shot():
    found = explain(find_scene("elastic-gas"), make_engine("ghostball"), attributed=False)
    assert found.known.kind == "certified"
    assert len(found.agreement.before) >= 100
    assert found.parting is not None


def test_everything_is_json():
    found = explain(triangle(), BlindEngine(), attributed=False)
    data = json.loads(json.dumps(found.to_dict()))
    assert data["parting"]["true"] == {
        "t": found.parting.true.t,
        "kind": "ball-ball",
        "a": 0,
        "b": 1,
    }
    assert data["truth"]["by"] == "certified"
    assert len(data["rest_differences"]) == 3
    assert data["attribution"] is None


def test_bad_input_is_refused():
    still = Scene(name="still", balls=[Ball(id="a", position=(0.0, 0.0))])
    with pytest.raises(ExplanationError, match="nothing moves"):
        explain(still, make_engine("pymunk"))
    with pytest.raises(ExplanationError, match="`certified` is the truth"):
        explain(triangle(), make_engine("certified"))
    with pytest.raises(ExplanationError, match="itself the truth of scene"):
        explain(find_scene("mathavan-cut"), make_engine("ghostball"))
    with pytest.raises(UnsupportedSceneError, match="sliding"):
        explain(find_scene("sliding-stun"), make_engine("paper-discrete"))


def test_a_run_that_stops_early_is_compared_as_far_as_it_goes():
    found = explain(
        find_scene("half-ball-cut"), make_engine("pymunk:max_time=0.5"), attributed=False
    )
    assert not found.result.status.complete
    assert found.parting is None


def test_a_collision_is_described_with_names():
    scene = triangle()
    assert Event(EventKind.BALL_BALL, 0, 2, 1.0).describe(scene) == '"cue" hits "b"'
    assert Event(EventKind.BALL_CUSHION, 1, 3, 1.0).describe(scene) == ('"a" hits the top cushion')
    assert np.isfinite(explain(scene, make_engine("pymunk"), attributed=False).latest[1])
