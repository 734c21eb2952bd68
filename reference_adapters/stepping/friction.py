"""Friction of balls that spin in space, for the discs of a 2D engine.

Discs spin only about the vertical.

The surfaces of two balls in contact slip horizontally, in the engine's plane, and vertically,
because balls roll. Coulomb friction acts against the total slip U: its impulse is
min(mu J, (2/7) m_r U), with the normal impulse J and the reduced mass m_r [Alciatore, proof A.14].
The engine knows only the horizontal part of the slip, U_t, and would throw a rolling ball too far.
With the coefficient mu |U_t| / U, the engine computes exactly the horizontal part of this impulse,
for slip and for sticking, because both limits, mu J and (2/7) m_r U, are reduced in the same
proportion. The vertical part of the impulse doesn't move a ball on the cloth, but turns it; this
module adds the turn, from the engine's J.
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
    """The slip of a ball's surface at a contact.

    `nx`, `ny`: unit normal from the ball to the other body.
    `along`, `up`: slip along t = z x n, and upwards [m/s].
    `mass`: reduced mass [kg]; at a cushion the mass of the ball.
    `friction`: coefficient for the total slip [1].
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
    """Friction at the contacts of a world: the coefficients, and the turns of the balls.

    For each step, call `set_spins` before the step, `prepare` and `note` from the engine's
    callbacks before and after it solves a contact, and `turns` after the step.
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
        """Store the angular velocities, (n, 3) float64 [rad/s]; the engine has the vertical one."""
        self._spins = spins
        self._turns = np.zeros_like(spins)
        self._slips.clear()

    def turns(self, vertical: FloatArray) -> FloatArray:
        """Return the changes of the angular velocities by the contacts of the step, (n, 3) [rad/s].

        `vertical`: (n,) float64 [rad/s], the present vertical spins in the engine.
        """
        turns = self._turns.copy()
        turns[:, 2] = vertical - self._spins[:, 2]
        return turns

    def prepare(
        self, contact: Collision, line: tuple[float, float], velocity: tuple[float, float]
    ) -> float:
        """Return the friction coefficient that a contact must have in the engine [1].

        `line`: vector from ball a to ball b, of any length; at a cushion, the unit vector into it.
        `velocity`: velocity of ball a minus that of ball b [m/s].
        """
        slip = (self._cushion_slip if contact.cushion else self._ball_slip)(contact, line, velocity)
        self._slips[contact] = slip
        return slip.friction * (abs(slip.along) / slip.speed if slip.speed > 0.0 else 1.0)

    def note(self, contact: Collision, normal: float) -> None:
        """Turn the balls by the vertical part of the friction of a contact that was solved.

        `normal`: normal impulse of the contact [N s].
        """
        slip = self._slips[contact]
        if slip.up == 0.0:
            return
        friction = min(slip.friction * normal, 2.0 / 7.0 * slip.mass * slip.speed)
        up = friction * slip.up / slip.speed
        # The impulse turns both balls in the same direction, about t: by R P / I.
        for ball in (contact.a,) if contact.cushion else (contact.a, contact.b):
            turn = up / (0.4 * self._masses[ball] * self._radii[ball])
            self._turns[ball, 0] -= slip.ny * turn
            self._turns[ball, 1] += slip.nx * turn

    def normal_part(self, contact: Collision, x: float, y: float) -> float:
        """Return the component of a contact's impulse along its normal [N s], not negative."""
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
        """Return the slip of the ball's surface at the cushion, at the height of its centre."""
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
        """Return the slip v + (R w) x n for a relative velocity and a sum of R w, both [m/s]."""
        (nx, ny), (vx, vy) = normal, velocity
        along = nx * vy - ny * vx + float(spin[2])
        up = float(spin[0]) * ny - float(spin[1]) * nx
        friction = self._coefficient(math.hypot(along, up), cushion=cushion)
        return _Slip(nx, ny, along, up, mass, friction)

    def _coefficient(self, slip: float, *, cushion: bool) -> float:
        if cushion:
            return self._cushion_friction
        if isinstance(self._ball_friction, str):
            # Alciatore's fit of Marlow's measurements, proof A.14, with the slip in m/s.
            return 9.951e-3 + 0.108 * math.exp(-1.088 * slip)
        return self._ball_friction
