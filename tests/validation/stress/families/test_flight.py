"""The family of flight: its judges see what they are for."""

from dataclasses import replace

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Result, Scene, Table
from ghostball.validation.stress import invariants
from ghostball.validation.stress.families.flight import (
    Lands,
    R,
    endless,
    on_top,
    over_the_top,
)
from ghostball.validation.stress.invariants import instants, measured
from ghostball.validation.stress.judges import Invariants


def test_a_clip_of_the_top_is_no_miss():
    for depth in (1e-3, -1e-3):
        result = simulate(over_the_top(depth, 0.3), record="trajectory")
        assert Invariants(meets=depth > 0.0)(result).faults == ()
        fault = Invariants(meets=depth < 0.0)(result).faults[0]
        assert ("that don't" if depth > 0.0 else "goes through") in fault


def test_what_overlaps_in_space_is_seen(monkeypatch):
    result = simulate(on_top(1.5, 0.0, 0.1), record="trajectory")
    assert Invariants()(result).faults == ()
    monkeypatch.setattr(invariants, "BOUNCE_SLOP", -1e-3)
    assert "overlap of balls" in Invariants()(result).faults[0]


@pytest.mark.parametrize(
    ("name", "raised"),
    [
        ("depth in the table", (0, 0, -1e-6)),
        ("height of a ball at rest", (0, 0, 1e-6)),
        ("overlap of ball and nose", (-1e-6, 0, 0)),
    ],
)
def test_what_is_in_the_table_over_it_or_in_a_nose_is_seen(monkeypatch, name, raised):
    """The ball leans on the left nose at the end."""
    scene = Scene(
        name="leans",
        table=Table(length=1.0, width=1.0),
        physics=Physics(preset="pool", airborne=True, cushion_height=R),
        balls=[Ball(id="cue", position=(R, 0.5))],
    )
    result = simulate(scene, record="trajectory")
    assert Invariants()(result).faults == ()
    sample = Result.sample

    def moved(self, times):
        states = sample(self, times)
        return states._replace(positions=states.positions + np.array(raised))

    monkeypatch.setattr(Result, "sample", moved)
    assert any(name in fault for fault in Invariants()(result).faults)


def test_energy_from_nowhere_and_steps_left_unsolved_are_seen():
    result = simulate(on_top(0.5, 0.95, 0.1), record="trajectory")
    found = measured(result, instants(result))
    energy = found["rise of the energy [1]"]
    assert energy[0] <= energy[1] < 1e-6
    unsolved = replace(result, work={**result.work, "unsolved_joint_impacts": 1})
    assert "left unsolved" in Invariants()(unsolved).faults[0]


def test_bounces_that_end_late_are_seen():
    scene = endless(2, 0.6, 0.1)
    result = simulate(scene, record="trajectory")
    ends = 0.57113724917082579
    assert Lands(ends)(result).faults == ()
    assert "off by" in Lands(1.0000001 * ends)(result).faults[0]
    # So is one that never lands.
    never = simulate(scene.model_copy(update={"t_max": 1e-3}), record="trajectory")
    assert "off by" in Lands(ends)(never).faults[0]
