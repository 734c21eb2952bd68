"""Tests of forces in chains of balls that stick, for which rounds alone converge too slowly."""

import math

import pytest
from shots import R

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene, Status, Table

Y = [0.03186, 0.03033, 0.03043, 0.03025, 0.03108, R, 0.03047, 0.03155, 0.02858, 0.03065, 0.03044]


def chain():
    """Return eleven balls in a tube, closed on the right; the leftmost ball spins and pushes."""
    places = [2.5 - R]
    for to_right, y in zip(Y[:0:-1], Y[-2::-1], strict=True):
        places.append(places[-1] - math.sqrt(4.0 * R * R - (y - to_right) ** 2) - 1e-15)
    balls = [
        Ball(id=f"b{k}", position=(x, y), angular_velocity=(0.0, 0.0, 12.0 if k == 8 else 0.0))
        for k, (x, y) in enumerate(zip(places[::-1], Y, strict=True))
    ]
    moves = {"velocity": (2.37e-4, 8.87e-3), "angular_velocity": (-0.0576, 680.0, 0.0)}
    physics = Physics(
        preset="paper",
        motion="sliding",
        rolling_friction=0.01,
        ball_restitution=0.545,
        ball_friction=0.06,
        cushion="frictional",
        cushion_restitution=0.76,
        cushion_friction=0.0865,
    )
    return Scene(
        name="chain",
        balls=[balls[0].model_copy(update=moves), *balls[1:]],
        table=Table(length=2.5, width=0.060721875),
        physics=physics,
        t_max=0.05,
    )


@pytest.mark.compiled
def test_a_chain_that_sticks_goes_in_steps_as_long_as_its_motion_permits():
    """If forces are extrapolated from one change alone, steps are an eighth as long: 593 steps.

    Random scene 3907 showed this: it took 123 s instead of 5.6 s.
    """
    result = simulate(chain())
    assert result.status is Status.T_MAX
    assert result.work["unsolved_contact_steps"] == 0
    assert result.work["contact_steps"] < 150
