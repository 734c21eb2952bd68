"""The stroke of a cue: what is typed of it, and the velocities that it gives a ball.

The tip hits the ball at one point, where it doesn't slip, and gives it one impulse J at one
instant. In the cue's frame, d along its motion, l to the left of it and p up across it, the point
is R n from the centre, n = (-sqrt(1 - A^2 - B^2), A, B), A and B being the offsets in radii. The
tip moves as the masses (M, m_e, m_e) along (d, l, p). Across the cue it stays with the point of the
ball; along the cue they approach at V and part at e V:

    (K + diag(1/M, 1/m_e, 1/m_e)) J = ((1 + e) V, 0, 0),  K = (7/2 - (5/2) n n^T) / m.

M is the cue's mass and m_e its end mass: what of the shaft moves sideways within the contact. A cue
that gives way across its axis (m_e = 0, no squirt) leaves J along d, and the equation is that of
Leckie and Greenspan (2006, equation 1) and of Alciatore (technical proof A.30, equation 2) for any
restitution e of the tip. With an end mass and B = 0 it has the squirt angle of Alciatore's proof
A.31. The velocity is J / m, the angular velocity (5 / 2 R) n x J / m.

The defaults are a cue of 20 ounces; Alciatore's constants of a leather tip, e 0.71 to 0.75 and a
friction of 0.6; and the end mass of the median of 46 shafts that Platinum Billiards measured, by
their pivot lengths L, of 7.6 to 14.1 inches: L = (2/5) R (7/2 + m / m_e), with 9.4 inches.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, NamedTuple, Self

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from ghostball.model.scene.fields import (
    LARGEST,
    Fraction,
    NonNegative,
    Positive,
    Real,
    in_degrees,
    problem,
)
from ghostball.model.scene.part import Part
from ghostball.model.sines import cosines_and_sines

Vector = tuple[float, float, float]
"""Along x, y and up, or along d, l and p."""

FASTEST_CUE = LARGEST / 10.0
"""Largest speed of a cue [m/s]: a ball leaves it at no more than twice that speed, and its surface
turns at no more than five times."""

_STICKING = 2.0 / 7.0
"""Impulse over the mass that ends a slip of 1, of a solid sphere."""


def _one_turn(value: float) -> float:
    if not -2.0 * math.pi <= value <= 2.0 * math.pi:
        raise problem(
            "direction",
            f"must be an angle from -2 pi to 2 pi, got {value:g}. {in_degrees(value)}",
        )
    return value


def _from_above(value: float) -> float:
    if value < 0.0:
        raise problem(
            "from_below",
            f"must be at least 0, got {value:g}: the cue would come from below the cloth. Raise "
            "its butt; a lower offset_up hits the ball lower",
        )
    if value >= 0.5 * math.pi:
        raise problem(
            "elevation",
            f"must be less than pi / 2, where the cue stands upright, got {value:g}. "
            f"{in_degrees(value)}",
        )
    return value


class Strike(Part):
    """The stroke of a cue at a ball that rests on the cloth.

    Lengths of offsets are in radii of the ball, across the cue: whoever looks along it sees them.
    """

    speed: Annotated[Positive, Field(le=FASTEST_CUE)] = Field(
        description="of the cue when it hits the ball, along its axis [m/s]"
    )
    direction: Annotated[Real, AfterValidator(_one_turn)] = Field(
        description="of the cue, seen from above: from the x axis, counterclockwise [rad]"
    )
    elevation: Annotated[Real, AfterValidator(_from_above)] = Field(
        default=0.0, description="of the cue's butt above the level [rad]"
    )
    offset_left: Real = Field(
        default=0.0,
        description="of the point that is hit from the centre, to the left; negative to the right "
        "[radii]",
    )
    offset_up: Real = Field(
        default=0.0,
        description="of the point that is hit from the centre, up across the cue; negative down "
        "[radii]",
    )
    cue_mass: Positive = Field(default=0.567, description="[kg]")
    tip_restitution: Fraction = Field(default=0.73, description="restitution of tip and ball [1]")
    tip_friction: NonNegative = Field(
        default=0.6, description="coefficient of friction of tip and ball [1]; beyond it: a miscue"
    )
    squirt: Literal["end-mass", "alciatore", "none"] = Field(
        default="end-mass",
        description='what the cue does to the direction: "end-mass": its end has a mass across the '
        'cue; "alciatore": the velocity is turned by the angle of proof A.31; "none"',
    )
    end_mass: Positive = Field(
        default=0.0098,
        description="mass of the cue's end across the cue, for squirt [kg]",
    )

    @model_validator(mode="after")
    def _hits_the_ball(self) -> Self:
        left, up = self.offset_left, self.offset_up
        offset = math.sqrt(left * left + up * up)
        point = f"offset_left {left:g} and offset_up {up:g}"
        most = self.tip_friction / math.sqrt(1.0 + self.tip_friction**2)
        if offset >= 1.0:
            raise problem(
                "beside",
                f"must hit the ball, got {point}: {offset:.6g} radii from its centre is beside it. "
                "Give the offsets in radii of the ball, below 1",
            )
        if offset > most:
            raise problem(
                "miscue",
                f"must hit the ball no further from its centre than the tip's friction holds, "
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
                    "no_effect",
                    f"has no use for end_mass = {self.end_mass} where squirt is none. Leave it "
                    'out, or set squirt = "end-mass" or "alciatore"',
                    at=("end_mass",),
                )
        elif self.end_mass > self.cue_mass:
            raise problem(
                "end_mass",
                f"must have an end_mass of at most its cue_mass, {self.cue_mass} kg, got "
                f"{self.end_mass} kg. Give both in kilograms; ends have 0.006 to 0.013",
                at=("end_mass",),
            )
        return self


class Stroke(NamedTuple):
    """What a strike does, before the table answers to it."""

    velocity: Vector
    """Of the ball's centre [m/s]."""
    angular_velocity: Vector
    """[rad/s]."""
    cue_speed: float
    """Of the cue afterwards, along its axis [m/s]."""


def stroke_of(strike: Strike, radius: float, mass: float) -> Stroke:
    """Return what a strike does to a ball of a radius [m] and a mass [kg].

    By + - * / and square roots alone, so that every machine begins with the same bits.
    """
    left, up = strike.offset_left, strike.offset_up
    n = (-math.sqrt(1.0 - (left * left + up * up)), left, up)
    x = _impulse(strike, n, mass)
    turn = 2.5 / radius
    w = (
        turn * (n[1] * x[2] - n[2] * x[1]),
        turn * (n[2] * x[0] - n[0] * x[2]),
        turn * (n[0] * x[1] - n[1] * x[0]),
    )
    cosines, sines = cosines_and_sines(np.array([strike.direction, strike.elevation]))
    plan, lift = ((float(cosines[k]), float(sines[k])) for k in (0, 1))
    velocity = _to_world(x, plan, lift)
    if strike.squirt == "alciatore":
        velocity = _turned(velocity, _tangent_of_squirt(left, mass / strike.end_mass))
    after = strike.speed - mass / strike.cue_mass * x[0]
    return Stroke(velocity, _to_world(w, plan, lift), after)


def _impulse(strike: Strike, n: Vector, mass: float) -> Vector:
    """Return J / m along d, l and p [m/s], by the formula of Sherman and Morrison."""
    along = 1.0 / (3.5 + mass / strike.cue_mass)
    across = 1.0 / (3.5 + mass / strike.end_mass) if strike.squirt == "end-mass" else 0.0
    change = (1.0 + strike.tip_restitution) * strike.speed
    turning = along * n[0] * n[0] + across * (n[1] * n[1] + n[2] * n[2])
    pull = 2.5 * n[0] * along * change / (1.0 - 2.5 * turning)
    return along * (change + pull * n[0]), across * pull * n[1], across * pull * n[2]


def _to_world(v: Vector, plan: tuple[float, float], lift: tuple[float, float]) -> Vector:
    """Return a vector along d, l and p along x, y and up; by cosine and sine of both angles."""
    forward = lift[0] * v[0] + lift[1] * v[2]
    return (
        plan[0] * forward - plan[1] * v[1],
        plan[1] * forward + plan[0] * v[1],
        lift[0] * v[2] - lift[1] * v[0],
    )


def _tangent_of_squirt(left: float, ratio: float) -> float:
    """Return the tangent of the angle, to the right, of Alciatore's technical proof A.31.

    `ratio`: the mass of the ball over that of the cue's end.
    """
    behind = 1.0 - left * left
    return 2.5 * left * math.sqrt(behind) / (1.0 + ratio + 2.5 * behind)


def _turned(v: Vector, tangent: float) -> Vector:
    """Return a vector turned to the right, seen from above, by the angle of a tangent."""
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    x, y, z = v
    return cosine * (x + tangent * y), cosine * (y - tangent * x), z


def bounced(
    velocity: Vector, spin: Vector, radius: float, friction: float, restitution: float
) -> tuple[Vector, Vector]:
    """Return velocity and spin of a ball that is pushed into the table, after the table answered.

    By the law of a landing: the speed downwards is returned `restitution` times, with the friction
    of the cloth, which ends the slip or is the coefficient `friction` times the impulse upwards.
    """
    vx, vy, vz = velocity
    wx, wy, wz = spin
    ux, uy = vx - radius * wy, vy + radius * wx
    slip = math.sqrt(ux * ux + uy * uy)
    most = friction * (1.0 + restitution) * -vz
    part = min(most / slip, _STICKING) if slip > 0.0 else 0.0
    turn = 2.5 * part / radius
    return (
        (vx - part * ux, vy - part * uy, restitution * -vz),
        (wx - turn * uy, wy + turn * ux, wz),
    )
