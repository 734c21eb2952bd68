"""The answer of a function in all forms, and one error for each mistake."""

from __future__ import annotations

import numpy as np
import pytest
from functions import ONE, SCENE, engine, still

from ghostball import Scene
from ghostball.model import EngineFailedError, EventKind, Status
from ghostball.model.features import Feature
from ghostball.reference_adapters import plays
from ghostball.validation.runs.engine_runs import run_engine


def test_all_forms_of_an_answer_are_the_same_result():
    # Planar numbers, mappings, names of cushions and event kinds must be read correctly.
    x, v = SCENE.positions, SCENE.velocities

    def flat(scene):
        events = [(0.2, "ball-cushion", 1, 3), (0.1, "ball-ball", 1, 0)]
        samples = [(0.0, x[:, :2], v[:, :2]), (0.3, x[:, :2], 0.0 * v[:, :2])]
        return {"rest_positions": x[:, :2].tolist(), "events": events, "samples": samples}

    def whole(scene):
        named = {"t": np.float64(0.2), "kind": EventKind.BALL_CUSHION, "a": np.int64(1), "b": "top"}
        events = [{"t": 0.1, "kind": "ball-ball", "a": 0, "b": 1}, named]
        samples = {"t": [0.0, 0.3], "positions": [x, x], "velocities": [v, 0.0 * v]}
        return {"rest_positions": x, "events": events, "samples": samples, "rest_time": 0.3}

    first, second = (run_engine(engine(one), SCENE) for one in (flat, whole))
    assert first.events.tolist() == second.events.tolist()
    assert first.events["b"].tolist() == [1, 3]
    assert first.collision_counts == {"ball-ball": 1, "ball-cushion": 1}
    assert first.rest_time == second.rest_time == 0.3
    assert first.status is Status.REST
    for name in ("positions", "velocities", "angular_velocities"):
        assert np.array_equal(getattr(first.trajectory, name), getattr(second.trajectory, name))
    assert first.trajectory.angular_velocities[0].any()  # the ball rolls


def test_a_run_that_lasts_to_the_end_of_the_scene_says_so():
    scene = ONE.model_copy(update={"t_max": 1.0})
    two = [(0.0, scene.positions, scene.velocities), (1.0, scene.positions, scene.velocities)]
    assert run_engine(engine(lambda s: still(s, samples=two)), scene).status is Status.T_MAX


def changed_in_place(scene):
    x, v, samples = scene.positions, scene.velocities, []
    for k in range(3):
        samples.append((0.1 * k, x, v))
        x += 0.1 * v
    return {"rest_positions": x, "events": [], "samples": samples}


def two(scene, factor=1.0):
    """Return two samples; the positions of the second one are multiplied by a factor."""
    x, v = scene.positions, scene.velocities
    return [(0.0, x, v), (1.0, factor * x, 0.0 * v)]


BAD = {
    "none": (lambda s: None, "must be a dict"),
    "missing": (lambda s: {"events": []}, "`rest_positions` is missing, got events"),
    "typo": (lambda s: still(s, rest_tim=1.0), "`rest_tim` is not a key of a result. Did you mean"),
    "balls": (lambda s: still(s, rest_positions=np.zeros((7, 2))), "for the 2 balls of this scene"),
    "text": (lambda s: still(s, rest_positions="far"), "`rest_positions` must be numbers"),
    "nan": (lambda s: still(s, rest_positions=np.nan * s.positions), "must be finite"),
    "no samples": (lambda s: still(s, samples=[]), r"`samples` must be .* got \[\]"),
    "shape": (
        lambda s: still(s, samples={"t": [0.0, 1.0], "positions": [], "velocities": []}),
        "`samples.positions` must have the shape",
    ),
    "time": (lambda s: still(s, rest_time="soon"), "`rest_time` must be a valid number"),
    "status": (
        lambda s: still(s, status="done"),
        "must be 'rest', 't-max', .* got 'done'",
    ),
    "kind": (lambda s: still(s, events=[(0.0, "bump", 0, 1)]), "must be one of ball-ball"),
    "event": (lambda s: still(s, events=[0.1]), r"`events\[0\]` must be \(t, kind, a, b\)"),
    "no number": (lambda s: still(s, events=[(0.0, "ball-ball", "cue", 1)]), "valid integer"),
    "no ball": (lambda s: still(s, events=[(0.0, "ball-ball", 0, 9)]), "the index of a ball"),
    "a partner in a phase change": (
        lambda s: still(s, events=[(0.0, "slide-to-roll", 0, "left")]),
        r"`events\[0\].b` must be None for an event of kind slide-to-roll, got 'left'",
    ),
    "cushion": (lambda s: still(s, events=[(0.0, "ball-cushion", 0, "north")]), "left, right"),
    "scene": (lambda s: {**still(s), "scene": "stop"}, "must be the requested scene"),
    "elsewhere": (
        lambda s: still(s, samples=[(0.0, s.positions + 0.1, s.velocities)]),
        "must start from the scene's initial state, with ball ",
    ),
    "in place": (changed_in_place, "must copy them when it records them"),
    "ball": (lambda s: still(s, events=[(0.0, "ball-ball", 0, 99)]), r"`events\[0\].b` must be"),
    "no cushion": (
        lambda s: still(s, events=[(0.0, "ball-cushion", 0, 9)]),
        "of an existing cushion",
    ),
    "not finite": (
        lambda s: still(s, samples=two(s, np.nan), rest_time=0.0),
        r"`samples.positions` must be finite, got \[nan, nan, .* at 1.0 s for ball \"cue\"",
    ),
    "backwards": (
        lambda s: still(s, samples=two(s)[::-1]),
        r"`samples.t\[1\]` must not be earlier than the previous time, 1.0 s, got 0.0 s",
    ),
    "early": (
        lambda s: still(s, samples=[(-1.0, s.positions, s.velocities), *two(s)]),
        "must start at t = 0, got -1.0 s",
    ),
    "in the cloth": (
        lambda s: still(s, rest_positions=s.positions * [1.0, 1.0, 0.0]),
        r"`rest_positions\[0\]\[2\]` must be the height .*, 0.028575 m .* got 0.0 m for ball",
    ),
    "late": (
        lambda s: still(s, samples=[(0.1, s.positions, s.velocities)]),
        "must start at t = 0, got 0.1 s",
    ),
}


@pytest.mark.parametrize("record", ["rest", "events", "trajectory"])
@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_with_an_answer_is_one_error_of_the_engine(name, record):
    # Also if only a part of the answer is needed: `run` and `validate` give the same error.
    function, says = BAD[name]
    with pytest.raises(EngineFailedError, match=says) as caught:
        run_engine(engine(function), SCENE, record)
    assert not caught.value.trace  # a traceback into Ghostball wouldn't help


def test_sliding_balls_need_angular_velocities():
    sliding = Scene.loads(
        'schema = 1\nname = "slides"\n[physics]\nmotion = "sliding"\n'
        '[[balls]]\nid = "a"\nposition = [0.0, 0.0]\nvelocity = [1.0, 0.0]\n'
    )

    @plays(*Feature)
    def simulate(scene):
        return still(scene)

    with pytest.raises(EngineFailedError, match=r"`samples.angular_velocities` is missing; it is"):
        run_engine(engine(simulate), sliding)
