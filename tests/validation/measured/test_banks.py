"""The operator of slid banks: mirrors and plain restitution lead where geometry says."""

from __future__ import annotations

from functools import partial

import pytest

from ghostball.engine import simulate
from ghostball.model import Physics
from ghostball.validation.measured.banks import through_points
from ghostball.validation.measured.facts import facts_of
from ghostball.validation.measured.play import OperatorError

PLAY = partial(simulate, record="trajectory")
ROWS = facts_of("banks-pool").rows
AIMS = [row.at for row in ROWS]
SMOOTH = {"motion": "sliding", "sliding_friction": 0.0, "rolling_friction": 0.0}
ACROSS, BEHIND = 48.25 / 12.5, 4.25 / 12.5


@pytest.mark.parametrize("restitution", [1.0, 0.8])
def test_on_smooth_cloth_the_way_back_is_wider_by_the_restitution(restitution):
    law = {"cushion": "restitution", "cushion_restitution": restitution}
    for aim, found in zip(AIMS, through_points(PLAY, Physics(**SMOOTH, **law), AIMS), strict=True):
        # From the groove at aim + slope * behind, it comes back by slope / restitution * across.
        slope = aim / (ACROSS / restitution - BEHIND)
        assert found == pytest.approx(aim + slope * (ACROSS + 2.0 * BEHIND), rel=1e-6)


@pytest.mark.parametrize("preset", ["pool", "pool-coulomb"])
def test_one_aim_leads_to_the_next_to_a_hundredth_of_a_diamond(preset):
    found = through_points(PLAY, Physics(preset=preset), AIMS)
    alone = [through_points(PLAY, Physics(preset=preset), [aim] * 4)[-1] for aim in AIMS]
    assert found == pytest.approx(alone, abs=0.01)


@pytest.mark.parametrize(("speed", "before"), [(3.0, 0.2), (7.0, 0.2), (4.0, 0.1), (4.0, 0.4)])
def test_a_speed_that_is_not_known_moves_them_by_less_than_tables_differ(speed, before):
    physics = Physics(preset="pool")
    usual = through_points(PLAY, physics, AIMS)
    moved = through_points(PLAY, physics, AIMS, speed=speed, before=before)
    for row, one, other in zip(ROWS, usual, moved, strict=True):
        assert abs(one - other) < 0.8 * row.uncertainty


def test_a_ball_that_does_not_come_back_is_said():
    law = {"cushion": "restitution", "cushion_restitution": 0.0}
    with pytest.raises(OperatorError, match="a bank doesn't come back across the table"):
        through_points(PLAY, Physics(motion="sliding", **law), [1.0])


def test_a_ball_that_comes_back_too_steeply_is_said():
    law = {"cushion": "restitution", "cushion_tangential_restitution": 0.05}
    with pytest.raises(OperatorError, match="so steeply that no line of aim leads"):
        through_points(PLAY, Physics(**SMOOTH, **law), [1.0])
