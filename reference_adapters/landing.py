"""When balls next touch, from closed forms: what a landed step of a foreign engine aims at.

A stepping engine sees a contact late, by up to one step. In landed mode its adapter asks here for
the time to the next contact and makes the engine's step end just there, so that what is left is the
engine's own solver. Nothing here uses this project's engine, which is one of those compared.
"""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine import CUSHIONS, Table

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.intp]

LANDING_GAP = 1e-10
"""Gap at which a landed step ends [m]: 1e5 times the rounding of a coordinate on a table, and far
too small to turn the line of centres (by 1e-10 / 2R, 2e-9 rad)."""

PRESSED_DEPTH = 1e-7
"""Overlap at which a step ends for what is pressed together [m]; see `time_to_contact`."""

PRESSED_SPEED = 1e-3
"""Speed below which what accelerates towards each other counts as pressed together [m/s].

What falls through `PRESSED_DEPTH` at 2 m/s^2 is faster by 6e-4 m/s.
"""

LATEST = 1e300
"""Time after which a contact is none [s]: it might exceed the doubles, and a run ends before."""

SLOWEST = 1e-200
"""Speed below which a ball isn't slowed [m/s]: the direction of a slower one would overflow."""

MAX_ROUNDS = 100
"""Rounds of conservative advancement. A hit takes 3 to 5; a tangency, where every round halves the
remaining time, about 50. What is left after that is still a lower bound: early, never late."""


class _Motion(NamedTuple):
    """x + v t + a t^2 / 2 of every ball, three arrays (n, 2)."""

    positions: FloatArray
    velocities: FloatArray
    accelerations: FloatArray


def time_to_contact(
    positions: FloatArray,
    velocities: FloatArray,
    accelerations: FloatArray,
    radii: FloatArray,
    table: Table | None,
    *,
    gap: float = LANDING_GAP,
    horizon: float,
) -> float:
    """Return the time until a step should end because two balls, or a ball and a cushion, touch.

    Parameters
    ----------
    positions, velocities, accelerations : (n, 2) float64 [m], [m/s], [m/s^2]
        Motion is x + v t + a t^2 / 2, valid up to `horizon` (the next time a ball stops, say).
    radii : (n,) float64 [m]
    table : Table or None
        Its `cushions` are infinite lines; None is a cloth without any.
    gap : float [m]
        Gap to land at, positive.
    horizon : float [s]
        How far to look, positive; may be inf.

    Returns
    -------
    float
        Smallest dt in (0, `horizon`] at which a gap falls to its level, or inf. The level is `gap`
        for what is farther apart than 2 `gap`. What is nearer has landed: its level is an overlap
        that is deeper by `gap` than the present one, so that a step of this length makes an engine
        that detects by overlap see the contact. Something that moves apart counts when it has come
        back; something that touches without closing never does. For what is pressed together, such
        as a ball that its topspin drives against another, the overlap is `PRESSED_DEPTH`: with
        `gap` it would bounce every 2e-5 s, as long as it is pressed.

    Notes
    -----
    Call it before every step. A contact then takes two steps, one to the gap and one of about
    2 `gap` / approach_speed that overlaps and is resolved; no third constant is needed for contacts
    that the engine resolves badly or that stay closed (balls rolling on together).

    Conservative advancement (Mirtich 1996; here with the acceleration kept): the distance of two
    centres is at least the projection of their separation on the present line of centres, d + b t +
    a t^2 / 2. The first time this falls to the level is a lower bound of the contact time, so
    repeating from there converges from outside, quadratically, and can't miss a contact. For a
    cushion the projection is the gap itself. The true quartic is never formed.
    """
    motion = _Motion(positions, velocities, accelerations)
    to_cushion = _to_cushion(motion, radii, table, gap)
    dt = min(to_cushion, _to_ball(motion, radii, gap, min(horizon, to_cushion)))
    return dt if dt <= horizon else np.inf


def rolling_accelerations(velocities: FloatArray, decelerations: FloatArray) -> FloatArray:
    """Return the accelerations of rolling balls, against their motion; 0 for a ball at rest.

    Parameters
    ----------
    velocities : (n, 2) float64 [m/s]
    decelerations : (n,) float64 [m/s^2]
        mu g of each ball, not negative.

    Returns
    -------
    (n, 2) float64 [m/s^2]
    """
    speeds = np.hypot(velocities[:, 0], velocities[:, 1])
    moving = speeds > SLOWEST
    factor = np.where(moving, -decelerations / np.where(moving, speeds, 1.0), 0.0)
    accelerations: FloatArray = velocities * factor[:, np.newaxis]
    return accelerations


def time_to_rest(velocities: FloatArray, decelerations: FloatArray) -> FloatArray:
    """Return how long each ball rolls, (n,) float64 [s]; inf where it never stops.

    Parameters are those of `rolling_accelerations`: a ball at v rolls for |v| / (mu g).
    """
    speeds = np.hypot(velocities[:, 0], velocities[:, 1])
    times = np.where(speeds > 0.0, np.inf, 0.0)
    np.divide(speeds, decelerations, out=times, where=decelerations > 0.0)
    return times


def _levels(
    gaps: FloatArray, rates: FloatArray, accelerations: FloatArray, gap: float
) -> FloatArray:
    """Return the gap that each present gap has to fall to; see `time_to_contact`.

    `rates` [m/s] and `accelerations` [m/s^2] are those of the gaps.
    """
    pressed = (np.abs(rates) < PRESSED_SPEED) & (accelerations < 0.0)
    depths = np.where(pressed, PRESSED_DEPTH, gap)
    return np.where(gaps > 2.0 * gap, gap, np.minimum(gaps, 0.0) - depths)


def _first_root(c: FloatArray, b: FloatArray, a: FloatArray) -> FloatArray:
    """Return the smallest t > 0 with c + b t + a t^2 / 2 = 0, for c > 0; inf where there is none.

    Each branch adds numbers of one sign, so nothing cancels but the discriminant. One that is later
    than `LATEST` is none: its quotient might exceed the doubles.
    """
    discriminant = b * b - 2.0 * a * c
    root = np.sqrt(np.maximum(discriminant, 0.0))
    closing = (b < 0.0) & (discriminant >= 0.0) & (root - b > 2.0 * c / LATEST)
    returning = (b >= 0.0) & (-a > (b + root) / LATEST)
    first = np.full_like(c, np.inf)
    np.divide(2.0 * c, root - b, out=first, where=closing)
    np.divide(b + root, -a, out=first, where=returning)
    return first


def _to_cushion(motion: _Motion, radii: FloatArray, table: Table | None, gap: float) -> float:
    """Return the time to the first contact of a ball with a cushion, or inf."""
    if table is None or not table.cushions:
        return np.inf
    sides = [CUSHIONS.index(name) for name in table.cushions]
    axes = np.array([0, 0, 1, 1])[sides]
    inward = np.array([1.0, -1.0, 1.0, -1.0])[sides]
    noses = np.array([0.0, table.length, 0.0, table.width])[sides]
    x, v, a = (inward * part[:, axes] for part in motion)
    gaps = x - inward * noses - radii[:, np.newaxis]
    closed = _first_root(gaps - _levels(gaps, v, a, gap), v, a)
    return float(np.min(closed))


def _to_ball(motion: _Motion, radii: FloatArray, gap: float, horizon: float) -> float:
    """Return the time to the first contact of two balls within `horizon`, or inf."""
    first, second = _pairs(len(radii))
    r0, v0, a0 = (part[second] - part[first] for part in motion)
    reach = radii[first] + radii[second]
    distances = _norm(r0)
    normals = r0 / distances[:, np.newaxis]
    levels = _levels(distances - reach, _dot(normals, v0), _dot(normals, a0), gap)
    target = reach + levels
    # Below this a computed gap is noise: coordinates of the size of these, subtracted.
    rounding = 8.0 * np.finfo(np.float64).eps * (float(np.max(np.abs(motion.positions))) + reach)
    t = np.zeros(len(first))
    contact = np.inf
    for _ in range(MAX_ROUNDS):
        if len(t) == 0:
            return contact
        s = t[:, np.newaxis]
        r = r0 + (v0 + 0.5 * a0 * s) * s
        distance = _norm(r)
        remaining = distance - target
        normal = r / distance[:, np.newaxis]
        b, a = _dot(normal, v0 + a0 * s), _dot(normal, a0)
        step = _first_root(np.maximum(remaining, rounding), b, a)
        # Neither a gap of rounding size nor a step that can't move the clock is progress.
        landed = (t > 0.0) & (remaining <= rounding) | (step <= 4e-16 * t)
        if np.any(landed):
            contact = min(contact, float(np.min(t[landed])))
        t = t + step
        going = ~landed & np.isfinite(t) & (t <= min(horizon, contact))
        r0, v0, a0, t = r0[going], v0[going], a0[going], t[going]
        target, rounding = target[going], rounding[going]
    return min(contact, float(np.min(t))) if len(t) else contact


@functools.lru_cache(maxsize=16)
def _pairs(n: int) -> tuple[IndexArray, IndexArray]:
    """Return the indices of every pair of n balls, each once."""
    first, second = np.triu_indices(n, k=1)
    return first, second


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    product: FloatArray = a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1]
    return product


def _norm(a: FloatArray) -> FloatArray:
    length: FloatArray = np.sqrt(_dot(a, a))
    return length
