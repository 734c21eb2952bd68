"""Friction of balls that spin in space, on discs of a 2D engine: they spin about the vertical.

Two surfaces in contact slip along the contact, in the engine's plane, and up or down, where balls
roll. Coulomb friction acts against the whole slip U: its impulse is min(mu J, (2/7) m_r U), J the
normal impulse and m_r the reduced mass [Alciatore, proof A.14]. The engine sees the part along the
contact, U_t, alone, and without the rest would throw a rolling ball too far. Given the coefficient
mu |U_t| / U, what the engine solves is just the part along the contact of that impulse, whether the
surfaces slip or stick: both of its limits, mu J and (2/7) m_r U, then shrink in the same
proportion. The part up or down moves no ball that the cloth holds, but turns it: that is added
here, from the engine's J.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ghostball.model import Scene
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.stepping.laws import cushion_friction
from ghostball.reference_adapters.stepping.plane import Collision


class _Slip(NamedTuple):
    """The slip of a ball's surface over what it touches.

    `nx`, `ny`: unit normal from the ball to what it touches.
    `along`, `up`: slip along t = z x n, and up [m/s].
    `mass`: reduced mass [kg]; the ball's own at a cushion.
    `friction`: coefficient for the whole slip [1].
    """

    nx: float
    ny: float
    along: float
    up: float
    mass: float
    friction: float

    @property
    def speed(self) -> float:
        return math.hypot(self.along, self.up)


class ContactFriction:
    """Friction at the contacts of a world: its coefficients, and what turns its balls up or down.

    For each step call `set_spins` before, `prepare` and `note` from the engine's callbacks before
    and after it solves a contact, and `turns` after the step.
    """

    def __init__(self, scene: Scene) -> None:
        physics = scene.physics
        self._radii = scene.radii.tolist()
        self._masses = scene.masses.tolist()
        self._ball_friction = physics.ball_friction
        self._cushion_friction = cushion_friction(physics)
        self._spins = scene.angular_velocities
        self._turns = np.zeros_like(self._spins)
        self._slips: dict[Collision, _Slip] = {}

    def set_spins(self, spins: FloatArray) -> None:
        """Take over the angular velocities, (n, 3) float64 [rad/s]; the engine has the vertical."""
        self._spins = spins
        self._turns = np.zeros_like(spins)
        self._slips.clear()

    def turns(self, vertical: FloatArray) -> FloatArray:
        """Return what the step's contacts added to the angular velocities, (n, 3) [rad/s].

        `vertical` (n,) float64 [rad/s]: the spins about the vertical that the engine has now.
        """
        turns = self._turns.copy()
        turns[:, 2] = vertical - self._spins[:, 2]
        return turns

    def prepare(
        self, contact: Collision, line: tuple[float, float], velocity: tuple[float, float]
    ) -> float:
        """Return the coefficient of friction that a contact must have in the engine [1].

        `line`: from ball a to ball b, of any length; at a cushion the unit vector into it.
        `velocity` [m/s]: the velocity of ball a, less that of ball b.
        """
        slip = (self._cushion_slip if contact.cushion else self._ball_slip)(contact, line, velocity)
        self._slips[contact] = slip
        return slip.friction * (abs(slip.along) / slip.speed if slip.speed > 0.0 else 1.0)

    def note(self, contact: Collision, normal: float) -> None:
        """Turn the balls by the part up or down of the friction of a contact that was solved.

        `normal` [N s]: its impulse along the normal.
        """
        slip = self._slips[contact]
        if slip.up == 0.0:
            return
        friction = min(slip.friction * normal, 2.0 / 7.0 * slip.mass * slip.speed)
        up = friction * slip.up / slip.speed
        # Both ends of the impulse turn the balls the same way, about t: by R P / I.
        for ball in (contact.a,) if contact.cushion else (contact.a, contact.b):
            turn = up / (0.4 * self._masses[ball] * self._radii[ball])
            self._turns[ball, 0] -= slip.ny * turn
            self._turns[ball, 1] += slip.nx * turn

    def normal_part(self, contact: Collision, x: float, y: float) -> float:
        """Return the part along its normal of a contact's impulse [N s], not negative."""
        slip = self._slips[contact]
        return abs(slip.nx * x + slip.ny * y)

    def _ball_slip(
        self, contact: Collision, line: tuple[float, float], velocity: tuple[float, float]
    ) -> _Slip:
        a, b, _ = contact
        length = math.sqrt(line[0] * line[0] + line[1] * line[1])
        normal = line[0] / length, line[1] / length
        spin = self._radii[a] * self._spins[a] + self._radii[b] * self._spins[b]
        mass = self._masses[a] * self._masses[b] / (self._masses[a] + self._masses[b])
        return self._slip(normal, velocity, spin, mass, cushion=False)

    def _cushion_slip(
        self, contact: Collision, line: tuple[float, float], velocity: tuple[float, float]
    ) -> _Slip:
        """Return the slip of the ball's surface over the cushion, at the centre's height."""
        ball = contact.a
        spin = self._radii[ball] * self._spins[ball]
        return self._slip(line, velocity, spin, self._masses[ball], cushion=True)

    def _slip(
        self,
        normal: tuple[float, float],
        velocity: tuple[float, float],
        spin: FloatArray,
        mass: float,
        *,
        cushion: bool,
    ) -> _Slip:
        """Return the slip v + (R w) x n of a relative velocity and a sum of R w, both [m/s]."""
        (nx, ny), (vx, vy) = normal, velocity
        along = nx * vy - ny * vx + float(spin[2])
        up = float(spin[0]) * ny - float(spin[1]) * nx
        friction = self._coefficient(math.hypot(along, up), cushion=cushion)
        return _Slip(nx, ny, along, up, mass, friction)

    def _coefficient(self, slip: float, *, cushion: bool) -> float:
        if cushion:
            return self._cushion_friction
        if isinstance(self._ball_friction, str):
            # Alciatore's fit of Marlow's measurements, proof A.14; the slip in m/s.
            return 9.951e-3 + 0.108 * math.exp(-1.088 * slip)
        return self._ball_friction
