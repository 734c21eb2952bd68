"""A result that contradicts itself is told so, and how."""

import re

import numpy as np
import pytest
from planted_engines import hit, stepping

from ghostball.model import EngineFailedError
from ghostball.reference_adapters import make_engine
from ghostball.validation import find_scene
from ghostball.validation.diagnose.explanation import explain
from ghostball.validation.diagnose.self_check import contradiction_in
from ghostball.validation.runs.playing import run_engine
from ghostball.validation.truth.known_shot import known_shot


def moved(places):
    places = places.copy()
    places[1, 0] += 1e-4
    return places


@pytest.mark.parametrize(
    ("rest", "words"),
    [
        (lambda x: x[::-1], '"cue" and "object" are in each other\'s place'),
        (moved, 'the motion has ball "object"'),
        (moved, "0.0001 m from there"),
        (lambda x: x * [1, -1], "mirrored, y has the other sign"),
        (lambda x: x * [-1, 1], "mirrored, x has the other sign"),
        (lambda x: x[:, ::-1], "x and y are exchanged"),
        (lambda x: [0.0, 1.27] + x * [1, -1], "y is counted from the top cushion"),
        (lambda x: [2.54, 0.0] + x * [-1, 1], "x is counted from the right cushion"),
    ],
)
def test_an_end_that_contradicts_the_samples_is_refused_and_named(rest, words):
    with pytest.raises(EngineFailedError, match=re.escape(words)):
        explain(hit(), stepping(rest=rest))


def test_balls_in_another_order_are_named():
    with pytest.raises(EngineFailedError, match="balls are in another order"):
        explain(find_scene("break-7"), stepping(rest=lambda x: np.roll(x, 1, axis=0)))


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"times": 1000.0}, "its times look like milliseconds"),
        ({"events_late": 0.1}, '`events` says that "cue" hits "object" at t = 0.2'),
    ],
)
def test_a_planted_contradiction_is_named(wrong, words):
    scene = hit()
    assert words in contradiction_in(run_engine(stepping(**wrong), scene), known_shot(scene))


@pytest.mark.parametrize("label", ["ghostball", "pymunk", "pymunk:dt=5e-3", "paper-discrete"])
@pytest.mark.parametrize("name", ["break-7", "wall-bounce", "stop", "galperin-1"])
def test_no_right_result_contradicts_itself(name, label):
    scene = find_scene(name)
    result = run_engine(make_engine(label), scene)
    assert contradiction_in(result, known_shot(scene)) == ""
