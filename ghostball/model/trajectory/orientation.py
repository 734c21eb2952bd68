"""Orientation of balls, as quaternions with w first.

The orientation is computed after a run from the recorded motion, because the motion doesn't depend
on it. Between events, the angular velocity is a polynomial in time, w(s) = w_0 + w_1 s + ...;
a new piece starts when the vertical spin has decayed. Without air, the polynomial is linear. If all
coefficients are parallel, the ball turns about their axis by the integral of w. Otherwise the axis
moves, and q' = w(s) q / 2 is solved by a power series.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ghostball.model.arrays import BoolArray, FloatArray, IntArray
from ghostball.model.errors import GhostballError
from ghostball.model.rounding import EPS
from ghostball.model.trajectory import segment
from ghostball.model.trajectory.polynomial import OF_WX, OF_WY, OF_X, OF_Y, PER_POWER
from ghostball.model.trajectory.segment import Phase

STEP_TURN = 4.0
"""Largest turn in one step of the power series [rad]; see `series_turn`."""

TRUNCATION = 2.0**-55
"""Largest truncation error of the power series in one step: half of the rounding of its result."""

AXIS_ROUNDING = 8.0 * EPS
"""Sine of the angle between coefficients of w up to which the axis counts as fixed: rounding."""

MAX_STEPS = 1_000_000
"""Largest number of steps for one ball: 4e6 rad with a moving axis, in a few seconds."""


class Pieces(NamedTuple):
    """The motion of one ball as m pieces in order of time, with polynomial angular velocity."""

    start: FloatArray  # (m,) [s]
    duration: FloatArray  # (m,) [s]
    spin: FloatArray  # (m, d, 3), coefficients of w in t - start [rad/s, rad/s^2, ...]


def pieces_of(
    segments: FloatArray,
    powers: FloatArray,
    radius: float,
    spin_deceleration: float,
    t_end: float,
) -> Pieces:
    """Split a ball's segments at the times when its vertical spin has decayed.

    `segments` (k, 14 ...) and `powers` (5 m, k) are as in `ExactTrajectory`; `radius` in metres,
    `spin_deceleration` in rad/s^2, `t_end` in seconds.
    """
    start = segments[:, segment.EPOCH]
    duration = np.append(start[1:], t_end) - start
    flies = segments[:, segment.PHASE] == Phase.FLYING
    slides = np.isin(segments[:, segment.PHASE], (Phase.SLIDING, Phase.COMPRESSED))
    sliding = (slides | flies)[:, np.newaxis]
    # For a rolling ball, the angular velocity is k x v / R, and changes with v.
    v, a = segments[:, segment.VX : segment.VY + 1], segments[:, segment.AX : segment.AY + 1]
    turned = np.array([-1.0, 1.0]) / radius
    count = len(powers) // PER_POWER
    spin = np.zeros((len(segments), max(1 + count, 2), 3))
    for power in range(2, 1 + count):
        own = powers[PER_POWER * (power - 2) :][[OF_WX, OF_WY]].T
        x, y = powers[PER_POWER * (power - 1) :][[OF_X, OF_Y]]
        rolling = (1 + power) * np.column_stack((-y, x)) / radius
        spin[:, power, :2] = np.where(sliding, own, rolling)
    spin[:, 0, :2] = np.where(
        sliding, segments[:, segment.WX : segment.WY + 1], v[:, ::-1] * turned
    )
    spin[:, 1, :2] = np.where(
        sliding, segments[:, segment.BX : segment.BY + 1], a[:, ::-1] * turned
    )
    vertical, added = segments[:, segment.WZ], segments[:, segment.BZ]
    decay = np.where(flies, 0.0, spin_deceleration * np.sign(vertical))
    spin[:, 0, 2], spin[:, 1, 2] = vertical, added - decay

    # When the vertical spin has decayed, the rest of the segment becomes a separate piece.
    lasts = np.full(len(segments), np.inf)
    np.divide(np.abs(vertical), spin_deceleration, out=lasts, where=decay != 0.0)
    ends = np.flatnonzero(lasts < duration)
    s, rest = lasts[ends], spin[ends]
    rest = _shifted(rest, s)
    rest[:, 0, 2], rest[:, 1, 2] = s * added[ends], added[ends]
    after, left = start[ends] + s, duration[ends] - s
    duration[ends] = s
    return Pieces(
        np.insert(start, ends + 1, after),
        np.insert(duration, ends + 1, left),
        np.insert(spin, ends + 1, rest, axis=0),
    )


def orientation_at(times: FloatArray, pieces: Pieces) -> FloatArray:
    """Return the orientation at `times`, unit quaternions (k, 4); (1, 0, 0, 0) at the start.

    `times` (k,) are between the start of the first piece and the end of the last [s]. Raises
    `GhostballError` if a ball needs more than `MAX_STEPS` steps. The steps depend only on the
    motion, not on `times`, so the result for one time has the same bits for any other `times`. The
    error is a few roundings for each step, plus the effect of the rounding of the time, |w| eps t.
    This effect dominates: about 1e-13 rad for a ball that turns a hundred times in ten seconds.
    """
    fixed = has_fixed_axis(pieces)
    steps = _steps_of(pieces, fixed)
    length = pieces.duration / steps
    first = np.concatenate(([0], np.cumsum(steps)))  # number of each piece's first step
    of = np.repeat(np.arange(len(steps)), steps)
    offset = (np.arange(len(of)) - first[of]) * length[of]
    spin = _shifted(pieces.spin[of], offset)
    moves = ~fixed[of]
    terms = terms_needed(spin[moves], length[of][moves])
    before = np.empty((len(of) + 1, 4))
    before[0] = 1.0, 0.0, 0.0, 0.0
    before[1:] = _running_product(_turn(spin, length[of], fixed[of], terms))

    piece = np.searchsorted(pieces.start, times, side="right") - 1
    since = times - pieces.start[piece]
    with np.errstate(divide="ignore", invalid="ignore"):  # pieces without duration
        step = np.nan_to_num(since / length[piece], nan=0.0, posinf=0.0)
    step = np.minimum(step.astype(np.int64), steps[piece] - 1)
    at = first[piece] + step
    turn = _turn(spin[at], since - step * length[piece], fixed[piece], terms)
    return _unit(hamilton_product(turn, before[at]))


def has_fixed_axis(pieces: Pieces) -> BoolArray:
    """Return whether the axis of the angular velocity of each piece is fixed, (m,)."""
    scaled = _scaled(pieces.spin, pieces.duration)
    sizes = np.linalg.norm(scaled, axis=2)
    axis = np.take_along_axis(scaled, np.argmax(sizes, axis=1)[:, None, None], axis=1)
    across = np.linalg.norm(np.cross(scaled, axis), axis=2)
    bound = AXIS_ROUNDING * sizes * np.max(sizes, axis=1, keepdims=True)
    fixed: BoolArray = np.all(across <= bound, axis=1)
    return fixed


def fixed_axis_turn(spin: FloatArray, duration: FloatArray) -> FloatArray:
    """Return the turn about a fixed axis: the integral of a spin (m, d, 3), as (m, 4)."""
    scaled = _scaled(spin, duration)
    half = 0.5 * np.sum(scaled / np.arange(1, spin.shape[1] + 1)[:, np.newaxis], axis=1)
    angle = np.linalg.norm(half, axis=1, keepdims=True)
    # sin(angle) / angle, finite at 0.
    return np.concatenate((np.cos(angle), np.sinc(angle / np.pi) * half), axis=1)


def series_turn(spin: FloatArray, duration: FloatArray, terms: int) -> FloatArray:
    """Return the turn by a spin (m, d, 3) during a short time, quaternions (m, 4), for any axes.

    `spin` is as in `Pieces`. |w| times `duration` (m,) [s] must be at most `STEP_TURN`
    throughout. `terms` is the number of terms of the series, including the first. With
    q = sum C_n and w s = sum W_k, by power of the time, the equation q' = w q / 2 gives 2 (n + 1)
    C_{n+1} = sum_k W_k C_{n-k}. The series converges everywhere.
    """
    half = 0.5 * _scaled(spin, duration)
    found = [np.zeros((len(half), 4))]
    found[0][:, 0] = 1.0
    total = found[0].copy()
    for n in range(1, terms):
        term = np.zeros_like(total)
        for k, c in enumerate(found[: -half.shape[1] - 1 : -1]):
            term += _vector_product(half[:, k], c)
        found.append(term / n)
        total += found[-1]
    return _unit(total)


def terms_needed(spin: FloatArray, duration: FloatArray) -> int:
    """Return the number of terms of `series_turn` for a truncation error of at most `TRUNCATION`.

    The recurrence in absolute values bounds each term by the d terms before it. If n is at least
    twice the sum of its factors, the next d terms are at most half of the largest of these d terms.
    All further terms therefore add up to at most d times this largest term.
    """
    half = 0.5 * np.max(np.linalg.norm(_scaled(spin, duration), axis=2), axis=0, initial=0.0)
    bounds, d = [1.0], len(half)
    while d * max(bounds[-d:]) > TRUNCATION or len(bounds) < 2.0 * half.sum():
        last = bounds[: -d - 1 : -1]
        bounds.append(float(np.dot(half[: len(last)], last)) / len(bounds))
    return len(bounds)


def hamilton_product(p: FloatArray, q: FloatArray) -> FloatArray:
    """Return p q for quaternions (..., 4) with w first: the turn q followed by the turn p."""
    w = p[..., :1]
    return w * q + _vector_product(p[..., 1:], q)


def _vector_product(vector: FloatArray, q: FloatArray) -> FloatArray:
    """Return v q for a vector v (..., 3), as a quaternion with w = 0, and q (..., 4)."""
    x1, y1, z1 = np.moveaxis(vector, -1, 0)
    w2, x2, y2, z2 = np.moveaxis(q, -1, 0)
    product: FloatArray = np.stack(
        (
            -x1 * x2 - y1 * y2 - z1 * z2,
            x1 * w2 + y1 * z2 - z1 * y2,
            -x1 * z2 + y1 * w2 + z1 * x2,
            x1 * y2 - y1 * x2 + z1 * w2,
        ),
        axis=-1,
    )
    return product


def _unit(q: FloatArray) -> FloatArray:
    norms: FloatArray = np.linalg.norm(q, axis=-1, keepdims=True)
    return q / norms


def _scaled(spin: FloatArray, duration: FloatArray) -> FloatArray:
    """Return the coefficients of w s in the fraction of the duration [rad], (m, d, 3)."""
    powers = duration[:, np.newaxis] ** np.arange(1, spin.shape[1] + 1)
    scaled: FloatArray = spin * powers[:, :, np.newaxis]
    return scaled


def _shifted(spin: FloatArray, by: FloatArray) -> FloatArray:
    """Return coefficients (m, d, 3) of the same polynomial in s - `by` (m,): Horner's scheme."""
    later = spin.copy()
    for lowest in range(later.shape[1] - 1):
        for power in range(later.shape[1] - 2, lowest - 1, -1):
            later[:, power] += by[:, np.newaxis] * later[:, power + 1]
    return later


def _steps_of(pieces: Pieces, fixed: BoolArray) -> IntArray:
    """Return the number of equal steps for each piece, (m,): 1 if its axis is fixed."""
    turn = np.sum(np.linalg.norm(_scaled(pieces.spin, pieces.duration), axis=2), axis=1)
    steps = np.where(fixed, 1.0, np.ceil(turn / STEP_TURN))
    if not steps.sum() <= MAX_STEPS:
        raise GhostballError(
            f"`orientation` can't be computed: a ball turns by about {turn.sum():.3g} rad about a "
            f"moving axis, more than the limit of {STEP_TURN * MAX_STEPS:g} rad. Set a smaller "
            "`t_max`"
        )
    return np.maximum(steps, 1.0).astype(np.int64)


def _turn(spin: FloatArray, duration: FloatArray, fixed: BoolArray, terms: int) -> FloatArray:
    """Return the turn of each step, (m, 4), about a fixed axis or by the series."""
    turn = np.empty((len(spin), 4))
    turn[fixed] = fixed_axis_turn(spin[fixed], duration[fixed])
    turn[~fixed] = series_turn(spin[~fixed], duration[~fixed], terms)
    return turn


def _running_product(turns: FloatArray) -> FloatArray:
    """Return the orientation after each of the turns, (m, 4).

    Products are formed by doubling, which needs fewer numpy calls and has smaller errors than one
    product at a time.
    """
    reached, reach = turns.copy(), 1
    while reach < len(turns):
        reached[reach:] = _unit(hamilton_product(reached[reach:], reached[:-reach]))
        reach *= 2
    return reached
