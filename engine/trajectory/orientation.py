"""How far balls turn while they move: quaternions with w first, from pieces of linear spin.

Between events the angular velocity is a straight line in time, w(s) = w + b s, once a piece ends
where the spin about the vertical does. Where w and b lie on one axis, the ball turns about it by
the integral of w. Otherwise the axis moves, and q' = w(s) q / 2 is solved by its power series.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ghostball.engine.core import state as st
from ghostball.engine.core.tolerances import EPS
from ghostball.engine.errors import GhostballError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

STEP_TURN = 1.0
"""Largest turn in one step of the power series [rad]; see `series_turn`."""

SERIES_TERMS = 32
"""Terms of the power series: within `STEP_TURN` the rest is below 1e-17, whatever w and b."""

AXIS_ROUNDING = 8.0 * EPS
"""Sine of the angle between w and b that is but their rounding: the axis stays fixed."""

MAX_STEPS = 10_000_000
"""Steps followed for one ball: about 1e7 rad with a moving axis, for a minute of work."""

_CHUNK = 65_536
"""Steps handled at once: 20 MB."""

_ROW = 64
"""Steps whose turns are multiplied one after another, beside those of other rows."""


class Pieces(NamedTuple):
    """One ball's motion as m pieces in order of time, each with angular velocity w + b s.

    Attributes
    ----------
    start, duration : (m,) float64 [s]
    spin : (m, 3) float64 [rad/s]
        w, at the start of the piece.
    change : (m, 3) float64 [rad/s^2]
        b.
    """

    start: FloatArray
    duration: FloatArray
    spin: FloatArray
    change: FloatArray


def pieces_of(knots: FloatArray, radius: float, spin_deceleration: float, t_end: float) -> Pieces:
    """Split a ball's knots where its vertical spin has decayed, and find w and b of each piece.

    Parameters
    ----------
    knots : (k, 14) float64, as in `ExactTrajectory`
    radius : float [m]
    spin_deceleration : float [rad/s^2]
    t_end : float [s]
    """
    start = knots[:, st.EPOCH]
    duration = np.append(start[1:], t_end) - start
    sliding = (knots[:, st.PHASE] == st.SLIDING)[:, np.newaxis]
    # While it rolls, the angular velocity is k x v / R, and changes as v does.
    v, a = knots[:, st.VX : st.VY + 1], knots[:, st.AX : st.AY + 1]
    turned = np.array([-1.0, 1.0]) / radius
    spin, change = np.zeros((len(knots), 3)), np.zeros((len(knots), 3))
    spin[:, :2] = np.where(sliding, knots[:, st.WX : st.WY + 1], v[:, ::-1] * turned)
    change[:, :2] = np.where(sliding, knots[:, st.BX : st.BY + 1], a[:, ::-1] * turned)
    spin[:, 2] = knots[:, st.WZ]
    decay = -spin_deceleration * np.sign(spin[:, 2])
    added = knots[:, st.BZ]
    change[:, 2] = decay + added

    lasting = np.full(len(knots), np.inf)
    np.divide(np.abs(spin[:, 2]), spin_deceleration, out=lasting, where=decay != 0.0)
    ends = np.flatnonzero(lasting < duration)
    # The rest of a knot whose vertical spin decays within it is a piece of its own, right after it.
    s = lasting[ends]
    after_spin = spin[ends] + s[:, np.newaxis] * change[ends]
    after_change = change[ends].copy()
    after_spin[:, 2], after_change[:, 2] = s * added[ends], added[ends]
    rest = duration[ends] - s
    duration[ends] = s
    return Pieces(
        np.insert(start, ends + 1, start[ends] + s),
        np.insert(duration, ends + 1, rest),
        np.insert(spin, ends + 1, after_spin, axis=0),
        np.insert(change, ends + 1, after_change, axis=0),
    )


def orientation_at(times: FloatArray, pieces: Pieces) -> FloatArray:
    """Return the orientation at `times`, unit quaternions (k, 4); (1, 0, 0, 0) at the start.

    Parameters
    ----------
    times : (k,) float64 [s], from the start of the first piece to the end of the last
    pieces : Pieces

    Raises
    ------
    GhostballError
        Where a ball turns more than `MAX_STEPS` steps can follow.

    Notes
    -----
    Steps depend on the motion alone, not on `times`: the same instant gives the same bits,
    whatever else is asked for. The error is a few roundings for each radian turned, and what the
    rounding of the instant itself amounts to, |w| eps t: the largest of the two, about 1e-13 rad
    for a ball that turns a hundred times in ten seconds.
    """
    fixed = has_fixed_axis(pieces.spin, pieces.change)
    steps = _steps_of(pieces, fixed)
    length = pieces.duration / steps
    piece = np.searchsorted(pieces.start, times, side="right") - 1
    since = times - pieces.start[piece]
    with np.errstate(divide="ignore", invalid="ignore"):  # pieces without duration
        step = np.nan_to_num(since / length[piece], nan=0.0, posinf=0.0)
    step = np.minimum(step.astype(np.int64), steps[piece] - 1)
    first = np.concatenate(([0], np.cumsum(steps)))  # number of each piece's first step
    wanted = first[piece] + step
    since = since - step * length[piece]

    result = np.empty((len(times), 4))
    reached = np.array((1.0, 0.0, 0.0, 0.0))
    last = int(wanted.max(initial=-1))
    for chunk in range(0, last + 1, _CHUNK):
        numbers = np.arange(chunk, min(chunk + _CHUNK, last + 1))
        of = np.searchsorted(first, numbers, side="right") - 1
        offset = (numbers - first[of]) * length[of]
        spin = pieces.spin[of] + offset[:, np.newaxis] * pieces.change[of]
        turns = _turn(spin, pieces.change[of], length[of], fixed[of])
        before = np.concatenate((reached[np.newaxis], _running_product(turns, reached)))
        reached = before[-1]
        now = np.flatnonzero((wanted >= chunk) & (wanted <= numbers[-1]))
        at, own = wanted[now] - chunk, piece[now]
        turn = _turn(spin[at], pieces.change[own], since[now], fixed[own])
        result[now] = hamilton_product(turn, before[at])
    norms: FloatArray = np.linalg.norm(result, axis=1, keepdims=True)
    return result / norms


def has_fixed_axis(spin: FloatArray, change: FloatArray) -> NDArray[np.bool_]:
    """Whether w and b, (m, 3) each, lie on one axis up to rounding, (m,)."""
    across = np.linalg.norm(np.cross(spin, change), axis=1)
    along = np.linalg.norm(spin, axis=1) * np.linalg.norm(change, axis=1)
    fixed: NDArray[np.bool_] = across <= AXIS_ROUNDING * along
    return fixed


def fixed_axis_turn(spin: FloatArray, change: FloatArray, duration: FloatArray) -> FloatArray:
    """Return the turn about the one axis of w and b, by w s + b s^2 / 2, quaternions (m, 4)."""
    s = duration[:, np.newaxis]
    half = 0.5 * s * (spin + 0.5 * s * change)
    angle = np.linalg.norm(half, axis=1, keepdims=True)
    # sin(angle) / angle, finite at 0.
    return np.concatenate((np.cos(angle), np.sinc(angle / np.pi) * half), axis=1)


def series_turn(spin: FloatArray, change: FloatArray, duration: FloatArray) -> FloatArray:
    """Return the turn by w + b s over a short while, whatever the axes, quaternions (m, 4).

    Parameters
    ----------
    spin, change : (m, 3) float64 [rad/s], [rad/s^2]
        w and b.
    duration : (m,) float64 [s]
        Such that |w + b s| times it is at most `STEP_TURN` at both ends.

    Notes
    -----
    With q = sum C_n, C_0 = 1, the equation q' = w(s) q / 2 says
    (n + 1) C_{n+1} = (w s / 2) C_n + (b s^2 / 2) C_{n-1}. The series converges everywhere; the same
    recurrence in absolute values bounds what is left out. A Magnus integrator of sixth order
    (Blanes and Moan 2006) needs seven times as many steps for 1e-12 rad, and step control besides.
    """
    s = duration[:, np.newaxis]
    by_spin, by_change = 0.5 * s * spin, 0.5 * s * s * change
    previous, term = np.zeros((len(s), 4)), np.zeros((len(s), 4))
    term[:, 0] = 1.0
    total = term.copy()
    for n in range(1, SERIES_TERMS):
        following = (_vector_product(by_spin, term) + _vector_product(by_change, previous)) / n
        previous, term = term, following
        total += term
    norms: FloatArray = np.linalg.norm(total, axis=1, keepdims=True)
    return total / norms


def hamilton_product(p: FloatArray, q: FloatArray) -> FloatArray:
    """Return p q, quaternions (..., 4) with w first: the turn q, then the turn p."""
    w = p[..., :1]
    return w * q + _vector_product(p[..., 1:], q)


def _vector_product(vector: FloatArray, q: FloatArray) -> FloatArray:
    """Return v q, a vector (..., 3) as a quaternion without w, and a quaternion (..., 4)."""
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


def _steps_of(pieces: Pieces, fixed: NDArray[np.bool_]) -> IntArray:
    """Return in how many equal steps to follow each piece, (m,): 1 where its axis stays fixed."""
    last_spin = pieces.spin + pieces.duration[:, np.newaxis] * pieces.change
    # |w + b s| is largest at one of the ends.
    fastest = np.maximum(np.linalg.norm(pieces.spin, axis=1), np.linalg.norm(last_spin, axis=1))
    steps = np.where(fixed, 1.0, np.ceil(fastest * pieces.duration / STEP_TURN))
    if not steps.sum() <= MAX_STEPS:
        raise GhostballError(
            f"`orientation` can't be followed: a ball turns by about {steps.sum():.3g} rad while "
            f"its axis moves, and {MAX_STEPS:g} are the limit. Set `t_max` sooner"
        )
    return np.maximum(steps, 1.0).astype(np.int64)


def _turn(
    spin: FloatArray, change: FloatArray, duration: FloatArray, fixed: NDArray[np.bool_]
) -> FloatArray:
    """Return the turn of each step, (m, 4), the way that suits it."""
    turn = np.empty((len(spin), 4))
    turn[fixed] = fixed_axis_turn(spin[fixed], change[fixed], duration[fixed])
    moving = ~fixed
    turn[moving] = series_turn(spin[moving], change[moving], duration[moving])
    return turn


def _running_product(turns: FloatArray, reached: FloatArray) -> FloatArray:
    """Return the orientation after each of the turns, (m, 4), from `reached` (4,) on.

    In rows of one length, so that short loops over whole columns, then over whole rows, do the work
    of one long loop, and in the same order however many turns there are.
    """
    m = len(turns)
    rows = np.zeros((-(-m // _ROW), _ROW, 4))
    rows[..., 0] = 1.0
    rows.reshape(-1, 4)[:m] = turns
    for column in range(1, _ROW):
        rows[:, column] = hamilton_product(rows[:, column], rows[:, column - 1])
    for row in range(len(rows)):
        rows[row] = hamilton_product(rows[row], reached)
        reached = rows[row, -1] / np.linalg.norm(rows[row, -1])
    return rows.reshape(-1, 4)[:m]
