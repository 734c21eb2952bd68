"""How one ball moves until its own next event: the closed form, and when that event is."""

from __future__ import annotations

import math

from engine._geometry import cushion_gap, cushion_in_contact, cushion_side
from engine._jit import kernel
from engine._state import (
    AX,
    AY,
    EPOCH,
    OWN_CUSHION,
    OWN_NONE,
    OWN_REST,
    OWN_TIME,
    RADIUS,
    VX,
    VY,
    Balls,
    Laws,
    X,
    Y,
)
from engine._tolerances import TIME_ROUNDING


@kernel
def first_crossing(gap: float, rate: float, acceleration: float) -> float:
    """Return the first s >= 0 at which gap + rate s + acceleration s^2 / 2 falls to 0, or inf.

    Contract: no allocation. A gap below 0 counts as 0, touching: then closing is 0, an event now,
    and opening is the later return. So a contact is found although rounding put it past its
    instant, and one that was just resolved is not found again.

    Notes
    -----
    Each branch adds numbers of one sign, so no digit cancels (Bannerman, Strobl, Formella and
    Poeschel 2014 give the rule for touching balls).
    """
    gap = max(gap, 0.0)
    discriminant = rate * rate - 2.0 * acceleration * gap
    if discriminant < 0.0:
        return math.inf
    root = math.sqrt(discriminant)
    if rate < 0.0:
        return 2.0 * gap / (root - rate)
    if acceleration < 0.0:
        return (rate + root) / -acceleration
    return math.inf


@kernel
def advance(balls: Balls, i: int, t: float) -> None:
    """Move ball i along its closed form to the instant t [s], its new epoch.

    Contract: t is not beyond the ball's own next event. No allocation.
    """
    s = t - balls.state[EPOCH, i]
    balls.state[X, i] += s * (balls.state[VX, i] + 0.5 * balls.state[AX, i] * s)
    balls.state[Y, i] += s * (balls.state[VY, i] + 0.5 * balls.state[AY, i] * s)
    balls.state[VX, i] += balls.state[AX, i] * s
    balls.state[VY, i] += balls.state[AY, i] * s
    balls.state[EPOCH, i] = t


@kernel
def come_to_rest(balls: Balls, i: int, t: float) -> None:
    """Move ball i to where it stops rolling, at the instant t [s], and stop it exactly.

    A uniformly slowed ball covers half of what it would cover at its first speed; unlike the full
    polynomial this cancels no digits.
    """
    s = t - balls.state[EPOCH, i]
    balls.state[X, i] += 0.5 * s * balls.state[VX, i]
    balls.state[Y, i] += 0.5 * s * balls.state[VY, i]
    balls.state[VX, i] = 0.0
    balls.state[VY, i] = 0.0
    balls.state[EPOCH, i] = t


@kernel
def speed_of(vx: float, vy: float) -> float:
    """Length of a velocity [m/s], scaled so that no square under- or overflows."""
    largest = max(abs(vx), abs(vy))
    if largest == 0.0:
        return 0.0
    ux, uy = vx / largest, vy / largest
    return largest * math.sqrt(ux * ux + uy * uy)


@kernel
def rolling_resistance(vx: float, vy: float, deceleration: float) -> tuple[float, float]:
    """Acceleration of a ball that rolls without slip: mu g against the motion (paper, 5.2).

    Exactly along the axis for motion along an axis, so that two balls rolling the same way have no
    relative acceleration.
    """
    largest = max(abs(vx), abs(vy))
    if largest == 0.0 or deceleration == 0.0:
        return 0.0, 0.0
    ux, uy = vx / largest, vy / largest
    norm = math.sqrt(ux * ux + uy * uy)
    return -deceleration * (ux / norm), -deceleration * (uy / norm)


@kernel
def predict_motion(balls: Balls, i: int, laws: Laws) -> None:
    """Set the acceleration of ball i and its own next event from its state at its epoch.

    The path is straight and ends after |v| / (mu g).
    """
    vx, vy = balls.state[VX, i], balls.state[VY, i]
    balls.state[AX, i], balls.state[AY, i] = rolling_resistance(vx, vy, laws.deceleration)
    speed = speed_of(vx, vy)
    if speed == 0.0:
        balls.state[OWN_TIME, i] = math.inf
        balls.own_kind[i] = OWN_NONE
        return
    duration = speed / laws.deceleration if laws.deceleration > 0.0 else math.inf
    balls.own_kind[i] = OWN_REST
    predict_cushion(balls, i, laws, duration, False)


@kernel
def predict_cushion(balls: Balls, i: int, laws: Laws, duration: float, pressed: bool) -> None:
    """Set the own event of ball i: a cushion reached within `duration` [s], else that end.

    Contract: `own_kind` holds what happens at the end of `duration`. For a ball that a contact step
    presses, a cushion that it is in contact with is left out: the step holds it. An end that the
    clock can't tell from now comes first, so that a ball that has all but stopped does stop.
    """
    if duration <= TIME_ROUNDING * balls.state[EPOCH, i]:
        balls.state[OWN_TIME, i] = balls.state[EPOCH, i]
        return
    for cushion in range(4):
        nx, ny, line = cushion_side(laws, cushion)
        if math.isinf(line) or (pressed and cushion_in_contact(balls, i, laws, cushion)):
            continue
        gap = cushion_gap(
            balls.state[X, i], balls.state[Y, i], balls.state[RADIUS, i], laws, cushion
        )
        rate = nx * balls.state[VX, i] + ny * balls.state[VY, i]
        s = first_crossing(gap, rate, nx * balls.state[AX, i] + ny * balls.state[AY, i])
        if s < duration:
            duration = s
            balls.own_kind[i] = OWN_CUSHION + cushion
    balls.state[OWN_TIME, i] = balls.state[EPOCH, i] + duration
