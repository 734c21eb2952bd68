"""Shots that distinguish engines, and measures of their results, for tests of adapters."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from ghostball.model import POOL_BALL_RADIUS as R, Ball, Physics, Result, Scene, Table
from ghostball.reference_adapters import engine_class, make_engine

SPEED = 1.5
"""Speed of the cue ball in single collisions [m/s]."""

FREE = Physics(preset="paper", rolling_friction=0.0)
"""Physics without friction, in which all impacts are elastic."""

TABLE = Table(length=2.54, width=1.27)


def half_ball(start: float = 0.5, physics: Physics = FREE, speed: float = SPEED) -> Scene:
    """Return a half-ball cut: the object ball leaves at 30 degrees below the x axis."""
    balls = [
        Ball(id="cue", position=(start, 0.5 + R), velocity=(speed, 0.0)),
        Ball(id="object", position=(1.0, 0.5)),
    ]
    return Scene(name="half-ball", balls=balls, physics=physics, t_max=0.75 / speed)


def head_on(speed: float = SPEED, restitution: float = 1.0) -> Scene:
    """Return a head-on collision: the speeds after it are (1 - e) / 2 and (1 + e) / 2 of the first.

    The initial gap is 43 mm, or for slow balls the way in 0.1 s, but at least 2 mm. With 43 mm at
    1 mm/s, a time-stepping engine would need tens of thousands of steps.
    """
    gap = min(0.1 - 2.0 * R, max(0.1 * speed, 0.002))
    balls = [
        Ball(id="cue", position=(0.6 - 2.0 * R - gap, 0.5), velocity=(speed, 0.0)),
        Ball(id="object", position=(0.6, 0.5)),
    ]
    physics = FREE.model_copy(update={"ball_restitution": restitution})
    return Scene(name="head-on", balls=balls, physics=physics, t_max=7.0 / 3.0 * gap / speed)


def frozen_line() -> Scene:
    """Return a ball that hits two touching balls on its line."""
    balls = [
        Ball(id="cue", position=(0.5, 0.5), velocity=(SPEED, 0.0)),
        Ball(id="1", position=(0.6, 0.5)),
        Ball(id="2", position=(0.6 + 2 * R, 0.5)),
    ]
    return Scene(name="line", balls=balls, physics=FREE, t_max=0.1)


def throw(friction: float = 0.05) -> Scene:
    """Return a half-ball hit by a ball that slides without spin, with friction between the balls.

    The surfaces slip, so the throw of the object ball is atan(mu). If they stuck, the throw would
    be atan(tan(30 degrees) / 7).
    """
    balls = [
        Ball(
            id="cue",
            position=(0.9, 0.5 + R),
            velocity=(SPEED, 0.0),
            angular_velocity=(0.0, 0.0, 0.0),
        ),
        Ball(id="object", position=(1.0, 0.5)),
    ]
    physics = Physics(
        preset="paper",
        motion="sliding",
        sliding_friction=0.0,
        rolling_friction=0.0,
        ball_friction=friction,
    )
    return Scene(name="throw", balls=balls, physics=physics, t_max=0.1)


def rack(shift: float = 0.001, duration: float = 1.0) -> Scene:
    """Return a break of 15 balls with gaps of 0.1 mm at 8 m/s, without cloth friction.

    The energy must be conserved.

    `shift` [m]: distance of the cue ball from the axis; each value gives a different break.
    `duration` [s]: simulated time.
    """
    pitch = 2 * R + 1e-4
    balls = [Ball(id="cue", position=(0.6, 0.635 + shift), velocity=(8.0, 0.0))]
    for row in range(5):
        x = 1.9 + row * pitch * math.sqrt(3.0) / 2.0
        balls += [
            Ball(id=f"{row}.{j}", position=(x, 0.635 + (j - row / 2) * pitch))
            for j in range(row + 1)
        ]
    return Scene(name="rack", balls=balls, table=TABLE, physics=FREE, t_max=duration)


PHASES = np.arange(8) / 8


def needs(name: str) -> pytest.MarkDecorator:
    """Return a mark that skips a test if an engine isn't installed, with the reason for users."""
    reason = engine_class(name).unavailable()
    return pytest.mark.skipif(reason is not None, reason=str(reason))


def play(spec: str, scene: Scene, **record: str) -> Result:
    return make_engine(spec).simulate(scene, **record)


def to_the_wall(restitution: float = 1.0) -> Scene:
    """Return a ball that meets the right cushion at 45 degrees."""
    ball = Ball(id="cue", position=(1.5, 0.3), velocity=(1.0, 1.0))
    physics = FREE.model_copy(update={"cushion": "restitution", "cushion_restitution": restitution})
    table = Table(length=2.0, width=2.0)
    return Scene(name="wall", balls=[ball], table=table, physics=physics, t_max=0.6)


def slide() -> Scene:
    """Return a ball that slides for 0.29 s, and then rolls without slowing until 0.5 s."""
    ball = Ball(
        id="cue", position=(0.5, 0.5), velocity=(2.0, 0.0), angular_velocity=(0.0, 0.0, 0.0)
    )
    physics = Physics(preset="paper", motion="sliding", sliding_friction=0.2, rolling_friction=0.0)
    return Scene(name="slide", balls=[ball], physics=physics, t_max=0.5)


def cut_angles(engine: str, dt: float) -> NDArray[np.float64]:
    """Return the errors of the object ball's direction, one for each phase of the step [deg].

    `dt` [s]: time step.
    """
    spec = f"{engine}{',' if ':' in engine else ':'}dt={dt}"
    off = []
    for phase in PHASES:
        x, y = play(spec, half_ball(0.5 - phase * SPEED * dt)).final_state.velocities[0, 1, :2]
        off.append(np.degrees(np.arctan2(-y, x)) - 30.0)
    return np.array(off)


def shares(spec: str, scene: Scene) -> NDArray[np.float64]:
    """Return the final velocities along x divided by the initial velocity of the cue ball."""
    result = play(spec, scene)
    speeds: NDArray[np.float64] = result.final_state.velocities[0, :, 0]
    return speeds / scene.velocities[0, 0]


def energy_ratios(spec: str, scene: Scene) -> NDArray[np.float64]:
    """Return the energy at times throughout the shot divided by the initial energy."""
    result = play(spec, scene, record="trajectory")
    assert scene.t_max is not None
    total = result.energy(np.linspace(0.0, scene.t_max, 201)).total
    ratios: NDArray[np.float64] = total / total[0]
    return ratios
