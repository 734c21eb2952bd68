"""A revision in a process of its own: it plays to the bit, and every end of it is told."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import gate
import numpy as np
import pytest

from ghostball import validation
from ghostball.engine import Physics, simulate
from ghostball.validation.baselines import player as player_module
from ghostball.validation.baselines.player import NotComparableError, PlayError, playing
from ghostball.validation.runs.sampling import motion_of

ROOT = Path(validation.__file__).resolve().parent.parent
SHOT = gate.cut_shot()

FACE = """
class Scene:
    @staticmethod
    def load(path):
        return path

{}

def simulate(scene, **options):
    {}
"""
"""The public face of an engine that isn't one."""


@pytest.fixture
def scene_file(tmp_path):
    path = tmp_path / "shot.toml"
    SHOT.save(path)
    return path


@pytest.fixture
def other(tmp_path):
    """Return a function that makes a checkout whose engine does something."""

    def make(simulating, importing=""):
        root = tmp_path / "other"
        (root / "engine").mkdir(parents=True)
        (root / "engine" / "__init__.py").write_text(FACE.format(importing, simulating))
        (root / "ghostball").mkdir()
        (root / "ghostball" / "__init__.py").write_text("")
        (root / "ghostball" / "engine").symlink_to("../engine")
        return root

    return make


def test_what_a_revision_played_is_what_our_engine_plays_to_the_bit(scene_file):
    with playing("the engine here", ROOT) as player:
        played = player.play(SHOT, scene_file)
        assert player.seconds(scene_file, 3) > 0.0
    ours = simulate(SHOT, record="trajectory")
    assert played.rest_positions.tobytes() == ours.rest_positions.tobytes()
    assert played.events.tobytes() == ours.events.tobytes()
    assert (played.status, played.rest_time, played.work) == (
        ours.status,
        ours.rest_time,
        dict(ours.work),
    )
    before, after = motion_of(ours), motion_of(played)
    for part in fields(before):
        one, two = getattr(before, part.name), getattr(after, part.name)
        assert (one is None) == (two is None), part.name
        assert one is None or np.array_equal(one, two), part.name


def test_a_motion_in_air_is_told_with_all_its_columns(tmp_path):
    """Broken by columns of the spin that are read as columns of the way."""
    cue = SHOT.balls[0].model_copy(update={"angular_velocity": (3.0, -20.0, 5.0)})
    physics = Physics(preset="pool", air_drag=0.1)
    shot = SHOT.model_copy(update={"physics": physics, "balls": (cue, *SHOT.balls[1:])})
    path = tmp_path / "air.toml"
    shot.save(path)
    with playing("the engine here", ROOT) as player:
        played = player.play(shot, path)
    ours = simulate(shot, record="trajectory")
    times = np.linspace(0.0, ours.rest_time, 50)
    for one, two in zip(ours.sample(times), played.sample(times), strict=True):
        assert one.tobytes() == two.tobytes()


@pytest.mark.parametrize(
    "change",
    [
        {"turns": True},  # and no column of it
        {"knots": [np.zeros((2, 13)), np.zeros((2, 13))]},
        {"knots": [np.zeros((2, 14))]},
        {"knots": [np.zeros((2, 14)), np.zeros((2, 16))]},
        {"knots": [np.zeros(14), np.zeros(14)]},
        {"knots": [[[0.0] * 14]] * 2},
    ],
)
def test_knots_of_another_form_are_refused(change):
    knots = [np.zeros((2, 16)), np.zeros((2, 16))]
    told = {"knots": knots, "turns": False, "lifts": False, "rest_time": 1.0, "spins": np.zeros(2)}
    assert player_module._motion(SHOT, told).knots[0].shape == (2, 16)
    with pytest.raises((ValueError, AttributeError)):
        player_module._motion(SHOT, told | change)


def test_the_process_ends_with_the_block(other):
    with playing("it", other("pass")) as player:
        process = player._process
        assert process.poll() is None
    assert process.poll() is not None


@pytest.mark.parametrize(
    ("importing", "said"),
    [
        ("def broken(:", "SyntaxError"),
        ("raise RuntimeError('planted')", "RuntimeError: planted"),
        ("import os; os._exit(5)", "exit code 5: no message"),
    ],
)
def test_what_cannot_be_imported_cannot_be_compared(other, importing, said):
    with (
        pytest.raises(
            NotComparableError, match="revision abc can't be built or run here"
        ) as raised,
        playing("revision abc", other("pass", importing)),
    ):
        pass
    assert said in str(raised.value)
    assert "choose another revision" in str(raised.value)


def test_another_engine_than_the_one_asked_for_is_not_played(tmp_path):
    # A root without an engine falls back on the installed one: that would be compared with itself.
    with (
        pytest.raises(NotComparableError, match="not the revision asked for"),
        playing("it", tmp_path),
    ):
        pass


def test_a_crash_in_the_midst_cannot_be_compared(other, scene_file):
    with (
        pytest.raises(NotComparableError, match="exit code 7"),
        playing("it", other("import os; os._exit(7)")) as player,
    ):
        player.play(SHOT, scene_file)


def test_a_process_that_ended_before_it_was_asked_cannot_be_compared(other, scene_file):
    def ask_too_late():
        with playing("it", other("pass")) as player:
            player._process.kill()
            player._process.wait()
            player.play(SHOT, scene_file)

    with pytest.raises(NotComparableError, match="exit code -9"):
        ask_too_late()


def test_a_revision_that_does_not_answer_is_ended(other, scene_file, monkeypatch):
    monkeypatch.setattr(player_module, "LONGEST", 1.0)
    with (
        pytest.raises(NotComparableError, match=r"took over 1 s"),
        playing("it", other("import time; time.sleep(600)")) as player,
    ):
        player.play(SHOT, scene_file)


def test_a_scene_that_a_revision_refuses_costs_that_scene_alone(other, scene_file):
    with playing("it", other("raise ValueError('no such law')")) as player:
        with pytest.raises(PlayError, match="it: ValueError: no such law"):
            player.play(SHOT, scene_file)
        with pytest.raises(PlayError, match="no such law"):
            player.seconds(scene_file, 1)


def test_a_revision_that_tells_of_its_motion_in_another_form_is_told(other, scene_file):
    run = """
    import types
    return types.SimpleNamespace(
        status=types.SimpleNamespace(name="REST"), rest_time=0.0, final_state=(1, 2, 3), events=
        __import__("numpy").zeros(1, [("t", "f8")]), collision_counts={}, work={}, wall_time=1.0,
        reason=None, trajectory=types.SimpleNamespace(knots=(), spin_decelerations=None))
    """
    with (
        playing("it", other(run)) as player,
        pytest.raises(PlayError, match="it tells of its motion in another form"),
    ):
        player.play(SHOT, scene_file)


def test_what_an_engine_prints_is_no_answer(other, scene_file):
    printing = "print('{not json}'); print('{}'); raise ValueError('told')"
    with (
        playing("it", other(printing, "print('{hello}')")) as player,
        pytest.raises(PlayError, match="told"),
    ):
        player.play(SHOT, scene_file)


def test_a_place_with_a_name_that_begins_alike_is_another_place(other, tmp_path, monkeypatch):
    root = other("pass")
    beside = tmp_path / "other-one"
    root.rename(beside)
    root.mkdir()
    monkeypatch.setenv("PYTHONPATH", str(beside))
    with pytest.raises(NotComparableError, match="not the revision"), playing("it", root):
        pass
