"""Tests of the collision times of touching balls: rounding errors of their speeds cause no impact.

The rows consist of balls that touch exactly and don't bounce. Each impact passes half of the
approach speed on to the next contact, so only rounding ends the series.
"""

from __future__ import annotations

import pytest

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene, Status, Table

RADIUS = 2.0**-5
"""With this value all positions and all gaps are exact [m]."""

SPEED = 0.5
"""Speed of the ball that pushes the row [m/s]."""


def pushed(count: int, x: float, along: float, table: Table | None = None, **physics) -> Scene:
    """Return a row of balls from x [m] on, in which the first ball pushes the others."""
    return Scene(
        name="row",
        table=table,
        t_max=1.0,
        physics=Physics(
            motion="sliding",
            rolling_friction=0.0,
            sliding_friction=0.0,
            spinning_friction_rate=0.0,
            ball_restitution=0.0,
            ball_friction=0.0,
            **physics,
        ),
        balls=[
            Ball(
                id=f"b{k}",
                position=(x + 2.0 * RADIUS * along * k, 0.25),
                radius=RADIUS,
                velocity=(0.0 if k else SPEED * along, 0.0),
            )
            for k in range(count)
        ],
    )


@pytest.mark.parametrize(("count", "restitution"), [(3, 1.0), (4, 0.5)])
def test_a_row_without_bounce_pushed_into_a_cushion_comes_to_an_end(count, restitution):
    """The speed was once halved at one time until the product of two speeds underflowed."""
    table = Table(length=1.0, width=0.5)
    physics = {"cushion": "restitution", "cushion_restitution": restitution}
    scene = pushed(count, 1.0 - RADIUS * (2 * count - 1), 1.0, table, **physics)
    result = simulate(scene, record="events")
    assert result.status is Status.T_MAX, result.reason
    assert result.work["unsolved_joint_impacts"] == 0
    assert len(result.events) < 1000
    assert abs(result.final_state.velocities).max() <= 1e-14 * SPEED


@pytest.mark.parametrize("along", [1.0, -1.0])
def test_a_row_without_bounce_goes_on_together_in_air(along):
    """Contacts that approached by rounding, or didn't, once ended each other's steps endlessly."""
    result = simulate(pushed(6, 0.3, along, air_drag=0.1), record="events")
    assert result.status is Status.T_MAX, result.reason
    velocities = result.final_state.velocities[0]
    assert velocities[:, 0] == pytest.approx(velocities[0, 0], rel=1e-12)
    assert 0.0 < along * velocities[0, 0] < SPEED / 6.0
    assert result.work["contact_steps"] < 100
