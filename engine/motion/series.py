"""Power series of motion in air: the code that motion on the cloth and flight share.

`motion.drag` and `motion.flight_in_air` compute the series.
"""

from __future__ import annotations

import math

import numpy as np

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import FloatArray, IntArray
from ghostball.engine.core.tolerances import EPS
from ghostball.model.trajectory.polynomial import OF_WX, OF_WY, OF_X, OF_Y, OF_Z, PER_POWER

STRAIGHT_DEGREE = 14
"""Degree of the speed in a straight piece."""

_STRAIGHT_PART = 2.0**-4
"""Length of a straight piece, in units of the time T for which |b| (p + a T) T = 1/2.

At every complex time of size below T the speed is at most 2 (p + a T): see `straight_series`. By
Cauchy's estimate term n of the series is then at most this speed times 16^-n, so the truncation
error is below 2^-59 of the speed.
"""

DEGREE = 24
"""Largest degree of the velocity in a turning piece."""

LEFT_OUT = EPS / 64.0
"""Truncation error of the series of a piece, relative to the speeds or the position."""

PART_OF_SERIES = 0.75
"""Longest turning piece, in units of an estimate of the series' radius of convergence.

This is only the length that is tried; the last coefficients decide how long the piece may be.
"""

WORK_OF_SERIES = 50
"""Cost of the power series of a turning piece, in units of work."""

OVER = np.append(0.0, 1.0 / np.arange(1.0, DEGREE + 2.0))
"""1 / n, indexed by n: a product takes less time than a quotient."""


@kernel(inline=True)
def straight_series(p: FloatArray, speed: float, a: float, b: float) -> float:
    """Put the speed of straight motion, slowed by a + b p^2, into p; return its validity [s].

    The result is inf if b is 0.
    """
    p[0] = speed
    for n in range(STRAIGHT_DEGREE):
        # p^2: each product occurs twice, except the middle one.
        square, half = 0.0, (n + 1) // 2
        for j in range(half):
            square += p[j] * p[n - j]
        square += square
        if n % 2 == 0:
            square += p[half] * p[half]
        p[n + 1] = -(b * square + (a if n == 0 else 0.0)) * OVER[n + 1]
    duration = math.inf
    if b != 0.0:
        # The time at which the majorant P' = a + b P^2 reaches twice p + a t: b (p + a t) t = 1/2.
        # No division by b, which may be so small that the quotient overflows.
        fast = abs(b) * abs(speed)
        duration = _STRAIGHT_PART / (fast + math.sqrt(fast * fast + 2.0 * a * abs(b)))
    return duration


@kernel
def first_zero(counters: IntArray, p: FloatArray, duration: float) -> float:
    """Return the time at which a falling speed p reaches 0 within a duration [s], or inf."""
    if not p[1] < 0.0:
        return math.inf
    return falls_to_zero(counters, p, STRAIGHT_DEGREE, duration, -p[0] / p[1])


@kernel
def falls_to_zero(
    counters: IntArray, c: FloatArray, degree: int, longest: float, guess: float
) -> float:
    """Return the time at which a polynomial, positive at first, reaches 0 within `longest`, or inf.

    Contract: the polynomial reaches 0 at most once. Uses Newton's method from a guess, and
    bisection where a step would leave the interval that contains the root.
    """
    value = 0.0
    if longest < math.inf:
        for n in range(degree, -1, -1):
            value = value * longest + c[n]
    if value > 0.0:
        return math.inf
    least, most = 0.0, longest
    s = guess if guess < longest else longest
    for _ in range(128):
        counters[st.WORK] += 1
        value, slope = 0.0, 0.0
        for n in range(degree, -1, -1):
            slope = slope * s + value
            value = value * s + c[n]
        if value > 0.0:
            least = s
        else:
            most = s
        later = s - value / slope if slope < 0.0 else least
        if not least < later < most:
            if value == 0.0 or abs(later - s) <= 2.0 * EPS * s:
                return s
            later = 0.5 * (least + most)
        if abs(later - s) <= 2.0 * EPS * s:
            return later
        s = later
    return s


@kernel(inline=True)
def extend_speed(row: FloatArray, speed: int, x: int, y: int, n: int) -> None:
    """Compute the power n > 0 of a speed s from those of its components, by s^2 = x^2 + y^2.

    `speed`, `x`, `y`: their rows. In a square each product occurs twice, except the middle one.
    """
    half = (n + 1) // 2
    total = row[x, 0] * row[x, n] + row[y, 0] * row[y, n]
    for j in range(1, half):
        total += row[x, j] * row[x, n - j] + row[y, j] * row[y, n - j]
        total -= row[speed, j] * row[speed, n - j]
    if n % 2 == 0:
        middle = row[x, half] * row[x, half] + row[y, half] * row[y, half]
        total += 0.5 * (middle - row[speed, half] * row[speed, half])
    row[speed, n] = total / row[speed, 0]


@kernel
def shorter(excess: float) -> float:
    """Return about the root of degree 24 of a number, at most 1.

    The exponent is 1/32 + 1/128 + 1/512, because only square roots are allowed. The result is at
    most the root, except for numbers below 1e-34.
    """
    if not excess < 1.0:
        return 1.0
    root, part = 1.0, excess
    for k in range(9):
        part = math.sqrt(part)
        if k in (4, 6, 8):
            root *= part
    return 0.95 * root


@kernel(inline=True)
def put_power(powers: FloatArray, i: int, power: int, x: float, y: float, z: float) -> None:
    """Set the coefficients of ball i's x, y and z for a power > 2 of the time; wx and wy get 0."""
    at = st.POWERS + PER_POWER * (power - 2)
    powers[i, at + OF_X], powers[i, at + OF_Y], powers[i, at + OF_Z] = x, y, z
    powers[i, at + OF_WX], powers[i, at + OF_WY] = 0.0, 0.0


@kernel
def note_bend(powers: FloatArray, i: int, degree: int, duration: float) -> None:
    """Store the number of powers of ball i's piece, and bounds on the change of acceleration.

    `degree`: of the velocity; the displacement has one more power.
    """
    x, y, z = 0.0, 0.0, 0.0
    powers[i, st.COUNT] = 0.0
    if duration < math.inf:
        for power in range(degree - 1, 0, -1):
            at = st.POWERS + PER_POWER * power
            factor = float((power + 2) * (power + 1) * power)
            x = x * duration + factor * abs(powers[i, at + OF_X])
            y = y * duration + factor * abs(powers[i, at + OF_Y])
            z = z * duration + factor * abs(powers[i, at + OF_Z])
        powers[i, st.COUNT] = degree
    powers[i, st.JERK_X], powers[i, st.JERK_Y], powers[i, st.JERK_UP] = x, y, z
