"""One ball on the cloth until the next event: its position, and the end of its phase.

The state is the velocity v of the centre, the slip u of the lowest point on the cloth, and the
vertical spin. With u instead of the angular velocity, rolling is exactly u = 0, and an impulse
without friction changes both equally.

Slip: du/dt = -(7/2) mu_s g u/|u|, so its direction is constant and it ends after 2 |u| / (7 mu_s
g), when the cloth has reduced v by (2/7) u. Rolling: straight, with the deceleration mu_r g (Leckie
and Greenspan 2006, section 2; Alciatore, technical proofs; the paper, section 5.2).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from flint import arb

from ghostball.model import EventKind, Phase
from ghostball.reference_adapters.certified.arithmetic import (
    ZERO,
    UndecidedError,
    Vector,
    exactly,
    length,
    radius_of,
    unit,
)
from ghostball.reference_adapters.certified.drag import Roll
from ghostball.reference_adapters.certified.integrated_slide import IntegratedSlide, Integrator
from ghostball.reference_adapters.certified.problem import BallNumbers, ExactProblem

UNCOVERED = "how a ball slides in air, because a slide in air has no closed form"

EXACT_ENOUGH = 1e-13
"""Largest relative width of a state for a search in doubles; see `gaps.DOUBLES_ERROR`."""

_SMALLEST, _LARGEST = 1e-60, 1e60
"""Products of four doubles between these two bounds neither overflow nor underflow."""


class Constants(NamedTuple):
    """The constants of a ball."""

    radius: arb  # [m]
    mass: arb  # [kg]
    rolling: arb  # deceleration of a rolling ball [m/s^2]
    sliding: arb  # deceleration of a sliding ball [m/s^2]
    spinning: arb  # deceleration of vertical spin [rad/s^2]
    quadratic: arb  # b in the deceleration a + b v^2 of a rolling ball [1/m]
    drag: arb  # k in the deceleration k v^2 of a sliding ball by the air [1/m]
    gravity: arb  # [m/s^2]
    cloth_friction: arb  # coefficient of sliding friction
    table_restitution: arb
    slide: Integrator | None = None  # integrator of slides in air; None: not supported


class Doubles(NamedTuple):
    """A state in doubles, for searches with an error margin."""

    x: float
    y: float
    vx: float
    vy: float
    ax: float
    ay: float
    speed: float  # |vx| + |vy|
    pull: float  # |ax| + |ay|
    place: float  # |x| + |y|
    exact_enough: bool


class Body:
    """One ball from a given time, until its phase ends or an event changes its motion; immutable.

    `x`, `y`: centre [m].
    `vx`, `vy`: velocity [m/s].
    `ux`, `uy`: slip [m/s]; exactly 0 if the ball rolls or rests.
    `wz`: vertical spin [rad/s].
    `t`: start time [s]. Two bodies that start at the same event share this object.
    `order`: number of the start time, in order of time.
    `ax`, `ay`: acceleration at the start of the phase [m/s^2]; constant without air.
    `roll`: motion of a ball that rolls in air, or with quadratic friction, or that slides in air
        without friction.
    `slide`: motion of a ball that slides in air, if the shot is integrated.
    `duration`: duration of the phase without further events [s]; None if it doesn't end.
    """

    __slots__ = (
        "ax",
        "ay",
        "constants",
        "doubles",
        "duration",
        "end",
        "order",
        "phase",
        "roll",
        "slide",
        "t",
        "ux",
        "uy",
        "vx",
        "vy",
        "wz",
        "x",
        "y",
    )

    def __init__(
        self,
        constants: Constants,
        position: Vector,
        velocity: Vector,
        slip: Vector,
        wz: arb,
        t: arb,
        order: int,
    ) -> None:
        self.constants = constants
        self.x, self.y = position
        self.vx, self.vy = velocity
        self.ux, self.uy = slip
        self.wz = wz
        self.t = t
        self.order = order
        self.ax = self.ay = ZERO
        self.duration: arb | None = None
        self.roll: Roll | None = None
        self.slide: IntegratedSlide | None = None
        self.phase = self._start()
        self.end = math.inf if self.duration is None else float((t + self.duration).upper())
        self.doubles = self._in_doubles()

    def _start(self) -> Phase:
        """Set accelerations and duration, and return the phase.

        Raises `UndecidedError` if it can't be decided whether the ball slips, or moves.
        """
        constants = self.constants
        if not (self.ux.is_zero() and self.uy.is_zero()):
            x, y = unit(self.ux, self.uy, "whether it slides or rolls")
            if constants.sliding.is_zero():
                moves = not (self.vx.is_zero() and self.vy.is_zero())
                if moves and not constants.drag.is_zero():
                    self._start_roll(ZERO, constants.drag)
            elif not constants.drag.is_zero():
                u, v = (self.ux, self.uy), (self.vx, self.vy)
                if constants.slide is None:
                    raise UndecidedError(UNCOVERED, exact=True)
                self.slide = constants.slide(v, u, constants.sliding, constants.drag)
                self.ax, self.ay = self.slide.slowed(v, u)
                self.duration = self.slide.duration
            else:
                self.ax, self.ay = -constants.sliding * x, -constants.sliding * y
                self.duration = 2 * length(self.ux, self.uy) / (7 * constants.sliding)
            return Phase.SLIDING
        if self.vx.is_zero() and self.vy.is_zero():
            return Phase.RESTING
        x, y = self._heading
        if not constants.quadratic.is_zero():
            self._start_roll(constants.rolling, constants.quadratic)
        elif not constants.rolling.is_zero():
            self.ax, self.ay = -constants.rolling * x, -constants.rolling * y
            self.duration = length(self.vx, self.vy) / constants.rolling
        return Phase.ROLLING

    def _start_roll(self, constant: arb, quadratic: arb) -> None:
        """Start a straight motion with a constant and a quadratic deceleration."""
        x, y = self._heading
        self.roll = Roll(length(self.vx, self.vy), constant, quadratic)
        slowed = self.roll.deceleration(ZERO)
        self.ax, self.ay = -slowed * x, -slowed * y
        self.duration = self.roll.duration

    @property
    def curved(self) -> bool:
        """Whether its motion isn't a polynomial of degree 2, because of air."""
        return self.roll is not None or self.slide is not None

    @property
    def resting(self) -> bool:
        """Whether its centre rests until the next event; the ball may spin about the vertical."""
        if self.phase is Phase.SLIDING:
            slips = not self.constants.sliding.is_zero()
            return not slips and self.vx.is_zero() and self.vy.is_zero()
        return self.phase is Phase.RESTING

    @property
    def end_kind(self) -> EventKind:
        """Kind of the event at the end of the phase."""
        if self.phase is Phase.ROLLING:
            return EventKind.ROLL_TO_REST
        vx, vy = self._final_velocity()
        stops = vx.is_zero() and vy.is_zero()
        return EventKind.ROLL_TO_REST if stops else EventKind.SLIDE_TO_ROLL

    def _final_velocity(self) -> Vector:
        if self.phase is Phase.ROLLING:
            return (ZERO, ZERO)
        if self.slide is not None:
            return self.slide.final_velocity
        # A single quotient, so that equal numbers give exactly 0.
        return ((7 * self.vx - 2 * self.ux) / 7, (7 * self.vy - 2 * self.uy) / 7)

    def position_after(self, s: arb) -> Vector:
        """Return the centre after a time s of this phase [m]."""
        if s.is_zero():
            return (self.x, self.y)
        if self.roll is not None:
            return self._along(self.roll.displacement(s))
        if self.slide is not None:
            return self._beyond(self.slide.displacement(s))
        return (
            self.x + s * (self.vx + s * self.ax / 2),
            self.y + s * (self.vy + s * self.ay / 2),
        )

    def velocity_after(self, s: arb) -> Vector:
        """Return the velocity after a time s of this phase [m/s]."""
        if s.is_zero():
            return (self.vx, self.vy)
        if self.roll is not None:
            (x, y), speed = self._heading, self.roll.speed(s)
            return (speed * x, speed * y)
        if self.slide is not None:
            return self.slide.velocity(s)
        return (self.vx + s * self.ax, self.vy + s * self.ay)

    def acceleration_after(self, s: arb) -> Vector:
        """Return the acceleration after a time s of this phase [m/s^2]."""
        if s.is_zero():
            return (self.ax, self.ay)
        if self.slide is not None:
            return self.slide.acceleration(s)
        if self.roll is None:
            return (self.ax, self.ay)
        (x, y), slowed = self._heading, self.roll.deceleration(s)
        return (-slowed * x, -slowed * y)

    def _along(self, displacement: arb) -> Vector:
        """Return the centre of a ball after a rolled distance [m]."""
        x, y = self._heading
        return (self.x + displacement * x, self.y + displacement * y)

    @property
    def _heading(self) -> Vector:
        """Direction of the velocity, a unit vector."""
        return unit(self.vx, self.vy, "whether it moves or rests")

    def _beyond(self, displacement: Vector) -> Vector:
        """Return the centre of a ball after a displacement [m]."""
        return (self.x + displacement[0], self.y + displacement[1])

    def slip_after(self, s: arb) -> Vector:
        """Return the slip after a time s of this phase [m/s]."""
        if s.is_zero() or self.phase is not Phase.SLIDING:
            return (self.ux, self.uy)
        if self.slide is not None:
            return self.slide.slip(s)
        if self.roll is not None:
            vx, vy = self.velocity_after(s)
            return (self.ux + (vx - self.vx), self.uy + (vy - self.vy))
        return (self.ux + 7 * s * self.ax / 2, self.uy + 7 * s * self.ay / 2)

    def spin_after(self, s: arb) -> arb:
        """Return the vertical spin after a time s [rad/s]; it decays in every phase."""
        return decayed(self.wz, s * self.constants.spinning)

    @property
    def vertical(self) -> tuple[arb, arb, arb]:
        """Height of the centre above the cloth, upward velocity and acceleration at the start.

        In m, m/s and m/s^2. On the cloth, this is the radius and zeros.
        """
        return (self.constants.radius, ZERO, ZERO)

    def vertical_after(self, s: arb) -> tuple[arb, arb, arb]:
        """Return the same values after a time s [s]."""
        height, up, pull = self.vertical
        if pull.is_zero():
            return (height, up, pull)
        return (height + s * (up + s * pull / 2), up + s * pull, pull)

    def after_phase(self, t: arb, order: int) -> Body:
        """Return the ball after the end of its phase, at the time t.

        The displacement is the mean of both velocities times the duration.
        """
        assert self.duration is not None
        s = self.duration
        vx, vy = self._final_velocity()
        if self.roll is not None:
            assert self.roll.distance is not None
            position = self._along(self.roll.distance)
        elif self.slide is not None:
            position = self._beyond(self.slide.end)
        else:
            position = (self.x + s * (self.vx + vx) / 2, self.y + s * (self.vy + vy) / 2)
        wz = self.spin_after(s)
        return Body(self.constants, position, (vx, vy), (ZERO, ZERO), wz, t, order)

    def _in_doubles(self) -> Doubles:
        x, y, vx, vy = float(self.x), float(self.y), float(self.vx), float(self.vy)
        ax, ay = float(self.ax), float(self.ay)
        speed, pull, place = abs(vx) + abs(vy), abs(ax) + abs(ay), abs(x) + abs(y)
        most, radius = EXACT_ENOUGH, float(self.constants.radius)
        size = most * radius
        enough = (
            not self.curved
            and radius > _SMALLEST
            and place + speed + pull < _LARGEST
            and radius_of(self.x) <= size
            and radius_of(self.y) <= size
            and radius_of(self.t) * speed <= size
            and radius_of(self.t) <= most
            and radius_of(self.vx) + radius_of(self.vy) <= most * speed
            and radius_of(self.ax) + radius_of(self.ay) <= most * pull
        )
        return Doubles(x, y, vx, vy, ax, ay, speed, pull, place, enough)


def decayed(spin: arb, loss: arb) -> arb:
    """Return a spin reduced in size by `loss`, at most to 0.

    The result is monotonic in the spin and in the loss, so interval ends give the range.
    """
    if spin.is_zero():
        return ZERO
    if spin > 0:
        return arb.max(spin - loss, ZERO)
    if spin < 0:
        return arb.min(spin + loss, ZERO)
    least = loss.lower().nonnegative_part()
    top = arb.max(spin.upper() - least, ZERO)
    bottom = arb.min(spin.lower() + least, ZERO)
    return bottom.union(top)


def constants_of(
    ball: BallNumbers, problem: ExactProblem, slide: Integrator | None = None
) -> Constants:
    """Return the constants of a ball; products have the present precision."""
    gravity = arb(problem.gravity)
    # Cloth friction takes 2/7 of the air drag, but nothing for a ball that is a rolling point.
    felt = arb(problem.air_drag) * (arb(5) / 7 if problem.slides else 1)
    return Constants(
        radius=arb(ball.radius),
        mass=arb(ball.mass),
        rolling=arb(ball.rolling_friction) * gravity,
        sliding=arb(ball.sliding_friction) * gravity,
        spinning=arb(ball.spinning_friction_rate),
        quadratic=felt + arb(problem.rolling_quadratic),
        drag=arb(problem.air_drag),
        gravity=gravity,
        cloth_friction=arb(ball.sliding_friction),
        table_restitution=arb(problem.table_restitution),
        slide=slide,
    )


def body_at_start(
    ball: BallNumbers, problem: ExactProblem, slide: Integrator | None = None
) -> Body:
    """Return a ball on the cloth at t = 0."""
    return Body(
        constants_of(ball, problem, slide),
        (arb(ball.x), arb(ball.y)),
        (arb(ball.vx), arb(ball.vy)),
        slip_at_start(ball),
        arb(ball.wz),
        ZERO,
        0,
    )


def slip_at_start(ball: BallNumbers) -> Vector:
    """Return a ball's slip at t = 0 [m/s], rounded from the exact value, so that 0 is exactly 0."""
    if ball.rolls:
        return (ZERO, ZERO)
    radius = exactly(ball.radius)
    return (
        arb(exactly(ball.vx) - radius * exactly(ball.wy)),
        arb(exactly(ball.vy) + radius * exactly(ball.wx)),
    )
