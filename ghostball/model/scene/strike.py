"""The stroke of a cue: its fields, and the velocities that one or many strokes give a ball.

The tip hits the ball at one point without slip and transfers one impulse J at one instant. In the
cue's frame, d is along its motion, l to the left and p upwards, perpendicular to the cue. The point
is at R n from the centre, n = (-sqrt(1 - A^2 - B^2), A, B), with the offsets A and B in radii. The
tip responds with the masses (M, m_e, m_e) along (d, l, p). Perpendicular to the cue, the tip moves
with the point of the ball; along the cue, tip and ball approach at V and separate at e V:

    (K + diag(1/M, 1/m_e, 1/m_e)) J = ((1 + e) V, 0, 0),  K = (7/2 - (5/2) n n^T) / m.

M is the mass of the cue. m_e is its end mass: the part of the shaft that moves sideways during the
contact. With m_e = 0 (no squirt), J is along d, and the equation is that of Leckie and Greenspan
(2006, equation 1) and of Alciatore (technical proof A.30, equation 2) for any restitution e of the
tip. With an end mass and B = 0, it has the squirt angle of Alciatore's proof A.31. The velocity is
J / m, the angular velocity (5 / 2 R) n x J / m.

The defaults are: a cue of 20 ounces; Alciatore's constants for a leather tip, e from 0.71 to 0.75
and a friction of 0.6; and the end mass of the median of 46 shafts measured by Platinum Billiards.
Their pivot lengths L are 7.6 to 14.1 inches, and L = (2/5) R (7/2 + m / m_e), with a median of
9.4 inches.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, NamedTuple, Self

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from ghostball.model.arrays import BoolArray, FloatArray
from ghostball.model.scene.fields import (
    LARGEST,
    SMALLEST,
    Fraction,
    NonNegative,
    Positive,
    Real,
    in_degrees,
    problem,
)
from ghostball.model.scene.part import ScenePart
from ghostball.model.sines import cosines_and_sines

Vector = tuple[float, float, float]
"""Components along x, y and up."""

Components = tuple[FloatArray, FloatArray, FloatArray]
"""Components of k vectors along x, y and up, or along d, l and p, (k,) each."""

FASTEST_CUE = LARGEST / 10.0
"""Largest speed of a cue [m/s]. The ball leaves the cue at no more than twice this speed, with a
surface speed of at most five times this speed."""

_IMPULSE_TO_STICK = 2.0 / 7.0
"""Impulse over mass that ends a slip speed of 1, for a solid sphere."""


def _one_turn(value: float) -> float:
    if not -2.0 * math.pi <= value <= 2.0 * math.pi:
        raise problem(
            f"must be an angle from -2 pi to 2 pi, got {value:g}. {in_degrees(value)}",
        )
    return value


def _from_above(value: float) -> float:
    if value < 0.0:
        raise problem(
            f"must be at least 0, got {value:g}: the cue would start below the cloth. Raise the "
            "butt; to hit the ball lower, lower offset_up",
        )
    if value >= 0.5 * math.pi:
        raise problem(
            f"must be less than pi / 2, where the cue stands upright, got {value:g}. "
            f"{in_degrees(value)}",
        )
    return value


class Strike(ScenePart):
    """The stroke of a cue at a ball that rests on the cloth.

    Offsets are in ball radii, perpendicular to the cue, as seen along it.
    """

    speed: Annotated[Positive, Field(le=FASTEST_CUE)] = Field(
        description="speed of the cue along its axis when it hits the ball [m/s]"
    )
    direction: Annotated[Real, AfterValidator(_one_turn)] = Field(
        description="direction of the cue seen from above, counterclockwise from the x axis [rad]"
    )
    elevation: Annotated[Real, AfterValidator(_from_above)] = Field(
        default=0.0, description="angle of the cue to the horizontal, butt up [rad]"
    )
    offset_left: Real = Field(
        default=0.0,
        description="offset of the contact point from the centre, to the left; negative: to the "
        "right [radii]",
    )
    offset_up: Real = Field(
        default=0.0,
        description="offset of the contact point from the centre, upwards; negative: downwards "
        "[radii]",
    )
    cue_mass: Positive = Field(default=0.567, description="mass of the cue [kg]")
    tip_restitution: Fraction = Field(default=0.73, description="restitution of tip and ball [1]")
    tip_friction: NonNegative = Field(
        default=0.6, description="coefficient of friction of tip and ball [1]; limits the offset"
    )
    squirt: Literal["end-mass", "alciatore", "none"] = Field(
        default="end-mass",
        description='model of squirt: "end-mass": the end of the cue has a sideways mass; '
        '"alciatore": the velocity is turned by the angle of proof A.31; "none"',
    )
    end_mass: Positive = Field(
        default=0.0098,
        description="sideways mass of the end of the cue, for squirt [kg]",
    )

    @model_validator(mode="after")
    def _hits_the_ball(self) -> Self:
        left, up = self.offset_left, self.offset_up
        offset = math.sqrt(left * left + up * up)
        point = f"offset_left {left:g} and offset_up {up:g}"
        most = _largest_offset(self.tip_friction)
        if offset >= 1.0:
            raise problem(
                f"must hit the ball, got {point}: {offset:.6g} radii from its centre is outside. "
                "Give the offsets in radii of the ball, below 1",
            )
        if offset > most:
            raise problem(
                f"must hit the ball within the miscue limit, "
                f"tip_friction / sqrt(1 + tip_friction^2) = {most:.6g} radii, got {point}: "
                f"{offset:.6g} radii is a miscue. Hit nearer to the centre, or raise "
                f"tip_friction = {self.tip_friction:g}",
            )
        return self

    @model_validator(mode="after")
    def _has_an_end(self) -> Self:
        if self.squirt == "none":
            if self.end_mass != type(self).model_fields["end_mass"].default:
                raise problem(
                    f'has end_mass = {self.end_mass}, which has no effect with squirt = "none". '
                    'Remove end_mass, or set squirt = "end-mass" or "alciatore"',
                    at=("end_mass",),
                )
        elif self.end_mass > self.cue_mass:
            raise problem(
                f"must have an end_mass of at most its cue_mass, {self.cue_mass} kg, got "
                f"{self.end_mass} kg. Give both in kilograms; ends have 0.006 to 0.013",
                at=("end_mass",),
            )
        return self


class Stroke(NamedTuple):
    """The result of a strike, before the reaction of the table."""

    velocity: Vector
    """Velocity of the centre of the ball [m/s]."""
    angular_velocity: Vector
    """Angular velocity of the ball [rad/s]."""
    cue_speed: float
    """Speed of the cue after the stroke, along its axis [m/s]."""


class Aims(NamedTuple):
    """The fields of `Strike` that differ between k strokes of one cue, (k,) float64 each."""

    speed: FloatArray
    direction: FloatArray
    elevation: FloatArray
    offset_left: FloatArray
    offset_up: FloatArray


def aims_of(strike: Strike) -> Aims:
    """Return the fields of one strike, as arrays of one element."""
    return Aims(*(np.array([getattr(strike, name)]) for name in Aims._fields))


def are_valid(cue: Strike, aims: Aims) -> BoolArray:
    """Return which strokes of a cue keep the rules of `Strike`, (k,) bool; NaN keeps none.

    The masses, the tip and the squirt are those of `cue`.
    """
    speed, direction, elevation, left, up = aims
    found: BoolArray = (speed >= SMALLEST) & (speed <= FASTEST_CUE)
    found &= np.abs(direction) <= 2.0 * math.pi
    found &= (elevation >= 0.0) & (elevation < 0.5 * math.pi)
    with np.errstate(over="ignore"):
        offset = np.sqrt(left * left + up * up)
    return found & (offset < 1.0) & (offset <= _largest_offset(cue.tip_friction))


def _largest_offset(tip_friction: float) -> float:
    """Return the miscue limit [radii]."""
    return tip_friction / math.sqrt(1.0 + tip_friction**2)


def stroke_of(strike: Strike, radius: float, mass: float) -> Stroke:
    """Return the result of a strike at a ball of a radius [m] and a mass [kg]."""
    velocity, spin, cue_speed = strokes_of(strike, aims_of(strike), radius, mass)
    return Stroke(vector(velocity[0]), vector(spin[0]), float(cue_speed[0]))


def vector(components: FloatArray) -> Vector:
    """Return an array (3,) as a tuple of floats."""
    x, y, z = components.tolist()
    return x, y, z


def strokes_of(
    cue: Strike, aims: Aims, radius: float, mass: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the results of k strokes of a cue at a ball of a radius [m] and a mass [kg].

    Returns the velocities (k, 3) [m/s] and angular velocities (k, 3) [rad/s] of the ball, and the
    speeds of the cue (k,) [m/s], as in `Stroke`.

    Only + - * / and square roots are used, so the bits are the same on every machine.
    """
    left, up = aims.offset_left, aims.offset_up
    n = (-np.sqrt(1.0 - (left * left + up * up)), left, up)
    x = _impulse(cue, aims.speed, n, mass)
    turn = 2.5 / radius
    w = (
        turn * (n[1] * x[2] - n[2] * x[1]),
        turn * (n[2] * x[0] - n[0] * x[2]),
        turn * (n[0] * x[1] - n[1] * x[0]),
    )
    cosines, sines = cosines_and_sines(np.stack((aims.direction, aims.elevation)))
    plan, lift = (cosines[0], sines[0]), (cosines[1], sines[1])
    velocity = _to_world(x, plan, lift)
    if cue.squirt == "alciatore":
        velocity = _turned(velocity, _tangent_of_squirt(left, mass / cue.end_mass))
    after = aims.speed - mass / cue.cue_mass * x[0]
    return np.stack(velocity, axis=1), np.stack(_to_world(w, plan, lift), axis=1), after


def _impulse(cue: Strike, speed: FloatArray, n: Components, mass: float) -> Components:
    """Return J / m along d, l and p [m/s], with the Sherman-Morrison formula."""
    along = 1.0 / (3.5 + mass / cue.cue_mass)
    across = 1.0 / (3.5 + mass / cue.end_mass) if cue.squirt == "end-mass" else 0.0
    change = (1.0 + cue.tip_restitution) * speed
    turning = along * n[0] * n[0] + across * (n[1] * n[1] + n[2] * n[2])
    pull = 2.5 * n[0] * along * change / (1.0 - 2.5 * turning)
    return along * (change + pull * n[0]), across * pull * n[1], across * pull * n[2]


def _to_world(
    v: Components, plan: tuple[FloatArray, FloatArray], lift: tuple[FloatArray, FloatArray]
) -> Components:
    """Return the components along x, y and up of vectors given along d, l and p.

    `plan`, `lift`: cosines and sines of the directions and of the elevations.
    """
    forward = lift[0] * v[0] + lift[1] * v[2]
    return (
        plan[0] * forward - plan[1] * v[1],
        plan[1] * forward + plan[0] * v[1],
        lift[0] * v[2] - lift[1] * v[0],
    )


def _tangent_of_squirt(left: FloatArray, ratio: float) -> FloatArray:
    """Return the tangents of the squirt angles, to the right, of Alciatore's technical proof A.31.

    `ratio`: mass of the ball over the end mass of the cue.
    """
    behind = 1.0 - left * left
    return 2.5 * left * np.sqrt(behind) / (1.0 + ratio + 2.5 * behind)


def _turned(v: Components, tangent: FloatArray) -> Components:
    """Return vectors turned to the right, seen from above, by angles with the given tangents."""
    cosine = 1.0 / np.sqrt(1.0 + tangent * tangent)
    x, y, z = v
    return cosine * (x + tangent * y), cosine * (y - tangent * x), z


def bounced(
    velocity: FloatArray, spin: FloatArray, radius: float, friction: float, restitution: float
) -> tuple[FloatArray, FloatArray]:
    """Return velocities and spins, (k, 3) each, after the table's reaction to strokes.

    The law is that of a landing: the downward speed is reversed and multiplied by `restitution`.
    The friction of the cloth ends the slip, or is the coefficient `friction` times the upward
    impulse if that is less. A ball that isn't pushed into the table keeps its velocity and spin.
    """
    vx, vy, vz = velocity.T
    wx, wy, wz = spin.T
    ux, uy = vx - radius * wy, vy + radius * wx
    slip = np.sqrt(ux * ux + uy * uy)
    most = friction * (1.0 + restitution) * -vz
    with np.errstate(over="ignore"):  # of a tiny slip
        part = np.minimum(most / np.where(slip > 0.0, slip, 1.0), _IMPULSE_TO_STICK)
    turn = 2.5 * part / radius
    pushed = (vz < 0.0)[:, np.newaxis]
    after = np.stack((vx - part * ux, vy - part * uy, restitution * -vz), axis=1)
    turned = np.stack((wx - turn * uy, wy + turn * ux, wz), axis=1)
    return np.where(pushed, after, velocity), np.where(pushed, turned, spin)
