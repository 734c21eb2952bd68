"""Tests of balls that come to rest on other balls or on noses, and move again when they are hit.

They fail for endless bounces, for a ball that is held although it would fall, and for a ball that
stays in the air.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from in_space import energies_around_events
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.engine.core.tolerances import LOWEST_BOUNCE
from ghostball.model import Status, Table

FLIES: dict[str, Any] = {"preset": "pool", "airborne": True}
H = 0.0357
"""Height of a nose of that preset [m]."""


def test_a_ball_on_one_that_cannot_yield_falls_off() -> None:
    """Fails if bounces reduce the slip of a ball that hardly moves, so that it stays on top."""
    reach = math.sqrt(H * (2.0 * R - H))
    below, above = ball((reach, reach)), ball((reach, reach, 3.0 * R + 1e-6), (0.0, 0.0, 0.0))
    scene = scene_of(below, above, table=Table(length=1.2, width=0.7), **FLIES)
    result = simulate(scene, max_events=100_000)
    assert result.status is Status.REST
    assert math.dist(*result.rest_positions[:, :2].tolist()) > R  # beyond the cushions


@pytest.mark.compiled
def test_a_ball_on_three_that_a_box_holds_comes_to_rest_there() -> None:
    side, reach = 2.0 * R, math.sqrt(H * (2.0 * R - H))
    depth = math.sqrt(0.75) * side
    x, y = reach + side / 2.0, reach
    scene = scene_of(
        ball((reach, y)),
        ball((reach + side, y)),
        ball((x, y + depth)),
        ball((x, y + depth / 3.0, R + side * math.sqrt(2.0 / 3.0)), (0.0, 0.0, 0.0)),
        table=Table(length=2.0 * reach + side, width=2.0 * reach + depth),
        **FLIES,
    )
    result = simulate(scene, record="trajectory", max_events=200_000)
    assert result.status is Status.REST
    assert result.rest_positions[3, 2] > 2.5 * R
    energy = energies_around_events(result)
    assert np.diff(energy).max() <= 1e-13 * energy[0]


def test_bounces_are_kept_up_by_the_slip() -> None:
    """Fails if a ball on others bounces ever lower, thousands of times in a tenth of a second.

    One ball is in a corner; another falls on it from the side of the cushions.
    """
    reach = math.sqrt(H * (2.0 * R - H))
    scene = scene_of(
        ball((reach, reach)),
        ball((reach + 2.0 * R, reach)),
        ball((reach + R, reach + 0.8 * R, 3.2 * R), (0.0, 0.0, 0.0)),
        table=Table(length=2.54, width=1.27),
        ball_restitution=0.0,
        **FLIES,
    )
    result = simulate(scene, record="trajectory", max_events=20_000)
    assert result.status is Status.REST
    assert result.work["events"] < 2_000
    energy = energies_around_events(result)
    assert np.diff(energy).max() <= 1e-13 * energy[0]
    places = result.sample(np.unique(result.events["t"])).positions
    distance = min(
        np.linalg.norm(places[:, i] - places[:, j], axis=1).min()
        for i in range(3)
        for j in range(i)
    )
    assert distance > 2.0 * R * (1.0 - 4.0 * LOWEST_BOUNCE)
