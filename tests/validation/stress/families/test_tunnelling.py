"""Tunnelling: the cliff is where theory puts it, and a miss is seen."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import EventKind, Scene, UnsupportedSceneError
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.runs.steps import with_step
from ghostball.validation.stress.families.tunnelling import (
    DIAMETER,
    FAMILY,
    PHASES,
    EndEnergy,
    Passing,
    bounces,
    crossing,
    elastic_break,
    energy_limit,
    own_step,
    passing,
)
from ghostball.validation.stress.trial import SceneTrial


def test_the_half_chord_of_a_full_collision_is_a_diameter():
    assert crossing(1.0) == pytest.approx(DIAMETER)
    assert crossing(0.5) == pytest.approx(DIAMETER * math.sqrt(0.75))


@pytest.mark.parametrize("phase", [0.0, 0.25, 0.875])
def test_contact_comes_a_phase_after_whole_steps_and_before_the_end(phase):
    step, speed, depth = 0.004, 2.0, 0.1
    scene = passing(depth, speed, step, phase)
    (event,) = simulate(scene, record="events").events
    assert event["kind"] == EventKind.BALL_BALL
    assert (event["t"] / step) % 1.0 == pytest.approx(phase, abs=1e-9)
    assert scene.t_max > event["t"] + 2.0 * crossing(depth) / speed
    # So that no engine shortens its step to fit.
    assert math.ceil(scene.t_max / step) * step == pytest.approx(scene.t_max, rel=1e-8)


@pytest.mark.parametrize(("engine", "chord"), [("pymunk", 1.0), ("paper-discrete", 2.0)])
def test_the_cliff_is_where_theory_puts_it(engine, chord):
    # Pymunk reacts while balls approach, so for half of the chord; the paper's always.
    speed, depth = 2.0, 0.1
    longest = chord * crossing(depth) / speed
    trial = Passing("some", speed, depth, halves=2, phases=32)
    values = trial.run(make_engine(engine)).values
    assert longest / 2.0**0.55 < values["largest_step"] < 1.05 * longest
    for rung in values["ladder"]:
        # 1 - c / (v dt), where the engine reacts over a way of c.
        expected = max(0.0, 1.0 - longest / rung["dt"])
        assert rung["missed"] / 32 == pytest.approx(expected, abs=0.05)


def test_a_miss_at_its_own_step_breaks_an_engine_and_is_seen_again_in_its_scene():
    engine = with_step(make_engine("pymunk"), 0.05)
    verdict = Passing("some", 2.0, 0.1, halves=1, phases=2).run(engine)
    assert verdict.broken > 0
    assert "go through the other ball at a step of 0.05 s" in verdict.faults[0]
    assert engine.simulate(verdict.scene).collision_counts[EventKind.BALL_BALL.label] == 0
    fine = Passing("some", 2.0, 0.1, halves=1, phases=2).run(make_engine("pymunk"))
    assert (fine.broken, fine.faults, fine.shots) == (0, (), PHASES)


@pytest.mark.parametrize("label", ["ghostball", "pymunk:contact_steps=exact", "paper-continuous"])
def test_engines_that_look_ahead_have_no_cliff(label):
    verdict = Passing("some", 10.0, 0.01, halves=1, phases=2).run(make_engine(label))
    assert verdict.faults == ()
    ladder = verdict.values.get("ladder", [])
    assert bool(ladder) == (label != "ghostball")
    assert not any(rung["missed"] for rung in ladder)


def test_the_own_step_is_what_the_engine_runs_with():
    scene = passing(0.1, 1.0, 0.01, 0.0)
    assert own_step(make_engine("pymunk"), scene) == pytest.approx(1e-3, rel=1e-2)
    assert own_step(make_engine("pymunk:dt=5e-3"), scene) == 5e-3
    assert own_step(make_engine("paper-continuous:frame=0.01"), scene) == 0.01


def energy_of(scene: Scene, energy: float) -> SceneTrial:
    return SceneTrial("some", scene, EndEnergy(energy))


@pytest.mark.parametrize("shot", [elastic_break, bounces])
def test_a_wrong_energy_breaks_an_engine(shot):
    scene, energy = shot()
    first = simulate(scene, record="trajectory").energy(np.array([0.0])).total[0]
    for off, breaks in ((1e-14, "ghostball"), (2e-3, "pymunk")):
        verdict = energy_of(scene, energy + off * first).run(make_engine(breaks))
        assert "energy at the end is off" in verdict.faults[0]
    # What rounding can't do, an engine that steps may.
    assert energy_of(*elastic_break()).run(make_engine("pymunk")).faults == ()


def test_what_our_engine_may_be_off_by_is_rounding():
    result = simulate(elastic_break()[0], record="trajectory")
    assert len(result.events) < 40
    assert energy_limit(result) == (8 + len(result.events)) * 2.0**-52


@pytest.mark.parametrize("suite", ["quick", "full"])
def test_each_trial_has_examples_to_compile(suite):
    assert all(list(trial.examples()) for trial in FAMILY.trials(suite))


def test_what_cushions_take_is_not_asked_of_engines_without():
    with pytest.raises(UnsupportedSceneError):
        energy_of(*bounces()).run(make_engine("paper-discrete"))
