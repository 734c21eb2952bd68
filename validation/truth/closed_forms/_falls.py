"""Balls that fall straight down, or are thrown straight up, in air, each alone: when they rest.

v' = -g - k |v| v along a line. A throw at v rises ln(1 + k v^2 / g) / 2k within
atan(v sqrt(k / g)) / sqrt(g k); a fall from h lasts acosh(exp(k h)) / sqrt(g k) and ends at
sqrt((g / k)(1 - exp(-2 k h))). The table returns e of that. What is left once air does nothing more
that counts are the bounces of no air, 2 v / (g (1 - e)) long.
"""

from __future__ import annotations

from itertools import combinations

from mpmath import mp, mpf

from ghostball.validation.truth.closed_forms._motion import length_of, negligible, starting_state
from ghostball.validation.truth.closed_forms._setup import OrderError, Outcome, Setup


def fall_in_air(setup: Setup) -> Outcome:
    """Let each ball bounce on the spot until it rests; they never meet."""
    if setup.cushions or setup.t_max is not None or setup.table_restitution == 1:
        raise OrderError("needs an unbounded cloth, and bounces that end at rest")
    balls = range(len(setup.positions))
    for ball in balls:
        state = starting_state(setup, ball)
        if length_of(state.velocity) != 0 or any(spin != 0 for spin in state.spin):
            raise OrderError("needs balls that move up and down alone, without spin")
    for i, j in combinations(balls, 2):
        (x, y), (u, v) = setup.positions[i], setup.positions[j]
        if length_of((u - x, v - y)) <= setup.radii[i] + setup.radii[j]:
            raise OrderError("two balls are above each other")
    return Outcome.at_rest(setup.positions, max(_time_of(setup, ball) for ball in balls))


def _time_of(setup: Setup, ball: int) -> mpf:
    """Return when a ball has bounced for the last time."""
    g, k, e = setup.gravity, setup.air_drag, setup.table_restitution
    height, up = setup.heights[ball], setup.rises[ball]
    if height == 0 and up == 0:
        return mp.mpf(0)
    rate, time = mp.sqrt(g * k), mp.mpf(0)
    if up < 0:
        raise OrderError("needs balls that are let go, or thrown up")
    # Of a bounce at v air takes k v^2 / g: the last ones are those of no air.
    while not negligible(k * up * up / g) or height > 0:
        time += mp.atan(up * mp.sqrt(k / g)) / rate
        height += mp.log1p(k * up * up / g) / (2 * k)
        time += mp.acosh(mp.exp(k * height)) / rate
        up = e * mp.sqrt(-g / k * mp.expm1(-2 * k * height))
        height = mp.mpf(0)
    return time + 2 * up / (g * (1 - e))
