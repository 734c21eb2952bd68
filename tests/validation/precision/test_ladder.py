"""Fails where a ladder has wrong steps, loses a setting, or a shot begins at another place."""

import itertools

import pytest
from toy_engines import ToyEngine, ToySettings, roll

from ghostball.model import Ball, Scene
from ghostball.reference_adapters import make_engine
from ghostball.validation.precision import ladder
from ghostball.validation.precision.ladder import MOST_STEPS, ladder_of, start_of
from ghostball.validation.precision.phases import begun_earlier


def steps_of(label):
    return [rung.step for rung in ladder_of(label, make_engine(label), 4.0)]


@pytest.mark.parametrize(
    ("label", "own"),
    [
        ("pymunk", 1e-3),
        ("pymunk:contact_steps=exact", 0.02),
        ("pybullet:config=naive", 1 / 240),
        ("paper-discrete", 0.02),
        ("paper-continuous", 0.02),
        ("paper-discrete:dt=0.05", 0.05),
        ("paper-discrete:dt=1e-5", 1e-5),
    ],
)
def test_steps_are_halved_from_the_longest_and_the_own_one_is_among_them(label, own):
    if label.startswith("pybullet"):
        pytest.importorskip("pybullet")
    steps = steps_of(label)
    assert own in steps
    assert all(a == 2.0 * b for a, b in itertools.pairwise(steps))
    assert 0.01 < steps[0] <= max(0.02, own)
    assert steps[-1] == own or 4.0 / steps[-1] <= MOST_STEPS


def test_a_ladder_ends_where_it_may(monkeypatch):
    monkeypatch.setattr(ladder, "MOST_STEPS", 400)
    assert steps_of("paper-discrete") == [0.02, 0.01]
    monkeypatch.setattr(ladder, "MOST_LEVELS", 1)
    assert steps_of("paper-discrete") == [0.02]


@pytest.mark.parametrize(
    "label", ["pymunk:contact_steps=exact,iterations=3", "paper-continuous:frame=0.01"]
)
def test_labels_make_the_engine_of_the_rung(label):
    for rung in ladder_of(label, make_engine(label), 4.0):
        assert rung.family == label
        assert make_engine(rung.label).settings == rung.engine.settings


def test_each_turn_begins_the_shot_a_part_of_a_step_earlier():
    scene = roll()
    (rung, *_) = ladder_of("toy", ToyEngine(ToySettings(dt=0.02)), 4.0)
    assert start_of(scene, rung, 0) is scene
    assert start_of(scene, rung, 2) == begun_earlier(scene, 0.005)
    (point,) = ladder_of("ghostball", make_engine("ghostball"), 4.0)
    assert start_of(scene, point, 3) is scene


def test_a_shot_whose_ball_has_just_been_struck_cannot_begin_earlier():
    balls = [
        Ball(id="a", position=(0.5, 0.5), velocity=(-1.0, 0.0)),
        Ball(id="b", position=(0.56, 0.5), velocity=(1.0, 0.0)),
    ]
    (rung, *_) = ladder_of("toy", ToyEngine(ToySettings(dt=0.02)), 4.0)
    scene = Scene(name="apart", balls=balls)
    assert start_of(scene, rung, 1) is scene
