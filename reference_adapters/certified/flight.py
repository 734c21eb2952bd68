"""A ball above the cloth until something acts on it, and how the table answers when it comes down.

Like `motion`, with the height besides. In flight gravity alone acts, so that velocity along the
cloth, slip and spin stay as they are: a parabola, which ends on the table. The table returns the
speed downwards e times; friction takes mu (1 + e) times it of the velocity, against the slip, but
no more than 2/7 of the slip, which ends it (Alciatore, technical proof B.5; the slip changes by 7/2
of what the velocity does).

Bounces that would rise less than `LOWEST_BOUNCE` are no events of their own: the model takes all
that follow for one motion along the cloth. They are a geometric series, whose duration, way and
loss of slip have closed forms.
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
from ghostball.reference_adapters.certified.problem import BallNumbers, Problem

LOWEST_BOUNCE = 2.0**-24
"""Height of a bounce, in diameters, from which on bounces are one motion: 3e-9 m for pool balls."""

HEIGHT_ROUNDING = 2.0**-37
"""Difference, in units of `LOWEST_BOUNCE`, at which no engine in doubles tells two heights apart.

A table that returns half of the speed brings a ball to exactly that height that falls its diameter.
"""


class State(NamedTuple):
    """A ball at an instant, with its height; slip and spin as in `motion.Body`."""

    place: Vector  # [m]
    rise: arb  # of its lowest point above the cloth [m]; exactly 0 where it is on it
    velocity: Vector  # [m/s]
    up: arb  # velocity upwards [m/s]
    slip: Vector  # [m/s]
    wz: arb  # [rad/s]


class FlyingBody(Body):
    """One ball in the air, until it comes down or something acts on it; never changed.

    `rise` [m]: of its lowest point above the cloth.
    `up` [m/s]: velocity upwards.
    """

    __slots__ = ("rise", "up")

    def __init__(self, constants: Constants, state: State, t: arb, order: int) -> None:
        self.rise, self.up = state.rise, state.up
        super().__init__(constants, state.place, state.velocity, state.slip, state.wz, t, order)

    def _start(self) -> Phase:
        gravity = self.constants.gravity
        fall = self._speed_of_fall()
        if self.up < 0:  # nothing cancels
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
        """What the end of its flight is called."""
        return EventKind.BALL_CLOTH

    @property
    def vertical(self) -> tuple[arb, arb, arb]:
        """Height of the centre, velocity and acceleration upwards: see `Body.vertical`."""
        return (self.constants.radius + self.rise, self.up, -self.constants.gravity)

    def spin_after(self, s: arb) -> arb:  # noqa: ARG002 - it is the same at any time
        """Return the spin about the vertical [rad/s]: nothing slows it in the air."""
        return self.wz

    def after_phase(self, t: arb, order: int) -> Body:
        """Return the ball as the table sends it off."""
        assert self.duration is not None
        s = self.duration
        place, fall = self.position_after(s), self._speed_of_fall()
        state = State(place, ZERO, (self.vx, self.vy), -fall, (self.ux, self.uy), self.wz)
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
    """One ball whose bounces are too low to be followed, until they end; never changed.

    It goes along the cloth, straight on, at the mean velocity, with the slip that belongs to that.
    """

    __slots__ = ("_lasts", "_slip_left", "_velocity_left")

    def __init__(self, constants: Constants, state: State, t: arb, order: int) -> None:
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
        """Whether its centre rests until something acts on it: its bounces end first."""
        return False

    @property
    def end_kind(self) -> EventKind:
        """What the end of the bounces is called."""
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
    """One ball that has left the table: it stays where it did, and nothing meets it."""

    __slots__ = ("rise",)

    def __init__(self, constants: Constants, place: Vector, rise: arb, t: arb, order: int) -> None:
        self.rise = rise
        still = (ZERO, ZERO)
        super().__init__(constants, place, still, still, ZERO, t, order)

    def _start(self) -> Phase:
        return Phase.GONE

    @property
    def resting(self) -> bool:
        """Whether its centre rests until something acts on it: nothing does."""
        return True

    @property
    def vertical(self) -> tuple[arb, arb, arb]:
        """Height of the centre, velocity and acceleration upwards: see `Body.vertical`."""
        return (self.constants.radius + self.rise, ZERO, ZERO)


def body_in_space_at_start(ball: BallNumbers, problem: Problem) -> Body:
    """Return a ball at t = 0, of a scene whose balls may leave the cloth."""
    rise = exactly(ball.z) - exactly(ball.radius)
    if rise == 0 and ball.vz <= 0.0:
        return body_at_start(ball, problem)
    state = State(
        (arb(ball.x), arb(ball.y)),
        arb(rise),
        (arb(ball.vx), arb(ball.vy)),
        arb(ball.vz),
        slip_at_start(ball),
        arb(ball.wz),
    )
    return FlyingBody(constants_of(ball, problem), state, ZERO, 0)


def gone(body: Body, s: arb, t: arb, order: int) -> Body:
    """Return a ball that leaves the table at the age s, the instant t [s]."""
    height, _, _ = body.vertical_after(s)
    rise = height - body.constants.radius
    return GoneBody(body.constants, body.position_after(s), rise, t, order)


def answered_by_table(constants: Constants, state: State, t: arb, order: int) -> Body:
    """Return a ball that something has acted on, after what the table does at the same instant.

    Raises `UndecidedError` where it can't be decided whether it is on the table, is pushed onto it,
    sticks to it, or flies.
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


def _bounced(constants: Constants, state: State) -> State:
    """Return a ball whose speed downwards the table has returned, with the cloth's friction."""
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
    """What friction takes of the velocity in bounces, over the slip."""

    part: arb
    mean: arb  # of the mean velocity
    all: bool  # whether the slip ends


def _loss_in_bounces(constants: Constants, up: arb, lasts: arb, slip: arb) -> _Loss:
    """Return what bounces take that begin with the speed `up` [m/s] and last for so long [s].

    Impact n, from 1 on, comes with e^(n-1) up and takes mu (1 + e) times that; what it takes is
    missing for the rest, lasts e^n. It sticks where 2/7 of the slip, less what was taken before,
    is no more; if none does, all of them take mu (1 + e) up / (1 - e), and of the way
    2 mu e up^2 / (g (1 - e)^2).
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
    """Whether friction that takes at most so much of the velocity ends a slip [m/s]."""
    needed = 2 * slip / 7
    if most >= needed:
        return True
    if most < needed:
        return False
    raise UndecidedError("whether it slips or sticks on the cloth")


def _less(vector: Vector, part: arb, by: Vector) -> Vector:
    return (vector[0] - part * by[0], vector[1] - part * by[1])
