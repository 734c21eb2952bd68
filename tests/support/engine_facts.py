"""Shots that tell engines apart, for the tests of adapters."""

from __future__ import annotations

import numpy as np
import pytest
from billiard_shots import FREE, SPEED, half_ball
from numpy.typing import NDArray

from ghostball.model import Ball, Physics, Result, Scene, Table
from ghostball.reference_adapters import engine_class, make_engine

PHASES = np.arange(8) / 8


def needs(name: str) -> pytest.MarkDecorator:
    """Skip, with the reason that a user reads, where an engine isn't installed."""
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
    """Return a ball that slides for half a second and never slows as it rolls."""
    ball = Ball(
        id="cue", position=(0.5, 0.5), velocity=(2.0, 0.0), angular_velocity=(0.0, 0.0, 0.0)
    )
    physics = Physics(preset="paper", motion="sliding", sliding_friction=0.2, rolling_friction=0.0)
    return Scene(name="slide", balls=[ball], physics=physics, t_max=0.5)


def cut_angles(engine: str, dt: float) -> NDArray[np.float64]:
    """Return how far each phase's object ball leaves off 30 degrees [deg], in steps of `dt` [s]."""
    spec = f"{engine}{',' if ':' in engine else ':'}dt={dt}"
    off = []
    for phase in PHASES:
        x, y = play(spec, half_ball(0.5 - phase * SPEED * dt)).final_state.velocities[0, 1, :2]
        off.append(np.degrees(np.arctan2(-y, x)) - 30.0)
    return np.array(off)


def shares(spec: str, scene: Scene) -> NDArray[np.float64]:
    """Return the final velocities along x over the cue ball's first."""
    result = play(spec, scene)
    speeds: NDArray[np.float64] = result.final_state.velocities[0, :, 0]
    return speeds / scene.velocities[0, 0]


def energy_ratios(spec: str, scene: Scene) -> NDArray[np.float64]:
    """Return the energy through the shot over that at its start."""
    result = play(spec, scene, record="trajectory")
    assert scene.t_max is not None
    total = result.energy(np.linspace(0.0, scene.t_max, 201)).total
    ratios: NDArray[np.float64] = total / total[0]
    return ratios
