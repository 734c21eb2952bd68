"""The one door for engines: what they do is their failure, in this process and in another."""

import sys
from textwrap import dedent

import pytest

from ghostball.engine.library.load import NoCompilerError
from ghostball.model import EngineFailedError, UnsupportedSceneError
from ghostball.reference_adapters import engine_class, engine_names, make_engine
from ghostball.reference_adapters.registry import OURS
from ghostball.validation import find_scene
from ghostball.validation.runs.ladder import with_setting
from ghostball.validation.runs.playing import (
    differs_by_record,
    first_played,
    in_other_process,
    run_engine,
)

ENGINE = '''
import ctypes, os, signal, time
from dataclasses import replace
from ghostball.model import SceneError, UnsupportedSceneError
from ghostball.engine import simulate
from ghostball.model.features import EXACT, Feature
from ghostball.reference_adapters import EngineBase, EngineSettings


class Settings(EngineSettings):
    does: str = "play"


class OwnError(UnsupportedSceneError):
    """An error that can't be sent to another process."""

    def __init__(self, one, two, three):
        super().__init__("evil", (one, two, three))


class Evil(EngineBase):
    name = "evil"
    Settings = Settings
    capabilities = dict.fromkeys(Feature, EXACT)

    def simulate(self, scene, *, record="rest"):
        does = self.settings.does
        if does == "print":
            print("from Python")
            ctypes.CDLL(None).puts(b"from C")
            os.write(2, b"to standard error\\n")
        if does == "raise":
            raise RuntimeError("lost the balls")
        if does == "exit":
            raise SystemExit(0)
        if does == "blame the scene":
            raise SceneError("it is wrong")
        if does == "refuse":
            raise UnsupportedSceneError(self.name, ("no balls",))
        if does == "refuse oddly":
            raise OwnError("no", "such", "thing")
        if does == "crash":
            print("last words")
            os.kill(os.getpid(), signal.SIGKILL)
        while does == "hang":
            time.sleep(1.0)
        result = replace(simulate(scene, record=record), engine=self.name, settings={})
        return replace(result, status="rest") if does == "lie" else result
'''


@pytest.fixture
def evil(tmp_path, monkeypatch):
    (tmp_path / "evil_engine.py").write_text(dedent(ENGINE))
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "evil_engine", raising=False)
    return make_engine("evil_engine:Evil")


SCENE = find_scene("stop")

FAILURES = {
    "raise": "RuntimeError: lost the balls",
    "exit": "SystemExit: 0",
    "blame the scene": "SceneError: it is wrong",
    "lie": "`status` must be a `Status`",
}


@pytest.mark.parametrize("does", FAILURES)
def test_whatever_it_raises_or_returns_is_its_failure(evil, does):
    with pytest.raises(EngineFailedError) as failed:
        run_engine(with_setting(evil, "does", does), SCENE)
    assert failed.value.engine == "evil"
    assert failed.value.reason.startswith(FAILURES[does])
    assert ("Traceback" in failed.value.trace) is (does != "lie")
    assert not failed.value.is_our_bug


def test_no_attribute_of_an_engine_keeps_its_result_from_being_checked(evil):
    type(evil).is_remote = True
    with pytest.raises(EngineFailedError, match="`status` must be a `Status`"):
        run_engine(with_setting(evil, "does", "lie"), SCENE)


def test_what_our_own_engine_raises_is_a_bug_of_ours(monkeypatch):
    def fail(*_, **__):
        raise ZeroDivisionError

    ours = make_engine(OURS)
    monkeypatch.setattr(type(ours), "simulate", fail)
    with pytest.raises(EngineFailedError) as failed:
        run_engine(ours, SCENE)
    assert failed.value.is_our_bug


def test_ours_runs_in_this_process():
    ours = make_engine(OURS)
    with in_other_process(ours, 600.0) as player:
        assert player is ours


def test_another_engine_of_our_name_runs_in_another_process_too(evil):
    # Where the name alone was compared, its crash ended the command without a word.
    impostor = type("Impostor", (type(evil),), {"name": OURS, "__module__": "evil_engine"})
    sys.modules["evil_engine"].Impostor = impostor
    engine = impostor(evil.settings)
    with in_other_process(engine, 60.0) as player:
        assert player is not engine
        with pytest.raises(EngineFailedError, match="crashed"):
            run_engine(with_setting(player, "does", "crash"), SCENE)


def test_another_process_costs_the_shot_alone(evil, capfd):
    # One process plays shot after shot; where it crashes or hangs, the next one is as good.
    printed = []
    with in_other_process(evil, 60.0, printed.append) as player:

        def play(does):
            return run_engine(with_setting(player, "does", does), SCENE)

        result = play("play")
        expected = run_engine(evil, SCENE)
        assert result.rest_positions.tolist() == expected.rest_positions.tolist()
        assert result.events.tolist() == expected.events.tolist()
        for does, reason in FAILURES.items():
            with pytest.raises(EngineFailedError) as failed:
                play(does)
            assert failed.value.reason.startswith(reason)
        with pytest.raises(UnsupportedSceneError, match="no balls"):
            play("refuse")
        with pytest.raises(EngineFailedError, match="OwnError: engine `evil` can't represent"):
            play("refuse oddly")
        printed.clear()
        assert play("print").engine == "evil"
        assert sorted(printed.pop().splitlines()) == [
            "from C",
            "from Python",
            "to standard error",
        ]
        with pytest.raises(EngineFailedError, match=r"crashed \(exit code -9\)"):
            play("crash")
        assert printed.pop() == "last words"
        assert play("play").engine == "evil"
        assert not printed
    assert capfd.readouterr() == ("", "")


def test_a_limit_of_time_ends_what_hangs(evil):
    with in_other_process(evil, 0.5) as player, pytest.raises(EngineFailedError) as failed:
        run_engine(with_setting(player, "does", "hang"), SCENE)
    assert failed.value.reason == "it took longer than 0.5 s, and was ended"


def test_without_a_limit_it_runs_in_this_process_and_prints_nothing(evil, capfd):
    printed = []
    with in_other_process(evil, None, printed.append) as player:
        assert run_engine(with_setting(player, "does", "print"), SCENE).engine == "evil"
    assert "from C" in printed[0]
    assert capfd.readouterr().out == ""


def test_where_a_compiler_lacks_no_engine_is_blamed(monkeypatch):
    """The message says what to install; as a failure it asked to report a bug."""
    lacks = NoCompilerError("numba isn't installed")

    def simulate(*_, **__):
        raise lacks

    engine = make_engine(OURS)
    monkeypatch.setattr(type(engine), "simulate", simulate)
    with pytest.raises(NoCompilerError, match=r"^numba isn't installed$"):
        run_engine(engine, find_scene("stop"))


@pytest.mark.parametrize("name", engine_names())
def test_no_shipped_engine_plays_another_shot_where_less_is_recorded(name):
    if engine_class(name).unavailable():
        pytest.skip("not here")
    engine = make_engine(name)
    scene = find_scene(first_played(engine, [find_scene("stop"), find_scene("half-ball-cut")]))
    assert differs_by_record(engine, run_engine(engine, scene)) == ""
