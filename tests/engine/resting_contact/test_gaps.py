"""A gap that is held stays closed: what a spinning ball presses into a corner overlaps nothing."""

from __future__ import annotations

import math

import pytest

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene, Table
from ghostball.validation.stress.judges import Invariants

R = 2.0**-5


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_a_ball_that_its_spin_drives_onto_another_in_a_corner_presses_it_symmetrically(friction):
    """Breaks where a contact step takes a gap to change otherwise than it does."""
    place = R + 2.0 * R / math.sqrt(2.0)
    turns = 3.0 * math.sqrt(0.5) / R  # 3 m/s of its surface, towards the corner
    scene = Scene(
        name="cornered",
        physics=Physics(
            motion="sliding",
            rolling_friction=0.01,
            ball_restitution=0.5,
            ball_friction=friction,
            cushion="frictional",
            cushion_restitution=0.85,
        ),
        table=Table(length=2.0, width=2.0),
        t_max=0.125,
        balls=[
            Ball(id="a", radius=R, position=(place, place), angular_velocity=(turns, -turns, 0.0)),
            Ball(id="b", radius=R, position=(R, R)),
        ],
    )
    kept = Invariants(most_events=300, most_steps=12_500, images=(0, 1), swapped=True)
    result = simulate(scene, record="trajectory")
    assert result.work["contact_steps"] > 0
    assert kept(result).faults == ()
