"""The operator of slid banks: mirrors and plain restitution lead where geometry says."""

from __future__ import annotations

from functools import partial

import pytest

from ghostball.engine import simulate
from ghostball.model import Physics
from ghostball.validation.measured import banks
from ghostball.validation.measured.banks import through_point
from ghostball.validation.measured.facts import facts_of
from ghostball.validation.measured.play import OperatorError

PLAY = partial(simulate, record="trajectory")
ROWS = facts_of("banks-pool").rows
SMOOTH = {"motion": "sliding", "sliding_friction": 0.0, "rolling_friction": 0.0}
ACROSS, BEHIND = 48.25 / 12.5, 4.25 / 12.5


@pytest.mark.parametrize("restitution", [1.0, 0.8])
@pytest.mark.parametrize("aim", [0.5, 3.0])
def test_on_smooth_cloth_the_way_back_is_wider_by_the_restitution(aim, restitution):
    law = {"cushion": "restitution", "cushion_restitution": restitution}
    # From the groove at aim + slope * behind, it comes back by slope / restitution * across, to 0.
    slope = aim / (ACROSS / restitution - BEHIND)
    expected = aim + slope * (ACROSS + 2.0 * BEHIND)
    found = through_point(PLAY, Physics(**SMOOTH, **law), aim)
    assert found == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("preset", ["pool", "pool-coulomb"])
def test_two_rounds_find_the_angle_to_a_hundredth_of_a_diamond(preset, monkeypatch):
    found = [through_point(PLAY, Physics(preset=preset), row.at) for row in ROWS]
    monkeypatch.setattr(banks, "_ROUNDS", 6)
    more = [through_point(PLAY, Physics(preset=preset), row.at) for row in ROWS]
    assert found == pytest.approx(more, abs=0.01)


@pytest.mark.parametrize("speed", [3.0, 7.0])
@pytest.mark.parametrize("before", [0.1, 0.4])
def test_a_speed_that_is_not_known_moves_them_by_less_than_tables_differ(speed, before):
    physics = Physics(preset="pool")
    for row in ROWS:
        moved = through_point(PLAY, physics, row.at, speed=speed, before=before)
        assert abs(moved - through_point(PLAY, physics, row.at)) < 0.9 * row.uncertainty


def test_a_ball_that_does_not_come_back_is_said():
    law = {"cushion": "restitution", "cushion_restitution": 0.0}
    with pytest.raises(OperatorError, match=r"doesn't come back across the table within 1\.5 s"):
        through_point(PLAY, Physics(motion="sliding", **law), 1.0)


def test_a_ball_that_comes_back_too_steeply_is_said():
    law = {"cushion": "restitution", "cushion_tangential_restitution": 0.05}
    with pytest.raises(OperatorError, match="so steeply that no line of aim leads"):
        through_point(PLAY, Physics(**SMOOTH, **law), 1.0)
