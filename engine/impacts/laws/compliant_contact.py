"""The tangential impulse of an impact whose contact yields: Stronge's model of two springs.

Stronge, W. J. (2000): Impact Mechanics. Cambridge University Press, chapter 5.

Between the ball and the cushion, one spring yields along the normal and one along the slip. The
point of contact has no mass: it sticks to the cushion, or slips while the force of the spring is
the coefficient of friction times the normal force. With rigid contacts, friction can end the slip
but not reverse it. Here the second spring returns a part of its energy, so the slip may reverse.

Units: the closing speed of the contact is 1, and the angular frequency of the normal spring is 1.
While the ball is compressed, the phase of the normal spring goes from 0 to a quarter turn, and the
normal force is the sine of the phase. Afterwards the phase goes on to half a turn, slower or faster
by 1/e, where e is the restitution. r is the ratio of the frequencies of both springs.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel

_RATE = 3.5
"""Change of the slip by an impulse at the surface of a solid sphere, over that of its centre."""

_QUARTER_TURN = 1.5707963267948966

_LEAST_SLIP = 1e-280
"""Slip below which products lose digits to underflow; a smaller slip counts as this one."""

_TRIALS = 16
"""Number of intervals of the restitution that are searched for the end of sticking."""

_HALVINGS = 52
"""Number of times that an interval of the search is halved: 2^-52 of its length is left."""


@kernel
def compliant_share(slip: float, friction: float, restitution: float, ratio: float) -> float:
    """Return the part of the slip that the tangential impulse has, over the mass of the ball.

    `slip` >= 0: the slip of the ball's surface before the impact, over the closing speed.
    `friction` >= 0, `restitution` in [0, 1]; `ratio` in (1, 2): r.

    With a rigid contact the part is at most 2/7, which ends the slip. Here, strong friction
    reverses the slip, and the part is larger than 2/7, but at most 4/7.

    Contract: + - * / and square roots only; no allocation; a bounded number of steps. The energy
    doesn't increase: both springs are unloaded at the end.
    """
    if not slip > 0.0 or not friction > 0.0:
        return 0.0
    slip = max(slip, _LEAST_SLIP)
    e, flexibility = restitution, _RATE / (ratio * ratio)  # of the second spring, over the first
    force, relative = friction * flexibility, slip / friction
    slides = (1.0 + e) * friction / slip
    sticks_again = _RATE * e * e - flexibility
    if relative <= flexibility:  # the contact sticks from the beginning
        deflection, speed, turned, start = 0.0, slip, ratio * _QUARTER_TURN, 0.0
    elif relative <= _RATE:  # slides first, and sticks during the compression
        cosine = (_RATE - relative) / (_RATE - flexibility)
        deflection = force * math.sqrt((1.0 - cosine) * (1.0 + cosine))
        speed, turned, start = force * cosine, ratio * arcsine(cosine), 0.0
    elif e * (relative - _RATE) < sticks_again:  # sticks during the restitution
        sine = e * (relative - _RATE) / sticks_again
        deflection = force * math.sqrt((1.0 - sine) * (1.0 + sine))
        speed, turned, start = -force * sine / e, 0.0, arcsine(sine)
    else:  # slides to the end
        return slides
    # `deflection` and `speed` of the second spring, moved on to the end of the compression:
    cosine, sine = cosine_and_sine(turned)
    deflection, speed = (
        deflection * cosine + speed * sine / ratio,
        speed * cosine - deflection * sine * ratio,
    )
    # Sticking ends in the restitution, at the first phase (from its start) where the second spring
    # pulls more strongly than friction.
    low, high = start, _QUARTER_TURN
    step = (high - low) / _TRIALS
    for k in range(1, _TRIALS):
        phase = start + k * step
        if _excess(phase, phase - start, deflection, speed, force, e, ratio) > 0.0:
            high = phase
            break
        low = phase
    for _ in range(_HALVINGS):
        phase = 0.5 * (low + high)
        if _excess(phase, phase - start, deflection, speed, force, e, ratio) > 0.0:
            high = phase
        else:
            low = phase
    cosine, sine = cosine_and_sine(ratio * e * (high - start))
    pull = deflection * cosine + speed * sine / ratio
    left = speed * cosine - deflection * sine * ratio
    _, sine = cosine_and_sine(high)
    change = _RATE * friction * e * (1.0 - sine)
    left = left - change if pull > 0.0 else left + change
    return min((slip - left) / (_RATE * slip), slides)


@kernel
def _excess(
    phase: float,
    passed: float,
    deflection: float,
    speed: float,
    force: float,
    e: float,
    ratio: float,
) -> float:
    """Return the pull of the second spring minus the friction, at a phase of the restitution."""
    cosine, sine = cosine_and_sine(ratio * e * passed)
    normal, _ = cosine_and_sine(phase)
    return abs(deflection * cosine + speed * sine / ratio) - force * normal


@kernel
def cosine_and_sine(angle: float) -> tuple[float, float]:
    """Return the cosine and the sine of an angle from 0 to 4 rad, with an error below 1e-14.

    Power series give the values for a 64th of the angle, which is then doubled six times. 1 - cos
    is kept instead of cos, which would lose digits.
    """
    x = angle / 64.0
    z = x * x
    versine = z * (0.5 - z * (1.0 / 24.0 - z * (1.0 / 720.0 - z / 40320.0)))
    sine = x * (1.0 - z * (1.0 / 6.0 - z * (1.0 / 120.0 - z / 5040.0)))
    for _ in range(6):
        sine, versine = 2.0 * sine * (1.0 - versine), 2.0 * sine * sine
    return 1.0 - versine, sine


@kernel
def arcsine(sine: float) -> float:
    """Return the arcsine of a number in [0, 1]: a series for the angle, halved five times."""
    cosine = math.sqrt((1.0 - sine) * (1.0 + sine))
    half = sine
    for _ in range(5):
        half = half / math.sqrt(2.0 * (1.0 + cosine))
        cosine = math.sqrt(0.5 * (1.0 + cosine))
    z = half * half
    series = 15.0 / 336.0 + z * (105.0 / 3456.0 + z * (945.0 / 42240.0))
    return 32.0 * half * (1.0 + z * (1.0 / 6.0 + z * (3.0 / 40.0 + z * series)))
