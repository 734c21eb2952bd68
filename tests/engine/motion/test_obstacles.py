"""Noses that no table has yet: a row each, met at the instant that the closed form says."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest
from more_obstacles import Play, played_among
from shots import R, ball, scene_of

from ghostball.engine.core import state as st
from ghostball.model import EventKind, Result, Table

MIRROR = 0.0


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch) -> Play:
    """Play a scene with more obstacles than its cushions."""
    return partial(played_among, monkeypatch)


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
