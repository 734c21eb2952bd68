"""A ball above the cloth until the next event, and the reaction of the table when it lands.

The state is that of `motion`, with the height in addition. In flight only gravity acts, so the
velocity along the cloth, the slip and the spin are constant, and the path is a parabola that ends
on the table. The table returns e times the downward speed. Friction changes the velocity by
mu (1 + e) times the downward speed, against the slip, but at most by 2/7 of the slip, which ends
the slip (Alciatore, technical proof B.5; the slip changes by 7/2 of the change of the velocity).

Bounces lower than `LOWEST_BOUNCE` are no separate events: in the model, all remaining bounces are
one motion along the cloth. They form a geometric series, whose duration, distance and loss of slip
have closed forms.
"""

from __future__ import annotations

from typing import NamedTuple

from flint import arb

from ghostball.model import EventKind, Phase
from ghostball.reference_adapters.certified.arithmetic import (
    ONE,
    ZERO,
    UndecidedError,
    Vector,
    exactly,
    length,
    radius_of,
)
from ghostball.reference_adapters.certified.motion import (
    EXACT_ENOUGH,
    Body,
    Constants,
    Doubles,
    body_at_start,
    constants_of,
    slip_at_start,
)
from ghostball.reference_adapters.certified.problem import BallNumbers, ExactProblem

LOWEST_BOUNCE = 2.0**-24
"""Height, in diameters, below which bounces are one motion: 3e-9 m for pool balls."""

HEIGHT_ROUNDING = 2.0**-37
"""Difference of heights, in units of `LOWEST_BOUNCE`, that an engine in doubles can't resolve.

For example, a ball that falls by its diameter on a table with a restitution of 1/2 reaches exactly
the height `LOWEST_BOUNCE`.
"""


class FlightState(NamedTuple):
    """The state of a ball at a time, with its height; slip and spin as in `motion.Body`."""

    place: Vector  # [m]
    rise: arb  # height of its lowest point above the cloth [m]; exactly 0 on the cloth
    velocity: Vector  # [m/s]
    up: arb  # velocity upwards [m/s]
    slip: Vector  # [m/s]
    wz: arb  # [rad/s]


class FlyingBody(Body):
    """A ball in the air, until it lands or an event changes its motion; immutable.

    `rise`: height of its lowest point above the cloth [m].
    `up`: upward velocity [m/s].
    """

    __slots__ = ("rise", "up")

    def __init__(self, constants: Constants, state: FlightState, t: arb, order: int) -> None:
        self.rise, self.up = state.rise, state.up
        super().__init__(constants, state.place, state.velocity, state.slip, state.wz, t, order)

    def _start(self) -> Phase:
        gravity = self.constants.gravity
        fall = self._speed_of_fall()
        if self.up < 0:  # without cancellation
            self.duration = 2 * self.rise / (fall - self.up)
        else:
            self.duration = (fall + self.up) / gravity
        return Phase.FLYING

    def _speed_of_fall(self) -> arb:
        if self.rise.is_zero():
            return self.up
        return (self.up * self.up + 2 * self.constants.gravity * self.rise).sqrt()

    @property
    def end_kind(self) -> EventKind:
        """Kind of the event at the end of the flight."""
        return EventKind.BALL_CLOTH

    @property
    def vertical(self) -> tuple[arb, arb, arb]:
        """Height of the centre, upward velocity and acceleration; see `Body.vertical`."""
        return (self.constants.radius + self.rise, self.up, -self.constants.gravity)

    def spin_after(self, s: arb) -> arb:  # noqa: ARG002 - constant
        """Return the vertical spin [rad/s], which is constant in the air."""
        return self.wz

    def after_phase(self, t: arb, order: int) -> Body:
        """Return the ball after the reaction of the table."""
        assert self.duration is not None
        s = self.duration
        place, fall = self.position_after(s), self._speed_of_fall()
        state = FlightState(place, ZERO, (self.vx, self.vy), -fall, (self.ux, self.uy), self.wz)
        return answered_by_table(self.constants, state, t, order)

    def _in_doubles(self) -> Doubles:
        doubles = super()._in_doubles()
        up, size = abs(float(self.up)), EXACT_ENOUGH * float(self.constants.radius)
        enough = (
            doubles.exact_enough
            and radius_of(self.rise) <= size
            and radius_of(self.t) * (up + float(self.constants.gravity)) <= size
            and radius_of(self.up) <= EXACT_ENOUGH * (doubles.speed + up)
        )
        return doubles._replace(
            speed=doubles.speed + up,
            pull=doubles.pull + float(self.constants.gravity),
            place=doubles.place + float(self.constants.radius + self.rise),
            exact_enough=enough,
        )


class BouncingBody(Body):
    """A ball whose bounces are too low to be resolved, until they end; immutable.

    It moves along the cloth in a straight line, with the mean velocity and the corresponding slip.
    """

    __slots__ = ("_lasts", "_slip_left", "_velocity_left")

    def __init__(self, constants: Constants, state: FlightState, t: arb, order: int) -> None:
        e, (ux, uy) = constants.table_restitution, state.slip
        self._lasts = 2 * state.up / (constants.gravity * (1 - e))
        loss = _loss_in_bounces(constants, state.up, self._lasts, length(ux, uy))
        self._velocity_left = _less(state.velocity, loss.part, state.slip)
        self._slip_left = _less(state.slip, 7 * loss.part / 2, state.slip)
        if loss.all:
            self._slip_left = (ZERO, ZERO)
        super().__init__(
            constants,
            state.place,
            _less(state.velocity, loss.mean, state.slip),
            _less(state.slip, 7 * loss.mean / 2, state.slip),
            state.wz,
            t,
            order,
        )

    def _start(self) -> Phase:
        self.duration = self._lasts
        return Phase.SLIDING

    @property
    def resting(self) -> bool:
        """Whether its centre rests until the next event: False, because its bounces end first."""
        return False

    @property
    def end_kind(self) -> EventKind:
        """Kind of the event at the end of the bounces."""
        return EventKind.BALL_CLOTH

    def after_phase(self, t: arb, order: int) -> Body:
        """Return the ball as it continues along the cloth."""
        s = self._lasts
        return Body(
            self.constants,
            self.position_after(s),
            self._velocity_left,
            self._slip_left,
            self.spin_after(s),
            t,
            order,
        )


class GoneBody(Body):
    """A ball that has left the table: it doesn't move, and nothing meets it."""

    __slots__ = ("rise",)

    def __init__(self, constants: Constants, place: Vector, rise: arb, t: arb, order: int) -> None:
        self.rise = rise
        still = (ZERO, ZERO)
        super().__init__(constants, place, still, still, ZERO, t, order)

    def _start(self) -> Phase:
        return Phase.GONE

    @property
    def resting(self) -> bool:
        """Whether its centre rests until the next event: True."""
        return True

    @property
    def vertical(self) -> tuple[arb, arb, arb]:
        """Height of the centre, upward velocity and acceleration; see `Body.vertical`."""
        return (self.constants.radius + self.rise, ZERO, ZERO)


def body_in_space_at_start(ball: BallNumbers, problem: ExactProblem) -> Body:
    """Return a ball of an airborne scene at t = 0."""
    rise = exactly(ball.z) - exactly(ball.radius)
    if rise == 0 and ball.vz <= 0.0:
        return body_at_start(ball, problem)
    state = FlightState(
        (arb(ball.x), arb(ball.y)),
        arb(rise),
        (arb(ball.vx), arb(ball.vy)),
        arb(ball.vz),
        slip_at_start(ball),
        arb(ball.wz),
    )
    return FlyingBody(constants_of(ball, problem), state, ZERO, 0)


def gone(body: Body, s: arb, t: arb, order: int) -> Body:
    """Return a ball that leaves the table at the age s, the time t [s]."""
    height, _, _ = body.vertical_after(s)
    rise = height - body.constants.radius
    return GoneBody(body.constants, body.position_after(s), rise, t, order)


def answered_by_table(constants: Constants, state: FlightState, t: arb, order: int) -> Body:
    """Return a ball after an event and the simultaneous reaction of the table.

    Raises `UndecidedError` if it can't be decided whether the ball is on the table, is pushed onto
    it, sticks to it, or flies.
    """
    if not state.rise.is_zero():
        if not state.rise > 0:
            raise UndecidedError("whether it is on the table")
        return FlyingBody(constants, state, t, order)
    if state.up < 0:
        state = _bounced(constants, state)
    elif not state.up >= 0:
        raise UndecidedError("whether it is pushed onto the table")
    square = state.up * state.up
    lowest = 4 * constants.gravity * LOWEST_BOUNCE * constants.radius
    if abs(square - lowest) <= HEIGHT_ROUNDING * lowest:
        raise UndecidedError("whether its bounce is high enough to be followed", exact=True)
    if square > lowest:
        return FlyingBody(constants, state, t, order)
    if not square <= lowest:
        raise UndecidedError("whether its bounce is high enough to be followed")
    if state.up.is_zero() or (1 - constants.table_restitution).is_zero():
        return Body(constants, state.place, state.velocity, state.slip, state.wz, t, order)
    return BouncingBody(constants, state, t, order)


def _bounced(constants: Constants, state: FlightState) -> FlightState:
    """Return a ball after the table has returned its downward speed, with cloth friction."""
    e, down = constants.table_restitution, -state.up
    slip = length(*state.slip)
    if slip.is_zero():
        return state._replace(up=e * down)
    most = constants.cloth_friction * (1 + e) * down
    if _sticks(most, slip):
        velocity = _less(state.velocity, 2 * ONE / 7, state.slip)
        return state._replace(up=e * down, velocity=velocity, slip=(ZERO, ZERO))
    part = most / slip
    return state._replace(
        up=e * down,
        velocity=_less(state.velocity, part, state.slip),
        slip=_less(state.slip, 7 * part / 2, state.slip),
    )


class _Loss(NamedTuple):
    """Loss of velocity by friction in bounces, divided by the slip."""

    part: arb
    mean: arb  # loss of the mean velocity
    all: bool  # whether the slip ends


def _loss_in_bounces(constants: Constants, up: arb, lasts: arb, slip: arb) -> _Loss:
    """Return the loss in bounces that start with the speed `up` [m/s] and last `lasts` [s].

    Impact n, from 1, has the speed e^(n-1) up and changes the velocity by mu (1 + e) times this;
    the change applies to the remaining time, e^n lasts. The impact sticks if 2/7 of the slip, minus
    the earlier changes, is smaller. If no impact sticks, the total change is mu (1 + e) up / (1 -
    e), and the loss of distance is 2 mu e up^2 / (g (1 - e)^2).
    """
    if slip.is_zero():
        return _Loss(ZERO, ZERO, all=True)
    e, friction = constants.table_restitution, constants.cloth_friction
    whole = friction * (1 + e) * up / (1 - e)
    if not _sticks(whole, slip):
        displacement = 2 * friction * e * up * up / (constants.gravity * (1 - e) * (1 - e))
        return _Loss(whole / slip, displacement / (lasts * slip), all=False)
    left, speed, share, displacement = 2 * slip / 7, up, e, ZERO
    while True:
        impulse = friction * (1 + e) * speed
        if not (impulse >= left or impulse < left):
            raise UndecidedError("at which bounce it sticks")
        displacement += share * (left if impulse >= left else impulse)
        if impulse >= left:
            return _Loss(2 * ONE / 7, displacement / slip, all=True)
        left, speed, share = left - impulse, e * speed, e * share


def _sticks(most: arb, slip: arb) -> bool:
    """Return whether friction that changes the velocity by at most `most` ends a slip [m/s]."""
    needed = 2 * slip / 7
    if most >= needed:
        return True
    if most < needed:
        return False
    raise UndecidedError("whether it slips or sticks on the cloth")


def _less(vector: Vector, part: arb, by: Vector) -> Vector:
    return (vector[0] - part * by[0], vector[1] - part * by[1])
