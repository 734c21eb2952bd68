"""Tests of the cells of the broad phase: how often balls change cells."""

import numpy as np
import pytest
from shots import POOL_TABLE, ball, scene_of

from ghostball.engine import simulate
from ghostball.engine.running import skips
from ghostball.engine.running.from_scene import cells_of
from ghostball.model import Status


@pytest.fixture(autouse=True)
def _cells_for_all(monkeypatch):
    monkeypatch.setattr(skips, "MOST_PAIRED", 0)


@pytest.mark.parametrize("bend", [0.0, 9e-14, -9e-14], ids=["straight", "back", "away"])
@pytest.mark.parametrize("across", [-1e-33, 0.0, 1e-33])
def test_a_ball_along_the_side_of_a_cell_does_not_change_cells_without_end(bend, across):
    """Rounding puts the ball in either of two adjacent cells."""
    along = ball((1.27, 0.3), (across, 1.0), angular_velocity=(0.0, bend, 0.0))
    result = simulate(
        scene_of(along, table=POOL_TABLE, preset="pool", rolling_friction=0.1), max_work=100_000
    )
    assert result.status is Status.REST
    assert result.work["cell_moves"] <= 1


def test_a_ball_changes_cells_as_often_as_it_crosses_their_sides():
    balls = [ball((x, y)) for x in np.arange(0.1, 2.4, 0.4) for y in (0.1, 1.1)]
    rolls = ball((0.05, 0.6), (2.0, 0.0))
    scene = scene_of(rolls, *balls, table=POOL_TABLE, rolling_friction=0.0, t_max=2.0)
    columns, _ = cells_of(scene).size
    assert simulate(scene).work["cell_moves"] == 2 * (columns - 1)  # to the cushion, and back
