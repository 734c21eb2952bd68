"""Every engine runs through one function: its faults are its failures, in any process."""

import pytest
from faulty_engine import Impostor

from ghostball.engine.library.load import NoCompilerError
from ghostball.model import EngineFailedError, UnsupportedSceneError
from ghostball.reference_adapters import engine_class, engine_names, make_engine
from ghostball.reference_adapters.registry import OURS
from ghostball.validation import find_scene
from ghostball.validation.runs.engine_runs import (
    differs_by_record,
    in_other_process,
    run_engine,
    smallest_supported,
)
from ghostball.validation.runs.time_steps import with_setting


@pytest.fixture
def fake():
    return make_engine("faulty_engine:Fake")


SCENE = find_scene("stop")

FAILURES = {
    "raise": "RuntimeError: lost the balls",
    "exit": "SystemExit: 0",
    "blame the scene": "SceneError: it is wrong",
    "lie": "`status` must be a `Status`",
}


@pytest.mark.parametrize("does", FAILURES)
def test_whatever_it_raises_or_returns_is_its_failure(fake, does):
    with pytest.raises(EngineFailedError) as failed:
        run_engine(with_setting(fake, "does", does), SCENE)
    assert failed.value.engine == "fake"
    assert failed.value.reason.startswith(FAILURES[does])
    assert ("Traceback" in failed.value.trace) is (does != "lie")
    assert not failed.value.is_our_bug


def test_no_attribute_of_an_engine_keeps_its_result_from_being_checked(fake, monkeypatch):
    monkeypatch.setattr(type(fake), "is_remote", True, raising=False)
    with pytest.raises(EngineFailedError, match="`status` must be a `Status`"):
        run_engine(with_setting(fake, "does", "lie"), SCENE)


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


def test_another_engine_of_our_name_runs_in_another_process_too():
    # If only the name were compared, a crash of this engine would end the command silently.
    engine = Impostor()
    with in_other_process(engine, 60.0) as player:
        assert player is not engine
        with pytest.raises(EngineFailedError, match="crashed"):
            run_engine(with_setting(player, "does", "crash"), SCENE)


def test_another_process_costs_the_shot_alone(fake, capfd):
    # One process simulates all shots; after a crash or a hang, the next shot runs in a new process.
    printed = []
    with in_other_process(fake, 60.0, printed.append) as player:

        def play(does):
            return run_engine(with_setting(player, "does", does), SCENE)

        result = play("run")
        expected = run_engine(fake, SCENE)
        assert result.rest_positions.tolist() == expected.rest_positions.tolist()
        assert result.events.tolist() == expected.events.tolist()
        for does, reason in FAILURES.items():
            with pytest.raises(EngineFailedError) as failed:
                play(does)
            assert failed.value.reason.startswith(reason)
        with pytest.raises(UnsupportedSceneError, match="no pure rolling"):
            play("refuse")
        with pytest.raises(EngineFailedError, match="OwnError: engine `fake` can't represent"):
            play("refuse oddly")
        printed.clear()
        assert play("print").engine == "fake"
        said = printed.pop()
        assert all(part in said for part in ("Python", "descriptor 1", "descriptor 2"))
        with pytest.raises(EngineFailedError, match=r"crashed \(exit code -9\)"):
            play("say last words")
        assert printed.pop() == "last words"
        assert play("run").engine == "fake"
        assert not printed
    assert capfd.readouterr() == ("", "")


def test_a_limit_of_time_ends_what_hangs(fake):
    with in_other_process(fake, 0.5) as player, pytest.raises(EngineFailedError) as failed:
        run_engine(with_setting(player, "does", "hang"), SCENE)
    assert failed.value.reason == "it exceeded the time limit of 0.5 s"


def test_without_a_limit_it_runs_in_this_process_and_prints_nothing(fake, capfd):
    printed = []
    with in_other_process(fake, None, printed.append) as player:
        assert run_engine(with_setting(player, "does", "print"), SCENE).engine == "fake"
    assert "descriptor 1" in printed[0]
    assert capfd.readouterr().out == ""


def test_where_a_compiler_lacks_no_engine_is_blamed(monkeypatch):
    """The message tells the user what to install; a failure would ask for a bug report."""
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
    scene = find_scene(
        smallest_supported(engine, [find_scene("stop"), find_scene("half-ball-cut")])
    )
    assert differs_by_record(engine, run_engine(engine, scene)) == ""
