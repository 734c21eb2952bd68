"""Tests of simultaneous impacts of one ball with two balls, by closed forms; none is certified."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene

NORMALS = {
    "uneven": ((24.0 / 25.0, 7.0 / 25.0), (3.0 / 5.0, -4.0 / 5.0)),
    "symmetric": ((4.0 / 5.0, 3.0 / 5.0), (4.0 / 5.0, -3.0 / 5.0)),
}
"""Directions in which a ball moving along x touches two balls, which don't touch each other.

All positions are exact: whole multiples of 1/25 of the distance.
"""

UNIT = 2.0**-9
"""1/25 of the distance [m]."""

ROUNDING = 1e-14
"""Permitted rounding error of a velocity after simultaneous impacts, in units of the speed."""


def tie(kind: str, impacts: str, restitution: float) -> Scene:
    """Return a ball that collides with two balls at the very start of a shot."""
    places = [
        (0.0, 0.0),
        *((UNIT * round(25 * x), UNIT * round(25 * y)) for x, y in NORMALS[kind]),
    ]
    velocities = ((1.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    return Scene(
        name="tie",
        physics=Physics(rolling_friction=0.0, ball_restitution=restitution, impacts=impacts),
        t_max=0.01,
        balls=[
            Ball(id=name, position=place, velocity=velocity, radius=12.5 * UNIT)
            for name, place, velocity in zip(
                ("cue", "first", "second"), places, velocities, strict=True
            )
        ],
    )


def velocities_after(kind: str, impacts: str, restitution: float) -> np.ndarray:
    """Return the velocities of the three balls, (3, 2) [m/s].

    Sequential impacts are ordered by approach speed and, if equal, by position. The first impact
    gives its ball (1 + e) / 2 of the approach speed. After both impacts, the cue ball may approach
    the first ball again. Simultaneous impacts have (1 + e) times the impulses that just end both
    approaches: 2 p + c q = a, c p + 2 q = b, where c is the cosine between the normals.
    """
    normals = np.array(NORMALS[kind])
    velocities = np.array([[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]])

    def push(k: int, by: float) -> None:
        velocities[0] -= by * normals[k]
        velocities[1 + k] += by * normals[k]

    if impacts == "simultaneous":
        a, b = normals[:, 0].tolist()
        c = float(normals[0] @ normals[1])
        push(0, (1.0 + restitution) * (2.0 * a - c * b) / (4.0 - c * c))
        push(1, (1.0 + restitution) * (2.0 * b - c * a) / (4.0 - c * c))
        return velocities
    order = (0, 1) if normals[0, 0] >= normals[1, 0] else (1, 0)
    for k in order * 20:
        approach = float(normals[k] @ (velocities[0] - velocities[1 + k]))
        if approach > ROUNDING:
            push(k, 0.5 * (1.0 + restitution) * approach)
    return velocities


@pytest.mark.parametrize("restitution", [1.0, 0.95, 0.8, 0.5, 0.2])
@pytest.mark.parametrize(
    ("kind", "impacts"),
    list(product(NORMALS, ("sequential", "simultaneous"))),
    ids=lambda word: word,
)
def test_impacts_at_one_instant_come_out_as_their_closed_forms(kind, impacts, restitution):
    wanted = velocities_after(kind, impacts, restitution)
    assert np.allclose(wanted.sum(axis=0), (1.0, 0.0), rtol=0.0, atol=1e-15)
    energy = float(np.sum(wanted**2))
    assert math.isclose(energy, 1.0, rel_tol=1e-14) if restitution == 1.0 else energy < 1.0
    found = simulate(tie(kind, impacts, restitution)).final_state.velocities[0, :, :2]
    assert np.max(np.abs(found - wanted)) <= ROUNDING
