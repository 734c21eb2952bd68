"""A function as an engine: what it may return, its settings, and one error for each mistake."""

from __future__ import annotations

import pickle
import sys
from dataclasses import dataclass

import numpy as np
import pytest

from ghostball import Scene, find_scene
from ghostball.model import EngineFailedError, EventKind, Status, UnsupportedSceneError
from ghostball.model.features import Feature
from ghostball.reference_adapters import EngineError, make_engine, plays
from ghostball.reference_adapters.base import resolution_of_step
from ghostball.reference_adapters.function import engine_of, name_of_function
from ghostball.validation.runs.playing import in_other_process, run_engine

SCENE = find_scene("half-ball-cut")
ONE = find_scene("stop")


def still(scene, **more):
    """A right answer of a shot that is over at once."""
    sample = (0.0, scene.positions, scene.velocities)
    return {"rest_positions": scene.positions, "events": [], "samples": [sample]} | more


def engine(function, where="mine:simulate"):
    return engine_of(function, where)()


def test_a_function_is_named_as_its_module_unless_it_has_a_name_of_its_own():
    assert name_of_function("games.pool:simulate") == "pool"
    assert name_of_function("games.pool:fast") == "fast"


def test_all_forms_of_an_answer_are_the_same_result():
    # Breaks where planar numbers, mappings, cushions by name or event kinds are read otherwise.
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
    assert first.trajectory.angular_velocities[0].any()  # it rolls


def test_a_run_that_lasts_to_the_end_of_the_scene_says_so():
    scene = ONE.model_copy(update={"t_max": 1.0})
    two = [(0.0, scene.positions, scene.velocities), (1.0, scene.positions, scene.velocities)]
    assert run_engine(engine(lambda s: still(s, samples=two)), scene).status is Status.T_MAX


def test_parameters_with_defaults_are_settings_and_dt_is_the_step(tmp_path, monkeypatch):
    source = (
        "def simulate(scene, dt=1e-3, solver='plain', *, rounds=3):\n"
        "    assert isinstance(dt, float) and isinstance(rounds, int), (dt, rounds)\n"
        "    one = (0.0, scene.positions, scene.velocities)\n"
        "    return {'rest_positions': scene.positions, 'events': [], 'samples': [one],\n"
        "            'reason': f'{dt} {solver} {rounds}'}\n"
    )
    (tmp_path / "some_engine.py").write_text(source, "utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    try:
        made = make_engine("some_engine:simulate:dt=2e-3,rounds=5")
        assert made.settings.model_dump() == {"dt": 2e-3, "solver": "plain", "rounds": 5}
        assert made.resolution(ONE) == resolution_of_step(2e-3, ONE)
        assert {one.support for one in made.capabilities.values()} == {"exact"}
        with pytest.raises(EngineError, match="`dt` of engine `some_engine` must be greater"):
            make_engine("some_engine:simulate:dt=0")
        with pytest.raises(EngineError, match="`roundz` is not a setting"):
            make_engine("some_engine:simulate:roundz=5")
        with pytest.raises(EngineError, match=r"no 'simulat'. Did you mean `some_engine:simulate`"):
            make_engine("some_engine:simulat")
        # Breaks where the class that is made of a function can't be sent to another process.
        assert pickle.loads(pickle.dumps(type(made))) is type(made)
        assert pickle.loads(pickle.dumps(made.settings)) == made.settings
        with in_other_process(made, 60.0) as player:
            assert run_engine(player, ONE).reason == "0.002 plain 5"
    finally:
        sys.modules.pop("some_engine", None)


def test_a_function_without_a_step_claims_nothing_of_how_exact_it_is():
    made = engine(still)
    assert made.resolution(ONE) is None
    assert {one.support for one in made.capabilities.values()} == {"approximate"}


def test_what_a_function_plays_is_what_it_says():
    @plays(Feature.ROLLING, Feature.UNBOUNDED_CLOTH)
    def simulate(scene):
        return still(scene)

    assert set(engine(simulate).capabilities) == {Feature.ROLLING, Feature.UNBOUNDED_CLOTH}
    assert set(engine(still).capabilities) == {Feature.ROLLING, Feature.MIRROR_CUSHION}
    with pytest.raises(EngineError, match=r"members of `Feature`, got 'rolling'. There are ROLL"):
        plays("rolling")


def test_a_scene_that_a_function_does_not_implement_is_none_that_it_fails():
    def simulate(scene):
        raise NotImplementedError("no two balls yet")

    with pytest.raises(UnsupportedSceneError, match="no two balls yet"):
        run_engine(engine(simulate), SCENE)


def changed_in_place(scene):
    x, v, samples = scene.positions, scene.velocities, []
    for k in range(3):
        samples.append((0.1 * k, x, v))
        x += 0.1 * v
    return {"rest_positions": x, "events": [], "samples": samples}


def two(scene, factor=1.0):
    """Two samples, the second with the places times a factor."""
    x, v = scene.positions, scene.velocities
    return [(0.0, x, v), (1.0, factor * x, 0.0 * v)]


BAD = {
    "none": (lambda s: None, "must be a dict"),
    "missing": (lambda s: {"events": []}, "`rest_positions` is missing, got events"),
    "typo": (lambda s: still(s, rest_tim=1.0), "`rest_tim` is no key of an answer. Did you mean"),
    "balls": (lambda s: still(s, rest_positions=np.zeros((7, 2))), "of the 2 balls of this scene"),
    "text": (lambda s: still(s, rest_positions="far"), "`rest_positions` must be numbers"),
    "nan": (lambda s: still(s, rest_positions=np.nan * s.positions), "must be finite"),
    "no samples": (lambda s: still(s, samples=[]), "`samples` must be .* got none"),
    "shape": (
        lambda s: still(s, samples={"t": [0.0, 1.0], "positions": [], "velocities": []}),
        "`samples.positions` must have the shape",
    ),
    "time": (lambda s: still(s, rest_time="soon"), "`rest_time` must be a number"),
    "status": (lambda s: still(s, status="done"), "must be one of rest, t-max, step-limit, failed"),
    "kind": (lambda s: still(s, events=[(0.0, "bump", 0, 1)]), "must be one of ball-ball"),
    "event": (lambda s: still(s, events=[0.1]), r"`events\[0\]` must be \(t, kind, a, b\)"),
    "no number": (lambda s: still(s, events=[(0.0, "ball-ball", "cue", 1)]), "valid integer"),
    "no ball": (lambda s: still(s, events=[(0.0, "ball-ball", 0, 9)]), "the index of a ball"),
    "cushion": (lambda s: still(s, events=[(0.0, "ball-cushion", 0, "north")]), "left, right"),
    "scene": (lambda s: {**still(s), "scene": "stop"}, "must be the one that was asked"),
    "elsewhere": (
        lambda s: still(s, samples=[(0.0, s.positions + 0.1, s.velocities)]),
        'must begin as the scene does, with ball "cue" at',
    ),
    "in place": (changed_in_place, "must be copied where they are recorded"),
    "ball": (lambda s: still(s, events=[(0.0, "ball-ball", 0, 99)]), r"`events\[0\].b` must be"),
    "no cushion": (
        lambda s: still(s, events=[(0.0, "ball-cushion", 0, 9)]),
        "of a cushion that is",
    ),
    "not finite": (
        lambda s: still(s, samples=two(s, np.nan), rest_time=0.0),
        r"`samples.positions` must be finite, got \[nan, nan, .* at 1.0 s for ball \"cue\"",
    ),
    "backwards": (
        lambda s: still(s, samples=two(s)[::-1]),
        r"`samples.t\[1\]` must be no earlier than the instant before, 1.0 s, got 0.0 s",
    ),
    "early": (
        lambda s: still(s, samples=[(-1.0, s.positions, s.velocities), *two(s)]),
        "must begin at t = 0, got -1.0 s",
    ),
    "in the cloth": (
        lambda s: still(s, rest_positions=s.positions * [1.0, 1.0, 0.0]),
        r"`rest_positions\[0\]\[2\]` must be the height .*, 0.028575 m .* got 0.0 m for ball",
    ),
    "late": (
        lambda s: still(s, samples=[(0.1, s.positions, s.velocities)]),
        "must begin at t = 0, got 0.1 s",
    ),
}


@pytest.mark.parametrize("record", ["rest", "events", "trajectory"])
@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_with_an_answer_is_one_error_of_the_engine(name, record):
    # Also where only a part of it is asked for: `run` and `validate` say the same.
    function, says = BAD[name]
    with pytest.raises(EngineFailedError, match=says) as caught:
        run_engine(engine(function), SCENE, record)
    assert not caught.value.trace  # where we looked at it says nothing


@dataclass
class Unhashable:
    """A callable object whose class compares its fields, and so has no hash."""

    calls: int = 0

    def __call__(self, scene):
        return still(scene)


def test_a_parameter_that_begins_with_an_underscore_is_no_setting():
    def simulate(scene, dt=1, _debug=False):
        return still(scene, reason=f"{dt!r} {_debug}")

    made = engine(simulate)
    assert made.settings.model_dump() == {"dt": 1.0}
    assert run_engine(made, SCENE).reason == "1.0 False"


def test_sliding_balls_need_angular_velocities():
    sliding = Scene.loads(
        'schema = 1\nname = "slides"\n[physics]\nmotion = "sliding"\n'
        '[[balls]]\nid = "a"\nposition = [0.0, 0.0]\nvelocity = [1.0, 0.0]\n'
    )

    @plays(*Feature)
    def simulate(scene):
        return still(scene)

    with pytest.raises(EngineFailedError, match=r"`samples.angular_velocities` is missing, and in"):
        run_engine(engine(simulate), sliding)


@pytest.mark.parametrize(
    ("function", "says"),
    [
        (lambda: None, "must take a scene"),
        (lambda scene, table: None, "its parameter `table` must have a default"),
        (lambda scene, dt="auto": None, "seconds greater than 0, got 'auto'. Give it one"),
        (lambda scene, dt=0.0: None, "`dt` is its step, so that .* got 0.0"),
        (lambda scene, dt=float("nan"): None, "got nan"),
        (lambda scene, copy=True: None, "`copy` can't be a setting: .* Rename it"),
        (lambda scene, model_config="x": None, "`model_config` can't be a setting"),
        (Unhashable(), "must be a function, got an object of `Unhashable`"),
    ],
)
def test_a_function_that_no_scene_can_be_given_is_refused(function, says):
    with pytest.raises(EngineError, match=says):
        engine_of(function, "mine:simulate")
