"""A naive oracle of balls that slide and spin: forces and torques in space, steps, bisection."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import CUSHIONS, Scene

FloatArray = NDArray[np.float64]

UP = np.array([0.0, 0.0, 1.0])


class SpinningOracle:
    """Doubles and vectors in space: shares neither formula nor frame nor order with the forms.

    `late` [s] resolves every collision that much after the touch, as a stepping engine does.
    """

    def __init__(self, scene: Scene, step: float = 2e-3, late: float = 0.0) -> None:
        self.scene, self.step, self.late = scene, step, late
        self.x, self.v = scene.positions, scene.velocities
        self.w = scene.angular_velocities
        self.inertia = 0.4 * scene.masses * scene.radii**2
        self.t = 0.0
        self.collisions: list[tuple[str, int, int | str]] = []

    def slip(self, i: int) -> FloatArray:
        slip: FloatArray = self.v[i] + np.cross(self.w[i], -self.scene.radii[i] * UP)
        return slip

    def move(self, dt: float) -> None:
        for i in range(len(self.x)):
            self.move_one(i, dt)

    def move_one(self, i: int, dt: float) -> None:
        """Friction on the cloth and its torque, until what it acts on is gone."""
        scene, radius, mass = self.scene, self.scene.radii[i], self.scene.masses[i]
        weight = mass * scene.physics.gravity
        decay = scene.spinning_friction_rates[i] * dt
        self.w[i, 2] -= math.copysign(min(decay, abs(self.w[i, 2])), self.w[i, 2])
        while dt > 0.0:
            slip = self.slip(i)
            if np.linalg.norm(slip) > 1e-13:
                force = -scene.sliding_frictions[i] * weight * slip / np.linalg.norm(slip)
                turn = np.cross(-radius * UP, force) / self.inertia[i]
                change = force / mass + np.cross(turn, -radius * UP)
                h = min(dt, float(np.linalg.norm(slip) / np.linalg.norm(change)))
            elif np.linalg.norm(self.v[i]) > 1e-13:
                speed = float(np.linalg.norm(self.v[i]))
                # The force that slows a ball that rolls acts on its centre: it goes on rolling.
                force = -scene.rolling_frictions[i] * weight * self.v[i] / speed
                turn = np.cross(UP, force / mass) / radius
                h = min(dt, speed * mass / float(np.linalg.norm(force)))
            else:
                self.v[i], self.w[i, :2] = 0.0, 0.0
                return
            self.x[i] += self.v[i] * h + force / mass * h**2 / 2
            self.v[i] += force / mass * h
            self.w[i] += turn * h
            dt -= h

    def state(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        return self.x.copy(), self.v.copy(), self.w.copy()

    def gaps(self) -> dict[tuple[str, int, int | str], float]:
        """Gap of everything that approaches [m]."""
        radii, gaps = self.scene.radii, {}
        for a, b in itertools.combinations(range(len(self.x)), 2):
            if (self.x[b] - self.x[a]) @ (self.v[b] - self.v[a]) < 0:
                apart = float(np.linalg.norm(self.x[b] - self.x[a]))
                gaps["ball-ball", a, b] = apart - radii[a] - radii[b]
        table = self.scene.table
        for ball, name in itertools.product(range(len(self.x)), table.cushions if table else ()):
            axis, far = divmod(CUSHIONS.index(name), 2)
            if self.v[ball, axis] * (1 if far else -1) > 0:
                extent = (table.length, table.width)[axis]
                gap = extent - self.x[ball, axis] if far else self.x[ball, axis]
                gaps["ball-cushion", ball, name] = float(gap - radii[ball])
        return gaps

    def run(self) -> SpinningOracle:
        end = self.scene.t_max or np.inf
        while self.t < end and (np.any(self.v) or np.any(self.w)):
            dt = min(self.step, end - self.t)
            before = self.state()
            self.move(dt)
            touching = [what for what, gap in self.gaps().items() if gap < 0]
            if touching:
                dt, what = min((self.touch(before, what, dt), what) for what in touching)
                self.x, self.v, self.w = before
                self.move(dt + self.late)
                self.t += self.late
                self.resolve(*what)
            self.t += dt
        return self

    def touch(self, before: tuple[FloatArray, ...], what: Any, high: float) -> float:
        low = 0.0
        for _ in range(60):
            middle = (low + high) / 2
            self.x, self.v, self.w = (part.copy() for part in before)
            self.move(middle)
            low, high = (low, middle) if self.gaps().get(what, 1.0) < 0 else (middle, high)
        return low

    def resolve(self, kind: str, a: int, b: int | str) -> None:
        self.collisions.append((kind, a, b))
        physics, radii, masses = self.scene.physics, self.scene.radii, self.scene.masses
        if isinstance(b, str):
            axis, far = divmod(CUSHIONS.index(b), 2)
            if physics.cushion == "mirror":
                self.v[a, axis] *= -1.0
                return
            nose = physics.cushion_height - radii[a] if physics.cushion == "han2005" else 0.0
            normal = np.zeros(3)
            normal[axis] = math.sqrt(1 - (nose / radii[a]) ** 2) * (1 if far else -1)
            normal[2] = nose / radii[a]
            surfaces = [(a, 1.0)]
            e, mu = physics.cushion_restitution, physics.cushion_friction
        else:
            normal = (self.x[b] - self.x[a]) / np.linalg.norm(self.x[b] - self.x[a])
            surfaces = [(a, 1.0), (b, -1.0)]
            e, mu = physics.ball_restitution, physics.ball_friction
        # The surfaces' velocity over each other, and what an impulse of 1 changes of it.
        closing, slip, light, loose = 0.0, np.zeros(3), 0.0, 0.0
        for i, sign in surfaces:
            closing += sign * float(self.v[i] @ normal)
            slip += sign * self.v[i] + np.cross(self.w[i], radii[i] * normal)
            light += 1 / masses[i]
            loose += 1 / masses[i] + radii[i] ** 2 / self.inertia[i]
        slip -= (slip @ normal) * normal
        size = float(np.linalg.norm(slip))
        if mu == "alciatore":
            mu = 9.951e-3 + 0.108 * math.exp(-1.088 * size)
        push = (1 + e) * closing / light
        impulse = -push * normal
        if size > 1e-14:
            impulse = impulse - min(mu * push, size / loose) * slip / size
        for i, sign in surfaces:
            self.v[i] += sign * impulse / masses[i]
            self.w[i] += np.cross(radii[i] * normal, impulse) / self.inertia[i]
            self.v[i, 2] = 0.0  # the cloth holds the balls
