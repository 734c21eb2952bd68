"""An elastic gas of balls between cushions: its scenes, and what its collisions say of it."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from ghostball.model import (
    POOL_BALL_RADIUS as RADIUS,
    EventKind,
    ExactTrajectory,
    Physics,
    Result,
    Scene,
)
from ghostball.reference_adapters import ReferenceEngine
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.scenes.gases import FRICTIONLESS, packed_gas

ICE: Final = Physics(rolling_friction=0.0)
"""Elastic, and nothing slows."""


def gas(rows: int, packing: float, t_max: float, seed: int = 1) -> Scene:
    """Return rows x rows balls of 1 kg that cover this part of a square table.

    They begin on a lattice; each component of their velocities has a variance of about 1 m^2/s^2.
    """
    scene = packed_gas(rows * rows, packing, FRICTIONLESS, t_max, seed)
    balls = tuple(ball.model_copy(update={"mass": 1.0}) for ball in scene.balls)
    return scene.model_copy(update={"balls": balls})


def begun_at_end(result: Result, t_max: float, sign: float = 1.0) -> Scene:
    """Return the scene that begins where a run ended; with `sign` -1 it goes back.

    Of balls that only ever roll without friction: their spin follows. Every number is copied
    to the bit.

    Raises `SceneError` where the balls ended in places where none may begin.
    """
    positions, velocities, _ = (samples[0] for samples in result.final_state)
    balls = [
        ball.without_strike().model_copy(
            update={"position": tuple(r), "velocity": tuple(v), "angular_velocity": None}
        )
        for ball, r, v in zip(
            result.scene.balls,
            positions.tolist(),
            (sign * velocities + 0.0).tolist(),
            strict=True,
        )
    ]
    scene = result.scene
    return Scene(
        name=scene.name, t_max=t_max, physics=scene.physics, table=scene.table, balls=tuple(balls)
    )


def patient(engine: ReferenceEngine, events: int) -> ReferenceEngine:
    """Return our engine with leave to take that many events; any other as it is."""
    if engine.name != OURS or getattr(engine.settings, "max_events", events) >= events:
        return engine
    make: Any = type(engine)
    patient_one: ReferenceEngine = make(engine.settings.model_copy(update={"max_events": events}))
    return patient_one


def kinetic_energy(result: Result, at_start: bool = False) -> float:
    """Return the energy of translation at the end, or at the start [J]; rolling adds 2/5 of it."""
    scene = result.scene
    v = scene.velocities if at_start else result.final_state.velocities[0]
    return 0.5 * math.fsum((scene.masses[:, np.newaxis] * v * v).ravel().tolist())


def stray_momentum(result: Result) -> tuple[float, float] | None:
    """Return the momentum that came in from nowhere [kg m/s]: what isn't the cushions'.

    None where the engine records frames, which don't say what a cushion gave.

    A mirror turns one component round. What a ball has at its end, less what it began with and what
    cushions turned, is what other balls gave; over all balls that is 0. Sums are exact.
    """
    trajectory, events = result.trajectory, result.events
    if not isinstance(trajectory, ExactTrajectory) or events is None:
        return None
    stray: tuple[list[float], list[float]] = ([], [])
    bounces = events[events["kind"] == EventKind.BALL_CUSHION]
    for i, (segments, mass) in enumerate(
        zip(trajectory.segments, result.scene.masses.tolist(), strict=True)
    ):
        mine = bounces[bounces["a"] == i]
        rows = np.searchsorted(segments[:, 0], mine["t"])
        for axis in (0, 1):
            v = segments[:, 3 + axis]
            turned = rows[mine["b"] // 2 == axis]
            given = (v[-1:], -v[:1], -v[turned], v[turned - 1])
            stray[axis].extend((mass * np.concatenate(given)).tolist())
    return math.fsum(stray[0]), math.fsum(stray[1])


def collision_rate(count: int, packing: float) -> float:
    """Return how many collisions of two balls of 1 kg there are in a second, about.

    By the virial theorem p / (n k T) - 1 is the sum over collisions of m v_n d / (2 N k T t), and
    v_n, the speed of approach, has the mean sqrt(pi k T / m) over collisions. The pressure is that
    of Henderson 1975, within a part in 200 up to a packing of 0.5.
    """
    excess = (1.0 + packing**2 / 8.0) / (1.0 - packing) ** 2 - 1.0
    return count * excess / (math.sqrt(math.pi) * RADIUS)
