"""The oracle's physics: forces and impulses at points of spheres, with mpf numbers and 3D vectors.

A body is a solid sphere whose centre stays in the plane z = 0. The cloth acts at the lowest point
of the sphere, another ball or a cushion at the point of contact; the torque is the arm times the
force. The module shares no code with the engine's laws.

Sources: Alciatore's technical proofs (motion on the cloth, throw); Wallace and Schroeder 1988;
Han 2005 (a cushion whose nose is above the centre).
"""

from __future__ import annotations

import enum
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from mpmath import mp, mpf
from numpy.typing import NDArray

Vector = NDArray[Any]
"""Three numbers of mpmath."""


def vector(x: Any, y: Any, z: Any = 0) -> Vector:
    return np.array([mpf(x), mpf(y), mpf(z)])


ZERO, UP = vector(0, 0), vector(0, 0, 1)
SIDES = (vector(-1, 0), vector(1, 0), vector(0, -1), vector(0, 1))
"""Normals into the cushions, by the cushion's index."""


Friction = tuple[Any, Any, Any]
"""A coefficient a + b exp(-c v) of the slip speed v: a, b and c."""


class Phase(enum.Enum):
    RESTING = 0  # the centre; the body may spin about the vertical
    SLIDING = 1
    ROLLING = 2


@dataclass(frozen=True)
class Body:
    """One ball at an instant."""

    position: Vector
    velocity: Vector
    spin: Vector  # angular velocity [rad/s]
    radius: Any
    mass: Any
    rolling: Any  # deceleration of a rolling ball [m/s^2]
    sliding: Any  # deceleration of a sliding ball [m/s^2]
    spinning: Any  # deceleration of vertical spin [rad/s^2]
    phase: Phase = Phase.RESTING
    final_velocity: Vector = field(
        default_factory=lambda: ZERO
    )  # velocity at the end of the present slide, without further events

    @property
    def inertia(self) -> Any:
        return 2 * self.mass * self.radius**2 / 5

    @property
    def energy(self) -> Any:
        moving, turning = self.velocity @ self.velocity, self.spin @ self.spin
        return (self.mass * moving + self.inertia * turning) / 2

    @property
    def spins(self) -> bool:
        """Whether the body has vertical spin that decays."""
        return bool(self.spin[2] != 0 and self.spinning > 0)


@dataclass(frozen=True)
class Laws:
    """Coefficients of the impacts; `friction` has three: Alciatore's curve a + b exp(-c v)."""

    always_rolls: bool
    restitution: Any
    friction: Friction
    cushion: str
    cushion_restitution: Any
    cushion_loss: Any
    cushion_tangential: Any
    cushion_friction: Any
    cushion_height: Any  # of the nose above the cloth [m]


# -- on the cloth --------------------------------------------------------------------------------


def slip(body: Body) -> Vector:
    """Return the velocity of the body's lowest point relative to the cloth."""
    return point_velocity(body, -body.radius * UP)


def point_velocity(body: Body, arm: Vector) -> Vector:
    return body.velocity + np.cross(body.spin, arm)


def rolling_spin(velocity: Vector, radius: Any, vertical: Any) -> Vector:
    """Return the angular velocity of rolling, with a given vertical component."""
    return np.cross(UP, velocity) / radius + vertical * UP


def settled(body: Body, always_rolls: bool) -> Body:
    """Return the body with the phase that follows from its velocities."""
    if always_rolls:
        spin = rolling_spin(body.velocity, body.radius, body.spin[2])
        return replace(body, spin=spin, phase=rolling_or_resting(body.velocity))
    u = slip(body)
    if norm(u) == 0:
        return replace(body, phase=rolling_or_resting(body.velocity))
    # The slip changes 7/2 times as fast as the velocity, along the same line, until it is 0.
    return replace(body, phase=Phase.SLIDING, final_velocity=body.velocity - 2 * u / 7)


def rolling_or_resting(velocity: Vector) -> Phase:
    return Phase.RESTING if norm(velocity) == 0 else Phase.ROLLING


def time_left(body: Body) -> Any:
    """Return the time until the body's phase ends without an event; infinite if it doesn't end."""
    if body.phase is Phase.SLIDING and body.sliding > 0:
        return 2 * norm(slip(body)) / (7 * body.sliding)
    if body.phase is Phase.ROLLING and body.rolling > 0:
        return norm(body.velocity) / body.rolling
    return mp.inf


def next_phase(body: Body) -> Body:
    """Return the body after the end of its phase."""
    velocity = body.final_velocity if body.phase is Phase.SLIDING else ZERO
    return replace(
        body,
        velocity=velocity,
        spin=rolling_spin(velocity, body.radius, body.spin[2]),
        phase=rolling_or_resting(velocity),
    )


def acceleration(body: Body) -> Vector:
    """Return the acceleration by cloth friction: against the slip, or against the motion."""
    if body.phase is Phase.SLIDING:
        return -body.sliding * unit(slip(body))
    if body.phase is Phase.ROLLING:
        return -body.rolling * unit(body.velocity)
    return ZERO


def angular_acceleration(body: Body) -> Vector:
    """Return the rate of change of the horizontal spin, in any phase."""
    if body.phase is Phase.SLIDING:
        force = body.mass * acceleration(body)
        return np.cross(-body.radius * UP, force) / body.inertia
    return np.cross(UP, acceleration(body)) / body.radius


def advanced(body: Body, dt: Any) -> Body:
    """Return the body after `dt` in its phase."""
    a = acceleration(body)
    spin = body.spin + dt * angular_acceleration(body)
    left = max(abs(body.spin[2]) - body.spinning * dt, mpf(0))
    return replace(
        body,
        position=body.position + dt * body.velocity + dt**2 / 2 * a,
        velocity=body.velocity + dt * a,
        spin=vector(spin[0], spin[1], left if body.spin[2] > 0 else -left),
    )


# -- impacts -------------------------------------------------------------------------------------


def contact_impulse(
    velocity: Vector, normal: Vector, mass: Any, restitution: Any, friction: Friction
) -> Vector:
    """Return the impulse that the first of two spheres gives to the second at their contact.

    `velocity`: velocity of the contact point of the first sphere relative to that of the second.
    `normal`: unit vector to the second sphere.
    `mass`: reduced mass.

    Friction acts against the slip, up to the Coulomb limit or until the slip ends. An impulse along
    the surface changes the slip by 7/2 times the change of the centre's velocity.
    """
    approach_speed = velocity @ normal
    slipping = velocity - approach_speed * normal
    speed = norm(slipping)
    push = (1 + restitution) * mass * approach_speed
    drag = min(coefficient(friction, speed) * push, 2 * mass * speed / 7)
    return push * normal + drag * unit(slipping)


def coefficient(friction: Friction, speed: Any) -> Any:
    """Return the coefficient of friction at a slip speed, a + b exp(-c v)."""
    constant, part, rate = friction
    return constant if part == 0 else constant + part * mp.exp(-rate * speed)


def struck(body: Body, arm: Vector, impulse: Vector) -> Body:
    """Return the body after an impulse at the end of `arm`, without its vertical velocity."""
    velocity = body.velocity + impulse / body.mass
    return replace(
        body,
        velocity=velocity - velocity[2] * UP,
        spin=body.spin + np.cross(arm, impulse) / body.inertia,
    )


def collided(a: Body, b: Body, laws: Laws) -> tuple[Body, Body]:
    """Return both bodies after they hit each other."""
    normal = unit(b.position - a.position)
    arm_a, arm_b = a.radius * normal, -b.radius * normal
    impulse = contact_impulse(
        point_velocity(a, arm_a) - point_velocity(b, arm_b),
        normal,
        a.mass * b.mass / (a.mass + b.mass),
        laws.restitution,
        laws.friction,
    )
    return (
        settled(struck(a, arm_a, -impulse), laws.always_rolls),
        settled(struck(b, arm_b, impulse), laws.always_rolls),
    )


def bounced(body: Body, side: Vector, laws: Laws) -> Body:
    """Return the body after it hit the cushion that `side` points into."""
    e = laws.cushion_restitution / (1 + laws.cushion_loss * mp.sqrt(abs(body.velocity @ side)))
    if laws.cushion in ("mirror", "restitution"):
        into = (body.velocity @ side) * side
        along = body.velocity - into
        velocity = laws.cushion_tangential * along - e * into
        return settled(replace(body, velocity=velocity), laws.always_rolls)
    # The contact point is at the height of the centre ("frictional") or of the nose (Han).
    height = laws.cushion_height - body.radius if laws.cushion == "han2005" else mpf(0)
    arm = mp.sqrt(body.radius**2 - height**2) * side + height * UP
    impulse = contact_impulse(
        point_velocity(body, arm),
        unit(arm),
        body.mass,
        e,
        (laws.cushion_friction, mpf(0), mpf(0)),
    )
    return settled(struck(body, arm, -impulse), laws.always_rolls)


# -- vectors -------------------------------------------------------------------------------------


def norm(a: Vector) -> Any:
    return mp.sqrt(a @ a)


def unit(a: Vector) -> Vector:
    length = norm(a)
    return a if length == 0 else a / length
