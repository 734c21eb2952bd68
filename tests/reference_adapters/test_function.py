"""A function as an engine: name, settings, and supported features."""

from __future__ import annotations

import pickle
import sys
from dataclasses import dataclass

import pytest
from functions import ONE, SCENE, engine, still

from ghostball.model import UnsupportedSceneError
from ghostball.model.features import Feature
from ghostball.reference_adapters import EngineError, make_engine, plays
from ghostball.reference_adapters.base import resolution_of_step
from ghostball.reference_adapters.function import engine_of, name_of_function
from ghostball.validation.runs.engine_runs import in_other_process, run_engine


def test_a_function_is_named_as_its_module_unless_it_has_a_name_of_its_own():
    assert name_of_function("games.pool:simulate") == "pool"
    assert name_of_function("games.pool:fast") == "fast"


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
        # The class created from a function must be transferable to another process.
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


@pytest.mark.parametrize(
    ("function", "says"),
    [
        (lambda: None, "must take a scene"),
        (lambda scene, table: None, "its parameter `table` must have a default"),
        (lambda scene, dt="auto": None, "seconds greater than 0, got 'auto'. Change it"),
        (lambda scene, dt=0.0: None, "`dt` is its time step, so .* got 0.0"),
        (lambda scene, dt=float("nan"): None, "got nan"),
        (lambda scene, copy=True: None, "`copy` can't be a setting, .* Rename it"),
        (lambda scene, model_config="x": None, "`model_config` can't be a setting"),
        (Unhashable(), "must be a function, got an object of `Unhashable`"),
    ],
)
def test_a_function_that_no_scene_can_be_given_is_refused(function, says):
    with pytest.raises(EngineError, match=says):
        engine_of(function, "mine:simulate")
