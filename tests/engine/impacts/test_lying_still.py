"""Tests of balls that lie on noses or on other balls: which stay, how long, and which fall off."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from in_space import energies_around_events
from kernels import if_compiled
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.engine.core.kernel import COMPILED
from ghostball.engine.core.tolerances import CAPTURE_HEIGHT
from ghostball.engine.impacts import lying_still
from ghostball.model import EventKind, Scene, Status, Table

G = 9.81
FLIES: dict[str, Any] = {"preset": "pool", "airborne": True}

NARROW = Table(length=1.27, width=1.4 * R)
"""A table whose noses are so close that a ball lies on both."""

H = 0.0357
"""Height of a nose of that preset [m]."""

LIES = H - R + math.sqrt(R * R - (0.7 * R) ** 2)
"""Height of the lowest point of a ball on both noses above the cloth [m]."""


def on_noses(above: float, velocity: tuple[float, ...] = (0.0, 0.0, 0.0), **more: Any) -> Scene:
    return scene_of(ball((0.5, 0.7 * R, R + LIES + above), velocity), table=NARROW, **FLIES, **more)


def test_a_ball_on_two_noses_comes_to_rest_on_them() -> None:
    """If the ball weren't held, it would bounce there endlessly."""
    result = simulate(on_noses(1e-4), record="trajectory", max_events=20_000)
    assert result.status is Status.REST
    assert result.rest_positions[0] == pytest.approx(
        [0.5, 0.7 * R, R + LIES], abs=8.0 * CAPTURE_HEIGHT * R
    )
    assert not np.any(result.final_state[1])
    last = result.events[-1]
    assert (last["kind"], last["a"]) == (EventKind.ROLL_TO_REST, 0)
    energy = energies_around_events(result)
    assert np.diff(energy).max() <= 1e-13 * energy[0]
    # The energy when the ball is held is at most that of a bounce of the capture height.
    assert energy[-2] - energy[-1] <= 0.17 * G * 8.0 * CAPTURE_HEIGHT * R


@pytest.mark.skipif(COMPILED, reason="a constant of compiled kernels can't be patched")
def test_bounces_without_rest_end_with_a_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    """A ball that slides along two noses, to and fro, would rest only after hours."""
    monkeypatch.setattr(lying_still, "_MOST_SLOW_IMPACTS", 100)
    result = simulate(on_noses(1e-4, (0.3, 0.0, 0.0)))
    assert result.status is Status.ENDLESS
    assert result.reason.startswith('`balls[0]` ("b0") lies on balls or cushions and bounces there')


def test_a_ball_out_of_balance_is_not_held() -> None:
    """It leans by a tiny angle, falls off after some time, and rests on the cloth."""
    result = simulate(
        scene_of(ball((0.0, 0.0)), ball((0.0, 0.0, 3.0 * R + 1e-6)), **FLIES), max_events=100_000
    )
    assert result.status is Status.REST
    assert result.rest_positions[:, 2].tolist() == [R, R]


def between_two(apart: float, above: float, aside: float = 0.0, **more: Any) -> tuple[Scene, float]:
    """Return a ball dropped between two balls at noses, and its rest height above theirs [m].

    The two balls are `apart` radii apart.
    """
    reach = math.sqrt(H * (2.0 * R - H))
    length, lies = 2.0 * reach + apart * R, math.sqrt(4.0 - 0.25 * apart * apart) * R
    scene = scene_of(
        ball((reach, 0.35)),
        ball((length - reach, 0.35)),
        ball((0.5 * length, 0.35 + aside, R + lies + above), (0.0, 0.0, 0.0)),
        table=Table(length=length, width=0.7),
        **FLIES,
        **more,
    )
    return scene, lies


@pytest.mark.parametrize("above", [1e-4, *if_compiled(1e-6)])
@pytest.mark.parametrize("apart", [2.0, 3.4, *if_compiled(2.8, 3.8, 3.98)])
@pytest.mark.parametrize("restitution", [0.0, 0.95, 1.0])
def test_a_ball_in_the_wedge_between_two_rests_in_the_middle(apart, above, restitution) -> None:
    """Fails if the ball continues to bounce at one time after it has lost all of its energy."""
    scene, lies = between_two(apart, above, ball_restitution=restitution)
    result = simulate(scene, record="trajectory", max_events=25_000)
    assert result.status is Status.REST
    x, y, z = result.rest_positions[2]
    assert x == pytest.approx(0.5 * scene.table.length, abs=8.0 * CAPTURE_HEIGHT * R)
    assert y == 0.35
    # In a steep wedge, the two balls move the ball farther than they move themselves.
    steep = apart * R / (2.0 * lies)
    assert z == pytest.approx(R + lies, abs=8.0 * CAPTURE_HEIGHT * R * steep)
    assert not np.any(result.final_state[1])
    energy = energies_around_events(result)
    assert np.diff(energy).max() <= 1e-13 * energy[0]


def test_a_ball_out_of_balance_in_a_wedge_is_not_held_at_once() -> None:
    """The direction of its push is 1e-6 off the vertical."""
    scene, _ = between_two(3.4, 1e-4, aside=1e-6 * R)
    assert simulate(scene, max_events=2_000).status is Status.EVENT_LIMIT


def test_one_that_is_hit_where_it_lies_wakes() -> None:
    """Another ball falls on it after it has come to rest there."""
    falls = ball((0.5 + 0.6 * R, 0.7 * R, 4.0), (0.0, 0.0, 0.0))
    lies = ball((0.5, 0.7 * R, R + LIES + 1e-4), (0.0, 0.0, 0.0))
    scene = scene_of(lies, falls, table=NARROW, t_max=1.0, **FLIES)
    result = simulate(scene, record="trajectory", max_events=50_000)
    assert result.events is not None
    rests = result.events[result.events["kind"] == EventKind.ROLL_TO_REST]
    collisions = result.events[result.events["kind"] == EventKind.BALL_BALL]
    assert rests["a"][0] == 0
    assert rests["t"][0] < collisions["t"][0]
    speeds = np.linalg.norm(result.sample(collisions["t"][:1]).velocities[0], axis=1)
    assert speeds[0] > 0.1
