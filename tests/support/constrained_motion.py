"""Integrate balls in resting contact with each other and a cushion, independently of the engine.

The normal forces keep the second derivatives of the gaps at 0. The friction at a contact acts
against the slip of the surfaces by Coulomb's law, or keeps the slip at 0 if the contact sticks. The
friction of the cloth acts in the same way on sliding and rolling balls. The module shares no code
with the engine: it uses 3D vectors and solves one system of linear equations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from ghostball.model import Scene

G = 9.81
UP = np.array([0.0, 0.0, 1.0])
OUTWARD = {"right": np.array([1.0, 0.0, 0.0]), "top": np.array([0.0, 1.0, 0.0])}

Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class Touch:
    """A contact of ball a with ball b, or with the only cushion of the table if b is None.

    `sticks`: whether the surfaces don't slip.
    """

    a: int
    b: int | None
    sticks: bool = False


def constrained_motion(scene: Scene, touches: Sequence[Touch]) -> Numbers:
    """Return positions, velocities and angular velocities at `t_max`, with errors of about 1e-12.

    Requires: every ball keeps sliding or keeps rolling; every contact pushes all the time, and
    keeps slipping or keeps sticking. In the paper's model, a ball is a point slowed by rolling
    friction, and contacts have no friction. The contact normal of balls with different radii is
    horizontal, as in the engine.
    """
    first = np.array([scene.positions, scene.velocities, scene.angular_velocities])

    def rates(_: float, z: Numbers) -> Numbers:
        return _rates(scene, touches, z.reshape(first.shape)).ravel()

    found = solve_ivp(rates, (0.0, scene.t_max), first.ravel(), "DOP853", rtol=1e-13, atol=1e-15)
    assert found.success
    last: Numbers = found.y[:, -1].reshape(first.shape)
    return last


def _rates(scene: Scene, touches: Sequence[Touch], z: Numbers) -> Numbers:
    x, v, w = z
    radii, masses = scene.radii[:, np.newaxis], scene.masses
    slips = v - radii * np.cross(w, UP)
    slips[:, 2] = 0.0
    of_paper = scene.physics.motion == "rolling"
    rolls = of_paper | (np.linalg.norm(slips, axis=1) < 1e-9)
    against = np.where(rolls[:, None], v, slips)
    push = -np.where(rolls, scene.rolling_frictions, scene.sliding_frictions)[:, None] * G * against
    push /= np.linalg.norm(against, axis=1)[:, None]
    turns = 2.5 / radii  # m R / I
    # Rolling friction doesn't end rolling.
    pull = np.where(rolls[:, np.newaxis], 1.0 / radii, -turns) * np.cross(UP, push)
    pull[:, 2] -= scene.spinning_friction_rates * np.sign(w[:, 2])
    # Air drag acts on the centre; the cloth takes 2/7 of it, so that a rolling ball keeps rolling.
    drag = -scene.physics.air_drag * np.linalg.norm(v, axis=1)[:, None] * v
    drag[rolls] *= 5.0 / 7.0
    push += drag
    pull[rolls] += np.cross(UP, drag[rolls]) / radii[rolls]
    columns, equations, known, limits = [], [], [], []
    for touch in touches:
        n, p, change = _normal(scene, touch, x, v)
        slip = _relative(touch, v, 1.0) + np.cross(_relative(touch, radii * w, -1.0), p)
        slip -= np.dot(slip, p) * p
        along, up = np.cross(UP, n), np.cross(p, np.cross(UP, n))
        friction = scene.physics.ball_friction
        if touch.b is None:
            friction = scene.physics.cushion_friction
        # The gap of two balls closes along n, and dn/dt is perpendicular to n.
        sizes = [(p, np.zeros(3))]
        equations.append((touch, n, None))
        known.append(-np.dot(change, _relative(touch, v, 1.0)))
        if touch.sticks:
            assert np.linalg.norm(slip) < 1e-6
            for d in (along, up):
                sizes.append((d, np.cross(p, d)))
                equations.append((touch, d, p))
                known.append(-np.dot(d, np.cross(_relative(touch, radii * w, -1.0), change)))
            limits.append((friction, len(columns)))
        else:
            d = friction * slip / np.linalg.norm(slip)
            sizes[0] = (p + d, np.cross(p, d))
            limits.append((0.0, len(columns)))
        columns += [(touch, force, twist) for force, twist in sizes]

    def respond(touch, force, twist):
        """Return the accelerations caused by a unit force at a contact, and the cloth's part."""
        a, b = np.zeros_like(v), np.zeros_like(w)
        flat = force * [1.0, 1.0, 0.0]
        a[touch.a] -= flat / masses[touch.a]
        b[touch.a] -= turns[touch.a] * twist / masses[touch.a]
        if touch.b is not None:
            a[touch.b] += flat / masses[touch.b]
            b[touch.b] -= turns[touch.b] * twist / masses[touch.b]
        # The force of the cloth that keeps a ball rolling.
        hold = -(a - radii * np.cross(b, UP)) * [1.0, 1.0, 0.0] / 3.5
        hold[of_paper | ~rolls] = 0.0
        return a + hold, b - turns * np.cross(UP, hold), hold

    def measure(equation, a, b):
        """Return the rate of change of a gap's rate, or of a slip, for these accelerations."""
        touch, d, p = equation
        found = np.dot(d, _relative(touch, a, 1.0))
        if p is not None:
            found += np.dot(d, np.cross(_relative(touch, radii * b, -1.0), p))
        return found

    answers = [respond(*column) for column in columns]
    matrix = [[measure(one, *answer[:2]) for answer in answers] for one in equations]
    right = [value - measure(one, push, pull) for one, value in zip(equations, known, strict=True)]
    forces = np.linalg.solve(matrix, right)
    for touch, (friction, at) in zip(touches, limits, strict=True):
        assert forces[at] > 0.0
        if touch.sticks:
            assert np.hypot(*forces[at + 1 : at + 3]) < friction * forces[at]
    a, b, hold = (
        sum(force * answer[part] for force, answer in zip(forces, answers, strict=True))
        for part in range(3)
    )
    assert np.all(np.linalg.norm(hold, axis=1) <= scene.sliding_frictions * G)
    return np.array([v, push + a, pull + b])


def _normal(scene: Scene, touch: Touch, x: Numbers, v: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    """Return the normal in the plane, the direction to the contact point, and dn/dt."""
    if touch.b is None:
        radius = scene.radii[touch.a]
        sine = (scene.physics.cushion_height - radius) / radius
        assert scene.table is not None
        n = OUTWARD[scene.table.cushions[0]]
        return n, np.sqrt(1.0 - sine**2) * n + sine * UP, np.zeros(3)
    between = (x[touch.b] - x[touch.a]) * [1.0, 1.0, 0.0]
    n = between / np.linalg.norm(between)
    change = v[touch.b] - v[touch.a]
    return n, n, (change - np.dot(change, n) * n) / np.linalg.norm(between)


def _relative(touch: Touch, of: Numbers, sign: float) -> Numbers:
    """Return a - `sign` * b for the balls of a contact: sign 1 for velocities, -1 for spins."""
    return of[touch.a] if touch.b is None else of[touch.a] - sign * of[touch.b]
