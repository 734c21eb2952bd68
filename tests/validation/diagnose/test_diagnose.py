import math
import re

import numpy as np
import pytest
from planted_engines import hit, other_physics, stepping

from ghostball.model import EngineFailedError, EventKind, GhostballError
from ghostball.reference_adapters import make_engine
from ghostball.validation import find_scene
from ghostball.validation.diagnose.contact_states import fault_at_contacts
from ghostball.validation.diagnose.explanation import explain
from ghostball.validation.diagnose.self_check import contradiction_in
from ghostball.validation.runs.engine_runs import run_engine
from ghostball.validation.truth.known_shot import known_shot

# Planted faults at contacts are found; an engine that keeps the impact law has no fault.


@pytest.mark.parametrize("energy", [0.98, 1.005, 1.02, 1.5])
def test_a_wrong_change_of_energy_is_measured(energy):
    found = fault_at_contacts(run_engine(stepping(energy=energy, dt=1e-4), hit()))
    assert (found.what, found.kind, found.count) == ("energy", EventKind.BALL_BALL, 1)
    assert found.measured == pytest.approx(energy, abs=1e-3)
    assert found.right == pytest.approx(1.0, abs=1e-3)
    assert found.gains_energy == (energy > 1.0)


def test_a_cushion_that_gives_energy_is_told_from_balls_that_do():
    scene = find_scene("wall-bounce")
    found = fault_at_contacts(run_engine(stepping(cushion_energy=1.04), scene))
    assert (found.what, found.kind) == ("energy", EventKind.BALL_CUSHION)
    assert found.measured == pytest.approx(1.04, abs=2e-3)


def test_a_turned_normal_is_a_wrong_velocity():
    found = fault_at_contacts(run_engine(stepping(turned=math.radians(3), dt=1e-4), hit(angle=0.0)))
    assert found.what == "velocity"
    assert found.measured == pytest.approx(math.radians(3), rel=0.02)


@pytest.mark.parametrize("name", ["head-on", "half-ball-cut", "thin-cut", "break-7", "wall-bounce"])
def test_balls_that_slide_where_they_should_roll_are_found(name):
    found = fault_at_contacts(run_engine(other_physics(motion="sliding"), find_scene(name)))
    assert found.what == "slide"
    assert found.measured == pytest.approx(0.2 * 9.81, rel=0.05)
    assert found.right == pytest.approx(0.02 * 9.81)


@pytest.mark.parametrize("name", ["break-16", "pool-break-9", "throw-slip", "galperin-1"])
def test_our_engine_has_no_fault(name):
    assert fault_at_contacts(run_engine(make_engine("ghostball"), find_scene(name))) is None


@pytest.mark.parametrize("name", ["break-7", "draw-shot", "restitution-bounce", "thin-cut"])
def test_an_engine_in_steps_has_no_fault(name):
    assert fault_at_contacts(run_engine(make_engine("pymunk"), find_scene(name))) is None


def test_a_failure_of_our_own_engine_is_no_absence_of_faults(monkeypatch):
    def fail(scene):
        raise GhostballError(f"no result of {scene.name}")

    monkeypatch.setattr("ghostball.validation.diagnose.contact_states.run_ours", fail)
    with pytest.raises(GhostballError, match="no result of contact"):
        fault_at_contacts(run_engine(stepping(energy=1.5, dt=1e-4), hit()))


@pytest.mark.parametrize("rolling", [0.5, 3.0])
def test_a_wrong_rolling_friction_is_no_slide(rolling):
    assert fault_at_contacts(run_engine(stepping(rolling=rolling), hit())) is None


# A result that contradicts itself is refused; the message names the contradiction.


def moved(places):
    places = places.copy()
    places[1, 0] += 1e-4
    return places


@pytest.mark.parametrize(
    ("rest", "words"),
    [
        (lambda x: x[::-1], '"cue" and "object" are swapped'),
        (moved, 'must be the position of ball "object"'),
        (moved, "0.0001 m away"),
        (lambda x: x * [1, -1], "mirrored: y has the wrong sign"),
        (lambda x: x * [-1, 1], "mirrored: x has the wrong sign"),
        (lambda x: x[:, ::-1], "x and y are swapped"),
        (lambda x: [0.0, 1.27] + x * [1, -1], "y is measured from the top cushion"),
        (lambda x: [2.54, 0.0] + x * [-1, 1], "x is measured from the right cushion"),
    ],
)
def test_an_end_that_contradicts_the_samples_is_refused_and_named(rest, words):
    with pytest.raises(EngineFailedError, match=re.escape(words)):
        explain(hit(), stepping(rest=rest))


def test_balls_in_another_order_are_named():
    with pytest.raises(EngineFailedError, match="the balls are in a wrong order"):
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
