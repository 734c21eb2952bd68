"""Extremes: the shots are proved, and a wrong answer is seen; what is beyond is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engine import Ball, Physics, Scene, SceneError, simulate
from reference_adapters.certified import certify
from reference_adapters.registry import make_engine
from validation.stress.families.extremes import FAMILY, ICE, bank, cut
from validation.stress.references import (
    ProvedTrial,
    ScaledTrial,
    differences,
    graded,
    near,
    scaled,
)

TRIALS = {trial.name: trial for trial in FAMILY.trials("quick")}


def test_the_quick_suite_is_part_of_the_full_one():
    full = [trial.name for trial in FAMILY.trials("full")]
    assert len(full) == len(set(full))
    assert set(TRIALS) < set(full)


@pytest.mark.compiled
@pytest.mark.parametrize("name", TRIALS)
def test_our_engine_survives(name: str):
    assert TRIALS[name].run(make_engine("ghostball")).faults == ()


def test_what_is_proved_has_a_collision_wherever_a_ball_can_get_to_one():
    """A sweep of empty scenes would ask nothing."""
    for name in ("speed-elastic-1e-09", "radius-ratio-rolling-1e+06", "friction-rolling-10"):
        trial = TRIALS[name]
        assert isinstance(trial, ProvedTrial)
        proof = certify(trial.scene)
        assert proof.proved
        assert proof.events


def test_a_ball_that_is_off_is_seen():
    scene = cut("cut", ICE)
    result, proof = simulate(scene, record="trajectory"), certify(scene, motion=True)
    assert not graded(result, proof).faults
    assert not near(result, proof).faults
    moved = simulate(cut("cut", ICE, speed=2.0 * (1.0 + 1e-12)), record="trajectory")
    assert "quality_factor" in graded(replace(moved, scene=scene), proof).faults[0]
    slower = simulate(cut("cut", ICE, speed=1.9), record="trajectory")
    assert "m off" in near(replace(slower, scene=scene), proof).faults[0]


@pytest.mark.parametrize("physics", [ICE, Physics(preset="pool", ball_friction=0.05)])
def test_a_scaled_shot_is_the_same_to_the_bit_and_an_ulp_is_seen(physics: Physics):
    scene = bank("scaled", physics, t_max=0.4)
    one = simulate(scene, record="trajectory")
    other = simulate(scaled(scene, -11, 30, 5), record="trajectory")
    assert differences(one, other, -11, 30) == []
    state = other.final_state
    off = state._replace(velocities=np.nextafter(state.velocities, np.inf))
    assert differences(one, replace(other, final_state=off), -11, 30)
    assert other.events is not None
    assert differences(one, replace(other, events=other.events[:-1]), -11, 30)


def test_a_law_that_has_a_scale_is_not_scaled():
    with pytest.raises(Exception, match="can't be scaled"):
        scaled(bank("pool", Physics(preset="pool")), 1, 0, 0)


def test_steps_are_not_asked_to_go_on_for_years():
    trial = next(t for t in TRIALS.values() if isinstance(t, ScaledTrial))
    assert trial.time == 30
    with pytest.raises(Exception, match="more than the 2 s"):
        trial.run(make_engine("paper-continuous"))


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"velocity": (1e51, 0.0)}, r"velocity.* must be at most 1e\+50, got 1e\+51"),
        ({"radius": 1e-51}, r"radius.* must be at least 1e-50, got 1e-51"),
        ({"position": (1e14, 0.0)}, r"position` must be known to better than the radius"),
    ],
)
def test_what_is_beyond_is_refused_with_the_field_and_the_rule(fields, message):
    with pytest.raises(SceneError, match=message):
        Scene(name="x", t_max=1.0, balls=[Ball(**({"id": "a", "position": (0.0, 0.0)} | fields))])
