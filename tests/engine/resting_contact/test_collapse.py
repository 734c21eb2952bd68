"""Tests of inelastic collapse: balls with endless impacts in a finite time end in contact.

They fail for endless impacts at one time, for balls that pass each other, and for a gain of energy
or momentum.
"""

from __future__ import annotations

import random

import numpy as np
import pytest
from shots import ball, scene_of

from ghostball.engine import simulate
from ghostball.model import Scene, Status, Table

RADIUS = 0.01


def gas(
    count: int, restitution: float, seed: int, size: float = 0.25, t_max: float = 10.0
) -> Scene:
    """Return balls in a square box, slowed only by their impacts."""
    rng = random.Random(seed)
    places: list[tuple[float, float]] = []
    while len(places) < count:
        x, y = (rng.uniform(RADIUS, size - RADIUS) for _ in range(2))
        if all((x - a) ** 2 + (y - b) ** 2 > 4.04 * RADIUS**2 for a, b in places):
            places.append((x, y))
    balls = [ball(place, (rng.gauss(), rng.gauss()), radius=RADIUS) for place in places]
    return scene_of(
        *balls, table=Table(length=size, width=size), rolling_friction=0.0,
        ball_restitution=restitution, cushion="restitution", cushion_restitution=0.5, t_max=t_max,
    )  # fmt: skip


def least_gap(positions: np.ndarray) -> float:
    """Return the smallest gap between two balls [m]."""
    apart = positions[:, None, :2] - positions[None, :, :2]
    distance = np.hypot(apart[..., 0], apart[..., 1])
    return float(distance[np.triu_indices(len(positions), 1)].min()) - 2.0 * RADIUS


@pytest.mark.parametrize(
    ("count", "restitution", "seed", "collapses"),
    [(20, 0.0, 2, True), (20, 0.2, 1, True), (40, 0.5, 3, False)],
)
def test_an_inelastic_gas_reaches_its_end(count, restitution, seed, collapses):
    result = simulate(gas(count, restitution, seed), record="events", max_work=5 * 10**6)
    assert result.status is Status.T_MAX
    # A collapse counts as a joint impact, and no joint impact is unsolved.
    assert (result.work["joint_impacts"] > 0) == collapses
    assert result.work["unsolved_joint_impacts"] == 0
    times = np.linspace(0.0, 10.0, 201)
    energy = result.energy(times).total
    assert np.all(np.diff(energy) <= 1e-12 * energy[0])
    positions = result.sample(times).positions
    assert min(least_gap(at) for at in positions) > -4e-13


def test_nine_balls_that_fill_a_box_from_wall_to_wall_come_to_rest():
    """Four balls in a row fill the box; one of them, slightly off, would enter endlessly."""
    places = [
        ((0.021418, 0.023333), (0.9578, -0.1998)), ((0.030483, 0.081041), (0.0243, 1.5458)),
        ((0.021526, 0.132486), (0.5451, -0.5052)), ((0.079735, 0.022357), (-0.1828, 0.5405)),
        ((0.082971, 0.075107), (1.9351, -0.2696)), ((0.078622, 0.133545), (-0.2436, 1.0023)),
        ((0.132455, 0.027766), (-0.8865, -0.2917)), ((0.136346, 0.085779), (0.8825, 0.5804)),
        ((0.1306, 0.135215), (0.0915, 0.6701)),
    ]  # fmt: skip
    scene = scene_of(
        *(ball(place, velocity, radius=0.02) for place, velocity in places),
        table=Table(length=0.16, width=0.16), rolling_friction=0.0, ball_restitution=0.5,
        cushion="restitution", cushion_restitution=0.0, t_max=20.0,
    )  # fmt: skip
    result = simulate(scene, max_work=10**6)
    assert result.status is Status.T_MAX
    assert np.abs(result.final_state.velocities).max() < 1e-12


@pytest.mark.compiled
@pytest.mark.slow
def test_hundreds_of_balls_that_collapse_reach_their_end():
    scene = gas(400, 0.2, 5, size=0.8, t_max=50.0)
    result = simulate(scene, max_work=2 * 10**9)
    assert result.status is Status.T_MAX
    assert least_gap(result.rest_positions) > -4e-13
