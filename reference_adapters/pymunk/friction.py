"""Friction of balls that spin in space, on Chipmunk's discs, which spin about the vertical only.

Two surfaces in contact slip along the contact, in Chipmunk's plane, and up or down, where balls
roll. Coulomb friction acts against the whole slip U: its impulse is min(mu J, (2/7) m_r U), J the
normal impulse and m_r the reduced mass [Alciatore, proof A.14]. Chipmunk sees the part along the
contact, U_t, alone, and without the rest would throw a rolling ball too far. Given the coefficient
mu |U_t| / U, what Chipmunk solves is just the part along the contact of that impulse, whether the
surfaces slip or stick: both of its limits, mu J and (2/7) m_r U, then shrink in the same
proportion. The part up or down moves no ball that the cloth holds, but turns it: that is added
here, from Chipmunk's J.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import CUSHIONS, Scene

if TYPE_CHECKING:
    import pymunk

FloatArray = NDArray[np.float64]


class _Slip(NamedTuple):
    """The slip of a ball's surface over what it touches.

    Attributes
    ----------
    nx, ny : float
        Unit normal from the ball to what it touches.
    along, up : float
        Slip along t = z x n, and up [m/s].
    mass : float
        Reduced mass [kg]; the ball's own at a cushion.
    friction : float
        Coefficient for the whole slip [1].
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
    """Friction at the contacts of a world: its spins, its coefficients, what turns its balls.

    For each step call `set_spins` before, `prepare` and `note` from Chipmunk's callbacks before and
    after it solves a contact, and `turns` after the step.
    """

    def __init__(self, scene: Scene, bodies: list[pymunk.Body]) -> None:
        physics = scene.physics
        self._bodies = bodies
        self._radii = scene.radii.tolist()
        self._masses = scene.masses.tolist()
        self._ball_friction = physics.ball_friction
        frictional = physics.cushion == "frictional"
        self._cushion_friction = physics.cushion_friction if frictional else 0.0
        self._spins = scene.angular_velocities
        self._turns = np.zeros_like(self._spins)
        self._slips: dict[tuple[int, int, bool], _Slip] = {}

    @staticmethod
    def needed(scene: Scene) -> bool:
        """Whether anything rubs in a scene."""
        between_balls = scene.physics.ball_friction != 0.0 and len(scene.balls) > 1
        return between_balls or (scene.physics.cushion == "frictional" and scene.table is not None)

    def set_spins(self, spins: FloatArray) -> None:
        """Take over the angular velocities, (n, 3) float64 [rad/s]; Chipmunk gets the vertical."""
        self._spins = spins
        self._turns = np.zeros_like(spins)
        self._slips.clear()
        for body, spin in zip(self._bodies, spins[:, 2].tolist(), strict=True):
            body.angular_velocity = spin

    def turns(self) -> FloatArray:
        """Return what the step's contacts added to the angular velocities, (n, 3) [rad/s]."""
        turns = self._turns.copy()
        turns[:, 2] = [body.angular_velocity for body in self._bodies] - self._spins[:, 2]
        return turns

    def prepare(self, arbiter: pymunk.Arbiter, a: int, b: int, *, cushion: bool) -> None:
        """Set the coefficient of a contact of ball `a` with ball or cushion `b`."""
        slip = self._cushion_slip(a, b) if cushion else self._ball_slip(a, b)
        self._slips[a, b, cushion] = slip
        share = abs(slip.along) / slip.speed if slip.speed > 0.0 else 1.0
        arbiter.friction = slip.friction * share

    def note(self, arbiter: pymunk.Arbiter, a: int, b: int, *, cushion: bool) -> None:
        """Turn the balls by the part up or down of the friction of a contact that was solved."""
        slip = self._slips[a, b, cushion]
        if slip.up == 0.0:
            return
        impulse = arbiter.total_impulse
        normal = abs(slip.nx * impulse.x + slip.ny * impulse.y)
        friction = min(slip.friction * normal, 2.0 / 7.0 * slip.mass * slip.speed)
        up = friction * slip.up / slip.speed
        # Both ends of the impulse turn the balls the same way, about t: by R P / I.
        for ball in (a,) if cushion else (a, b):
            turn = up / (0.4 * self._masses[ball] * self._radii[ball])
            self._turns[ball, 0] -= slip.ny * turn
            self._turns[ball, 1] += slip.nx * turn

    def _ball_slip(self, a: int, b: int) -> _Slip:
        """Return the slip of the surface of ball `a` over that of `b`."""
        body_a, body_b = self._bodies[a], self._bodies[b]
        line = body_b.position - body_a.position
        normal = line / line.length
        apart = body_a.velocity - body_b.velocity
        spin = self._radii[a] * self._spins[a] + self._radii[b] * self._spins[b]
        mass = self._masses[a] * self._masses[b] / (self._masses[a] + self._masses[b])
        return self._slip(normal.x, normal.y, apart.x, apart.y, spin, mass, cushion=False)

    def _cushion_slip(self, ball: int, cushion: int) -> _Slip:
        """Return the slip of the surface of `ball` over the cushion, at the centre's height."""
        nx, ny = {"left": (-1, 0), "right": (1, 0), "bottom": (0, -1), "top": (0, 1)}[
            CUSHIONS[cushion]
        ]
        velocity = self._bodies[ball].velocity
        spin = self._radii[ball] * self._spins[ball]
        return self._slip(nx, ny, velocity.x, velocity.y, spin, self._masses[ball], cushion=True)

    def _slip(
        self,
        nx: float,
        ny: float,
        vx: float,
        vy: float,
        spin: FloatArray,
        mass: float,
        *,
        cushion: bool,
    ) -> _Slip:
        """Return the slip v + (R w) x n of a relative velocity and a sum of R w, both [m/s]."""
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
