"""Noses and holes that no table has yet: a row each, met at the instant that the closed form says.

A ball leaves the run at an obstacle that takes it out. That is broken by a scheduler or a contact
step that still sees the ball, or by an energy that stays.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from more_obstacles import add_obstacles
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.engine.core import state as st
from ghostball.engine.running import skips
from ghostball.model import (
    EventKind,
    Phase,
    Result,
    Scene,
    Status,
    Table,
    UnsupportedSceneError,
    event_dict,
)

MIRROR = 0.0


Play = Callable[..., Result]


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch) -> Play:
    """Play a scene with more obstacles than its cushions."""

    def play(scene: Scene, *rows: Sequence[float]) -> Result:
        add_obstacles(monkeypatch, *rows)
        return simulate(scene, record="trajectory")

    return play


@pytest.fixture(params=["all pairs", "cells"])
def either(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let either scheduler play."""
    if request.param == "cells":
        monkeypatch.setattr(skips, "MOST_PAIRED", 0)


def cushion_collisions(result: Result) -> list[tuple[float, int]]:
    assert result.events is not None
    kept = result.events[result.events["kind"] == EventKind.BALL_CUSHION]
    return [(float(event["t"]), int(event["b"])) for event in kept]


@pytest.mark.parametrize("slowing", [0.0, 0.02])
@pytest.mark.parametrize("offset", [0.0, 0.3, 0.9, 0.999])
def test_a_ball_bounces_off_a_circular_nose(played: Play, offset: float, slowing: float) -> None:
    """It goes along x, and touches where the centres are the radii apart; mirrored there."""
    nose, speed, far = 0.05, 1.5, 0.8
    reach = R + nose
    height = offset * reach
    scene = scene_of(ball((0.0, 0.0), (speed, 0.0)), t_max=1.0, rolling_friction=slowing)
    result = played(scene, (st.DISC, far, -height, 0.0, 0.0, nose, MIRROR, 4))
    way = far - math.sqrt(reach * reach - height * height)
    a = slowing * scene.physics.gravity
    contact = 2.0 * way / (speed + math.sqrt(speed * speed - 2.0 * a * way))
    ((t, index),) = cushion_collisions(result)
    assert index == 4
    # At a grazing collision the instant errs by what rounding of the gap does to it.
    assert t == pytest.approx(contact, rel=1e-14 / (1.0 - offset * offset))
    before = speed - a * contact
    nx, ny = (way - far) / reach, height / reach
    after = result.sample([np.nextafter(t, 2.0)]).velocities[0, 0, :2]
    along = before * nx
    want = np.array([before - 2.0 * along * nx, -2.0 * along * ny])
    assert after == pytest.approx(want, abs=1e-10)


def test_a_ball_that_passes_a_circular_nose_misses_it(played: Play) -> None:
    scene = scene_of(ball((0.0, 0.0), (1.5, 0.0)), t_max=1.0)
    near = (R + 0.05) * (1.0 + 1e-9)
    assert cushion_collisions(played(scene, (st.DISC, 0.8, near, 0.0, 0.0, 0.05, MIRROR, 4))) == []


def test_a_ball_bounces_off_a_segment_and_off_its_end(played: Play) -> None:
    wall = (st.SEGMENT, 0.5, -0.2, 0.5, 0.2, 0.0, MIRROR, 4)
    scene = scene_of(ball((0.0, 0.0), (1.0, 0.0)), rolling_friction=0.0, t_max=1.0)
    ((t, _),) = cushion_collisions(played(scene, wall))
    assert t == pytest.approx(0.5 - R, rel=1e-15)
    beside = scene_of(ball((0.0, 0.2 + 0.5 * R), (1.0, 0.0)), rolling_friction=0.0, t_max=1.0)
    ((t, _),) = cushion_collisions(played(beside, wall))
    assert t == pytest.approx(0.5 - R * math.sqrt(0.75), rel=1e-14)


def test_a_line_aslant_is_a_row_too(played: Play) -> None:
    nx, ny = -0.6, 0.8
    scene = scene_of(ball((0.0, 0.0), (1.0, 0.0)), rolling_friction=0.0, t_max=2.0)
    result = played(scene, (st.LINE, 0.6, 0.0, nx, ny, 0.0, MIRROR, 4))
    ((t, _),) = cushion_collisions(result)
    assert t == pytest.approx(0.6 - R / 0.6, rel=1e-15)
    velocity = result.sample([t]).velocities[0, 0, :2]
    assert velocity == pytest.approx([1.0 - 2.0 * 0.36, 2.0 * 0.48], abs=1e-15)


def test_many_balls_among_circular_noses_keep_energy_and_distance(played: Play) -> None:
    """A Sinai billiard: three balls without friction, on a table with a disc in its middle."""
    balls = [ball((0.2 + 0.2 * k, 0.15), (0.3 - 0.2 * k, 0.9), id=f"b{k}") for k in range(3)]
    scene = scene_of(*balls, table=Table(length=1.0, width=1.0), rolling_friction=0.0, t_max=20.0)
    result = played(scene, (st.DISC, 0.5, 0.55, 0.0, 0.0, 0.12, MIRROR, 4))
    assert sum(index == 4 for _, index in cushion_collisions(result)) > 5
    times = np.linspace(0.0, 20.0, 4001)
    energy = result.energy(times).total
    assert np.ptp(energy) <= 1e-12 * energy[0]
    away = np.linalg.norm(result.sample(times).positions[:, :, :2] - (0.5, 0.55), axis=2)
    assert away.min() >= (R + 0.12) * (1.0 - 1e-12)


def test_more_obstacles_than_bits_are_refused(played: Play) -> None:
    """Breaks where one is let through: a contact step would hold balls off another one."""
    disc = (st.DISC, 50.0, 50.0, 0.0, 0.0, 0.01, MIRROR, 4)
    scene = scene_of(ball((0.0, 0.0), (1.0, 0.0)), rolling_friction=0.1)
    assert played(scene, *[disc] * st.MOST_OBSTACLES).status is Status.REST
    scene = scene.model_copy()
    with pytest.raises(UnsupportedSceneError, match="no more than 53 obstacles on one table, here"):
        played(scene, *[disc] * (st.MOST_OBSTACLES + 1))


# --- balls that are gone

HOLE = (st.DISC, 0.5, 0.0, 0.0, 0.0, 0.05, st.TAKES_OUT, 4)
WAY = 0.5 - 0.05
"""To where the centre of a ball that comes along x enters it [m]."""


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
    """One comes the same way, into the hole too; another passes where the first left the run."""
    across = ball((WAY - R, -1.0), (0.0, 1.2))
    balls = [ball((0.0, 0.0), (2.0, 0.0)), ball((-0.5, 0.0), (2.0, 0.0)), across]
    result = played(scene_of(*balls, rolling_friction=0.0, t_max=1.0), HOLE)
    assert [which for _, which, _ in gone(result)] == [0, 1]
    assert result.collision_counts == {"ball-ball": 0, "ball-cushion": 0}
    assert result.rest_positions[2, :2] == pytest.approx([WAY - R, 0.2], abs=1e-9)
    assert result.status is Status.T_MAX


def test_a_ball_in_a_line_of_touching_ones_leaves_without_the_others(played, either):
    """They are pushed over a line that takes them out, the first of them first."""
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
