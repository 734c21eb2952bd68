"""Random breaks over the whole physics of the cloth, and what must hold in each.

Every combination of a law of ball-ball impacts, a law of cushions, a friction between balls, a
restitution and a way to resolve impacts at one instant comes round once in `len(COMBINATIONS)`
breaks. The checks read the recorded motion alone, by brute force.
"""

from __future__ import annotations

import itertools
import math
import random
from dataclasses import dataclass
from typing import Any

import numpy as np
from invariants import EPS, FloatArray, ball_impacts, energies, instants, overlaps
from shots import POOL_TABLE, R, ball, rack, scene_of

from ghostball.engine import ExactTrajectory, Result, Scene, Status

DEEPEST = 1e-12
"""Overlap that is allowed [m]: a contact force holds its gaps to 4e-13 m."""

ENERGY_ROUNDING = 1e-14
"""Rise of the energy, relative to the first, that is a rounding error of sixteen balls' sum."""

CUSHIONS: tuple[dict[str, Any], ...] = (
    {"cushion": "mirror"},
    {
        "cushion": "restitution",
        "cushion_restitution": 0.8,
        "cushion_tangential_restitution": 0.9,
    },
    {"cushion": "frictional", "cushion_restitution": 0.85, "cushion_friction": 0.2},
    {"cushion": "han2005", "cushion_restitution": 0.85, "cushion_friction": 0.2},
    {"cushion": "mathavan2010", "cushion_restitution": 0.98, "cushion_friction": 0.14},
)
BALL_LAWS = ("frictional", "mathavan2014")
FRICTIONS: tuple[float | str, ...] = (0.06, "alciatore", 0.0)
RESTITUTIONS = (1.0, 0.98, 0.95, 0.9)
IMPACTS = ("simultaneous", "sequential")

_SLIDING = [
    {"motion": "sliding", "ball_impact": law, "ball_friction": friction, **cushion, **shared}
    for law, friction, cushion in itertools.product(BALL_LAWS, FRICTIONS, CUSHIONS)
    for shared in (
        {"ball_restitution": e, "impacts": impacts}
        for e, impacts in itertools.product(RESTITUTIONS, IMPACTS)
    )
]
_ROLLING = [
    {"motion": "rolling", **cushion, "ball_restitution": e, "impacts": impacts}
    for cushion, e, impacts in itertools.product(CUSHIONS[:2], RESTITUTIONS, IMPACTS)
]
COMBINATIONS: tuple[dict[str, Any], ...] = tuple(_SLIDING + _ROLLING)

_STRIDE = 97
"""Prime, and no divisor of the number of combinations: a few breaks already see all laws."""


def physics_of(seed: int) -> dict[str, Any]:
    """Return the physics of this seed's break."""
    return COMBINATIONS[seed * _STRIDE % len(COMBINATIONS)]


def break_scene(seed: int) -> Scene:
    """Return a break of 15 racked balls.

    Cue ball at 1 to 10 m/s (log-uniform), with top and side spin of up to 1.25 of rolling's where
    it may slide, up to a ball's radius off the middle. The rack's gaps are 0 (every fourth) or 1e-6
    to 1e-3 m (log-uniform).
    """
    chance = random.Random(seed)
    physics = physics_of(seed)
    gap = 0.0 if chance.random() < 0.25 else 10 ** chance.uniform(-6.0, -3.0)
    speed = 10 ** chance.uniform(0.0, 1.0)
    aim, offset = chance.uniform(-0.01, 0.01), chance.uniform(-R, R)
    velocity = (speed * math.cos(aim), speed * math.sin(aim))
    top, side = chance.uniform(-1.25, 1.25), chance.uniform(-1.25, 1.25)
    cue = ball((0.6, 0.635 + offset), velocity)
    if physics["motion"] == "sliding":
        roll = (-velocity[1] / R, velocity[0] / R)
        cue["angular_velocity"] = (top * roll[0], top * roll[1], side * speed / R)
    return scene_of(cue, *rack(15, (1.9, 0.635), gap), table=POOL_TABLE, **physics)


@dataclass(frozen=True)
class Soundness:
    """The worst of one break: overlap [m], rise of energy and of momentum over their rounding."""

    depth: float
    energy_rise: float
    momentum_error: float


def soundness(result: Result, between: int) -> Soundness:
    """Measure a break at all its events, just before each, and at `between` instants in between."""
    times = instants(result, between)
    if between == 0:
        times = np.append(times, np.nextafter(times[times > 0.0], 0.0))
        times.sort()
    energy = energies(result, times)
    rise = float(np.max(np.diff(energy), initial=0.0)) / float(energy[0])
    depth = float(overlaps(result.scene, result.sample(times).positions).max())
    return Soundness(depth, rise, momentum_error(result))


def momentum_error(result: Result) -> float:
    """Return the worst change of two balls' momentum at an impact of their own, in roundings.

    A rounding is EPS times the momenta, and what friction changes them by in the last unit of the
    clock. Impacts in which the cloth takes part are left out: all of them where the law says so,
    and those of balls that a contact force holds against others, where the cloth holds on to
    resting and rolling ones.
    """
    scene = result.scene
    if scene.physics.ball_impact == "mathavan2014":
        return 0.0
    assert isinstance(result.trajectory, ExactTrajectory)
    starts = [frozenset(knots[:, 0].tolist()) for knots in result.trajectory.knots]
    impacts = [
        (t, a, b)
        for t, a, b in ball_impacts(result)
        if t > 0.0 and sum(t in s for s in starts) == 2
    ]
    if not impacts:
        return 0.0
    times = np.array([t for t, _, _ in impacts])
    rows = np.arange(len(impacts))[:, np.newaxis]
    pairs = np.array([[a, b] for _, a, b in impacts])
    masses = scene.masses[pairs][:, :, np.newaxis]
    before, after = (
        masses * result.sample(at).velocities[rows, pairs]
        for at in (np.nextafter(times, 0.0), times)
    )
    friction = scene.physics.gravity * scene.physics.sliding_friction
    tick = masses.sum(axis=(1, 2)) * friction * times
    size: FloatArray = np.abs(before).sum(axis=(1, 2)) + tick
    change = np.abs((after - before).sum(axis=1)).max(axis=1)
    return float(np.max(change / (EPS * size)))


def assert_sound(result: Result, between: int) -> None:
    """Assert that a break ended by itself, that nothing overlapped and no energy came in."""
    assert result.status is Status.REST, f"{result.status}: {result.reason}"
    for unsolved in ("unsolved_contact_steps", "unsolved_joint_impacts"):
        assert result.work[unsolved] == 0, unsolved
    worst = soundness(result, between)
    assert worst.depth <= DEEPEST, worst
    assert worst.energy_rise <= ENERGY_ROUNDING, worst
    assert worst.momentum_error <= 16.0, worst
