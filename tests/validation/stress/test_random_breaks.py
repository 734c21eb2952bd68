"""Random breaks: each from its number alone, and of all physics."""

from __future__ import annotations

import numpy as np

from ghostball.model import Scene
from ghostball.validation.stress.invariants import overlaps
from ghostball.validation.stress.random_breaks import FASTEST, MOST_BALLS, SLOWEST, random_break

SOME = [random_break(number) for number in range(400)]


def test_a_break_is_made_of_its_number_alone():
    again = [random_break(number) for number in reversed(range(20))]
    assert again[::-1] == SOME[:20]
    assert len({scene.model_dump_json() for scene in SOME}) == len(SOME)


def test_every_law_and_every_number_of_balls_comes_round():
    def seen(field):
        return {getattr(scene.physics, field) for scene in SOME}

    assert seen("motion") == {"rolling", "sliding"}
    assert seen("impacts") == {"simultaneous", "sequential"}
    assert seen("ball_impact") == {"frictional", "mathavan2014"}
    assert seen("cushion") == {"mirror", "restitution", "frictional", "han2005", "mathavan2010"}
    assert {1.0, 0.98, 0.95, 0.9} < seen("ball_restitution")
    assert {0.0, 0.06, "alciatore"} < seen("ball_friction")
    assert {len(scene.balls) for scene in SOME} == set(range(2, MOST_BALLS + 1))


def test_speeds_spins_and_gaps_cover_what_is_said():
    speeds = [scene.balls[0].speed for scene in SOME]
    assert SLOWEST <= min(speeds) < 2.0 * SLOWEST
    assert 0.5 * FASTEST < max(speeds) <= FASTEST
    gaps = [_least_gap(scene) for scene in SOME]
    assert sum(abs(gap) < 1e-12 for gap in gaps) > 40  # frozen racks
    assert sum(1e-9 < gap < 1e-3 for gap in gaps) > 40
    assert sum(scene.balls[0].angular_velocity is not None for scene in SOME) > 100
    assert sum(len({ball.radius for ball in scene.balls}) > 1 for scene in SOME) > 40


def _least_gap(scene: Scene) -> float:
    return -float(np.max(overlaps(scene, scene.positions[np.newaxis])[:, 0]))
