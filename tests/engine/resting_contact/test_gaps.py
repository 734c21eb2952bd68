"""Tests that held gaps stay closed: a spinning ball pushed into a corner causes no overlap."""

from __future__ import annotations

import math

import pytest
from in_space import instants
from right_shots import broken

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene, Table
from ghostball.validation.stress.common_limits import (
    POSSIBLE,
    SKEW_OF_CONTACTS,
    bounded,
    symmetric,
)

R = 2.0**-5


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_a_ball_that_its_spin_drives_onto_another_in_a_corner_presses_it_symmetrically(friction):
    """Fails if a contact step predicts the change of a gap wrongly."""
    place = R + 2.0 * R / math.sqrt(2.0)
    turns = 3.0 * math.sqrt(0.5) / R  # surface speed of 3 m/s, towards the corner
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
    result = simulate(scene, record="trajectory")
    assert result.work["contact_steps"] > 0
    asked = (*bounded(300, 12_500), *symmetric(2.0 * R * SKEW_OF_CONTACTS))
    assert broken(result, *POSSIBLE, *asked) == []


def test_a_ball_that_its_spin_drives_onto_a_row_at_a_cushion_takes_few_steps():
    """It takes 12 steps; if a step predicted the change of a gap wrongly, it would be halved."""
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
    asked = (*bounded(300, 25), *symmetric(2.0 * R * SKEW_OF_CONTACTS))
    assert broken(simulate(scene, record="trajectory"), *POSSIBLE, *asked) == []


@pytest.mark.parametrize(("ahead", "speed"), [(3e-5, 0.5), (1e-3, 2.0), (3e-3, 2.0)])
def test_a_ball_that_its_spin_drives_into_a_rail_glides_off_its_end(ahead, speed):
    """Fails if a step passes the end of the rail, or if the jaw is hit just before the end."""
    table = Table.model_validate("wpa-9ft")
    radius, end = 0.028575, table.obstacles[0].end[0]  # end of the bottom rail, at the side pocket
    scene = Scene(
        name="glides",
        table=table,
        physics=Physics(motion="sliding", cushion="frictional", cushion_friction=0.2),
        t_max=0.005,
        balls=[
            Ball(
                id="cue",
                position=(end - ahead, radius),
                velocity=(speed, 0.0),
                angular_velocity=(20.0, speed / radius, 0.0),
            )
        ],
    )
    result = simulate(scene, record="trajectory")
    assert result.work["contact_steps"] > 0
    assert broken(result, *POSSIBLE) == []
    assert result.sample(instants(result)).velocities[:, 0, 1].max() <= 1e-11
    assert result.rest_positions[0, 1] < radius
