"""Tests of balls that leave the run at an obstacle that takes them out.

They fail if a scheduler or a contact step still includes the ball, or if its energy is kept.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from more_obstacles import Play, played_among
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.engine.core import state as st
from ghostball.engine.event_loop import resolve
from ghostball.engine.library.entry import COMPILED
from ghostball.engine.running import skips
from ghostball.model import EventKind, Phase, Result, Status, event_dict


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch) -> Play:
    """Simulate a scene with more obstacles than its cushions."""
    return partial(played_among, monkeypatch)


@pytest.fixture(params=["all pairs", "cells"])
def either(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run the test with each of the two schedulers."""
    if request.param == "cells":
        monkeypatch.setattr(skips, "MOST_PAIRED", 0)


HOLE = (st.DISC, 0.5, 0.0, 0.0, 0.0, 0.05, st.TAKES_OUT, 4)

WAY = 0.5 - 0.05
"""Distance along x to where the centre of a ball enters the obstacle [m]."""


def gone(result: Result) -> list[tuple[float, int, int]]:
    kept = result.events[result.events["kind"] == EventKind.POCKETED]
    return [(float(t), int(a), int(b)) for t, _, a, b in kept.tolist()]


def test_a_ball_leaves_where_its_centre_enters_with_all_its_energy(played, either):
    still = ball((0.0, 1.0), (0.4, 0.0))
    scene = scene_of(
        ball((0.0, 0.0), (2.0, 0.0), angular_velocity=(0.0, 0.0, 30.0)), still,
        motion="sliding", sliding_friction=0.0, rolling_friction=0.0,
        spinning_friction_rate=0.0, t_max=1.0,
    )  # fmt: skip
    result = played(scene, HOLE)
    ((t, which, at),) = gone(result)
    assert (which, at) == (0, 4)
    assert t == pytest.approx(WAY / 2.0, rel=1e-12)
    assert result.rest_positions[0, :2] == pytest.approx([WAY, 0.0], abs=1e-12)
    before, after = result.sample([0.5 * t, 0.9]), result.sample([0.9])
    assert before.angular_velocities[0, 0, 2] == 30.0
    assert not np.any(after.velocities[0, 0])
    assert not np.any(after.angular_velocities[0, 0])
    assert result.phases([0.0, 0.9])[:, 0].tolist() == [Phase.SLIDING, Phase.GONE]
    alone = simulate(scene_of(still, **scene.physics.model_dump(), t_max=1.0), record="trajectory")
    assert result.energy([0.9]).total == pytest.approx(alone.energy([0.9]).total)
    assert result.work["balls_gone"] == 1
    assert event_dict(result.events[-1])["b"] == "top"
    assert np.all(np.isfinite(result.sensitivity([0.9])[:, 0]))


def test_no_ball_meets_one_that_is_gone(played, either):
    """One ball moves along the same path into the hole; another crosses where the first left."""
    across = ball((WAY - R, -1.0), (0.0, 1.2))
    balls = [ball((0.0, 0.0), (2.0, 0.0)), ball((-0.5, 0.0), (2.0, 0.0)), across]
    result = played(scene_of(*balls, rolling_friction=0.0, t_max=1.0), HOLE)
    assert [which for _, which, _ in gone(result)] == [0, 1]
    assert result.collision_counts == {"ball-ball": 0, "ball-cushion": 0}
    assert result.rest_positions[2, :2] == pytest.approx([WAY - R, 0.2], abs=1e-9)
    assert result.status is Status.T_MAX


def test_a_ball_in_a_line_of_touching_ones_leaves_without_the_others(played, either):
    """The balls are pushed over a line that takes them out, one after the other."""
    line = (st.LINE, 0.5, 0.0, -1.0, 0.0, 0.0, st.TAKES_OUT, 4)
    row = [ball((2.0 * R * k, 0.0)) for k in range(3)]
    shot = [*row, ball((-0.3, 0.0), (2.0, 0.0))]
    result = played(
        scene_of(*shot, motion="sliding", ball_restitution=0.2, rolling_friction=0.01), line
    )
    left = [which for _, which, _ in gone(result)]
    assert left[0] == 2
    assert result.status is Status.REST
    inside = [k for k in range(4) if k not in left]
    assert all(result.rest_positions[k, 0] < 0.5 - R for k in inside)
    assert all(result.rest_positions[k, 0] == pytest.approx(0.5 - R, abs=1e-9) for k in left)


@pytest.mark.skipif(COMPILED, reason="compiled kernels can't be replaced")
def test_a_collapse_leaves_no_pair_of_its_cluster_to_collide(monkeypatch):
    """Two pairs are due at once. One collapses, which ends the approach of the other, too."""
    listed = []
    whole = resolve._end_collapses
    monkeypatch.setattr(resolve, "_collapses", lambda world, c: c == 0)

    def noted(world, count, t):
        left = whole(world, count, t)
        listed.append((count, left))
        return left

    monkeypatch.setattr(resolve, "_end_collapses", noted)
    scene = scene_of(
        ball((0.5, 0.5), (1.0, 0.0)),
        ball((0.7, 0.5 + R), (0.0, 0.0)),
        ball((0.7, 0.5 - R), (0.0, 0.0)),
        ball_restitution=0.5, ball_friction=0.0, t_max=0.3,
    )  # fmt: skip
    result = simulate(scene)
    assert listed[0] == (2, 0)
    assert result.collision_counts["ball-ball"] == 2
