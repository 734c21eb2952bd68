"""A gap that is held stays closed: what a spinning ball pushes into a corner overlaps nothing."""

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


def test_a_ball_that_its_spin_drives_onto_a_row_at_a_cushion_takes_few_steps():
    """It takes 12; a step that takes a gap to change otherwise than it does is cut again."""
    physics = Physics(
        motion="sliding",
        rolling_friction=0.01,
        ball_restitution=1.0,
        ball_friction=0.06,
        cushion="frictional",
        cushion_restitution=1.0,
    )
    scene = Scene(
        name="squeezed",
        physics=physics,
        table=Table(length=2.0, width=2.0, cushions=("left",)),
        t_max=0.125,
        balls=[
            Ball(id="a", radius=R, position=(5.0 * R, 0.0), angular_velocity=(0.0, -3.0 / R, 0.0)),
            Ball(id="b", radius=R, position=(R, 0.0)),
            Ball(id="c", radius=R, position=(3.0 * R, 0.0)),
        ],
    )
    kept = Invariants(most_events=300, most_steps=25, images=(0, 1, 2))
    assert kept(simulate(scene, record="trajectory")).faults == ()
