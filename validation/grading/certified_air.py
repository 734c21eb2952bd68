"""Derivatives of the motion of a ball with air drag, or with quadratic rolling friction.

Straight motion, dv/dt = -(a + b v^2), has closed forms. With w = sqrt(a b), S = sin(w t) / w and c
= cos(w t) + b v0 S:

    v = (v0 cos(w t) - a S) / c,  x = ln(c) / b,  dv/dv0 = 1 / c^2,  dx/dv0 = S / c.

The path of a sliding ball is curved and has no closed form. With the slip u, e = u / |u| and the
deceleration a by the cloth,

    v' = -a e - k |v| v,   u' = -(7/2) a e - k |v| v.

Small changes dv and du obey the linear equation along the integrated motion:

    dv' = -a E du - k D dv,   du' = -(7/2) a E du - k D dv,
    E = (1 - e e^T) / |u|,    D = |v| (1 + v v^T / |v|^2).

It is integrated by collocation at Gauss points (Hairer, Norsett and Wanner, Solving Ordinary
Differential Equations I, section II.7); the error decreases with the 12th power of the step. A step
is at most a quarter of the time in which slip or velocity might vanish, so the error is below
rounding.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from ghostball.model.arrays import FloatArray

SLIP_RATE = 3.5
"""Deceleration of the slip by the cloth, in units of the deceleration of the ball."""

_STAGES = 6

_LONGEST_STEP = 0.3
"""Longest step, in units of the time in which the slip would end."""

_NEGLIGIBLE_TIME = 2.0**-29
"""Remaining time at which a slide counts as ended [s]: the drag changes by less than 1e-9 in this
time.

Pieces are recorded up to half of this time before the end.
"""


class StraightMotion(NamedTuple):
    """State of a ball in straight motion after some time, with derivatives.

    `speed` [m/s].
    `displacement` [m].
    `speed_by_speed`, `displacement_by_speed` [1] and [s]: derivatives by the initial speed.
    """

    speed: float
    displacement: float
    speed_by_speed: float
    displacement_by_speed: float


def straight(v: float, a: float, b: float, t: float) -> StraightMotion:
    """Return the straight motion in a time t [s], decelerated by a + b v^2 [m/s^2], b > 0."""
    w = math.sqrt(a * b)
    turn = w * t
    s = math.sin(turn) / w if turn > 0.0 else t
    beyond = b * v * s - 2.0 * math.sin(0.5 * turn) ** 2  # c - 1
    c = 1.0 + beyond
    speed = max((v * math.cos(turn) - a * s) / c, 0.0)
    return StraightMotion(speed, math.log1p(beyond) / b, 1.0 / (c * c), s / c)


def straight_flow(
    vx: float, vy: float, a: float, b: float, t: float
) -> tuple[FloatArray, FloatArray]:
    """Return the derivatives of position and velocity by the initial velocity, (2, 2) each."""
    v = math.hypot(vx, vy)
    after = straight(v, a, b, t)
    x, y = vx / v, vy / v
    along = np.array([[x * x, x * y], [x * y, y * y]])
    across = np.eye(2) - along
    place = after.displacement_by_speed * along + (after.displacement / v) * across
    velocity = after.speed_by_speed * along + (after.speed / v) * across
    return place, velocity


class SlideSeries(NamedTuple):
    """Velocity and slip of a slide as power series of the time since its start, (powers, 2)."""

    velocity: FloatArray
    slip: FloatArray

    def at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return velocity and slip at some times, (k, 2) each."""
        powers = times[:, np.newaxis] ** np.arange(len(self.velocity))
        return powers @ self.velocity, powers @ self.slip


class Slide(NamedTuple):
    """A piece of a slide in air.

    `e` (2,) float64: direction of the slip at the start of the piece; the slip itself may consist
        of rounding errors only.
    `a`, `k` [m/s^2] and [1/m]: deceleration by the cloth, and drag coefficient of the air.
    """

    series: SlideSeries
    e: FloatArray
    a: float
    k: float

    def flow(self, t: float) -> FloatArray:
        """Return the derivatives at a time t [s] after the start of the piece, (6, 4).

        Derivatives of position, velocity and slip at that time by velocity and slip at the start.
        """
        flow, done, e = self._until_last(t)
        if done == t:
            return flow
        _, (u,) = self.series.at(np.array([done]))
        return _last(e, float(np.hypot(*u)), self.a, t - done) @ flow

    def end(self, t: float) -> tuple[FloatArray, FloatArray]:
        """Return the derivatives at a time t at which the slide ends, and of the end time, (4,).

        With the drag D and c = (7/2) a, c |u| - D.u decreases at the rate c^2 - D^2, for any
        rotation of the slip. A change du shortly before the end therefore delays the end by (c e -
        D).du / (c^2 - D^2). Friction doesn't change v - (2/7) u. These two derivatives are constant
        from shortly before the end, so they are taken there. At the end itself, the direction of
        the slip diverges as the logarithm of the remaining time, and the derivatives across it
        don't vanish.
        """
        flow, done, e = self._until_last(t)
        (v,), _ = self.series.at(np.array([done]))
        drag, c = self.k * float(np.hypot(*v)) * v, SLIP_RATE * self.a
        later = (c * e - drag) / (c * c - float(drag @ drag)) @ flow[4:]
        flow[:2] += (t - done) * flow[2:4]
        return flow, later

    def _until_last(self, t: float) -> tuple[FloatArray, float, FloatArray]:
        """Return the derivatives up to t, or to shortly before the end; also that time, and e."""
        flow = np.zeros((6, 4))
        flow[2:] = np.eye(4)
        done, e = 0.0, self.e
        while done < t:
            (v,), (u,) = self.series.at(np.array([done]))
            size = float(np.hypot(*u))
            e = u / size if done > 0.0 else e
            left = size / (SLIP_RATE * self.a + self.k * float(v @ v))
            if left <= _NEGLIGIBLE_TIME:
                break
            step = min(t - done, _LONGEST_STEP * left)
            flow = _collocated(self.series, self.a, self.k, done, step) @ flow
            done = t if step == t - done else done + step
        return flow, done, e


def _last(e: FloatArray, size: float, a: float, t: float) -> FloatArray:
    """Return the derivatives by position, velocity and slip, (6, 6), if air is negligible."""
    flow = np.eye(6)
    flow[0:2, 2:4] = t * np.eye(2)
    if size > 0.0 and math.isfinite(a / size):
        turn = -(a / size) * (np.eye(2) - np.outer(e, e))
        flow[0:2, 4:6] = 0.5 * t * t * turn
        flow[2:4, 4:6] = t * turn
        flow[4:6, 4:6] += SLIP_RATE * t * turn
    return flow


def _collocated(series: SlideSeries, a: float, k: float, start: float, step: float) -> FloatArray:
    """Return the derivatives over a step by position, velocity and slip, (6, 6)."""
    v, u = series.at(start + step * _NODES)
    rates = np.zeros((_STAGES, 4, 4))
    sizes, speeds = np.hypot(*u.T), np.hypot(*v.T)
    e = u / sizes[:, np.newaxis]
    n = np.divide(v, speeds[:, np.newaxis], out=np.zeros_like(v), where=speeds[:, np.newaxis] > 0.0)
    turns = np.eye(2) - e[:, :, np.newaxis] * e[:, np.newaxis]
    turns *= (a / sizes)[:, np.newaxis, np.newaxis]
    drags = np.eye(2) + n[:, :, np.newaxis] * n[:, np.newaxis]
    drags *= (k * speeds)[:, np.newaxis, np.newaxis]
    rates[:, :2, :2] = rates[:, 2:, :2] = -drags
    rates[:, :2, 2:] = -turns
    rates[:, 2:, 2:] = -SLIP_RATE * turns
    # K_i = M_i (1 + step sum of a_ij K_j).
    whole = np.eye(4 * _STAGES).reshape(_STAGES, 4, _STAGES, 4)
    whole = whole - step * np.einsum("ipq,ij->ipjq", rates, _WEIGHTS)
    size = 4 * _STAGES
    found = np.linalg.solve(whole.reshape(size, size), rates.reshape(size, 4))
    found = found.reshape(_STAGES, 4, 4)
    flow = np.eye(6)
    flow[2:, 2:] += step * np.einsum("i,ipq->pq", _LAST_WEIGHTS, found)
    between = np.eye(4) + step * np.einsum("ij,jpq->ipq", _WEIGHTS, found)
    flow[:2, 2:] = step * np.einsum("i,ipq->pq", _LAST_WEIGHTS, between[:, :2])
    return flow


def _collocation() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the Gauss points on [0, 1], and integration weights up to each point and up to 1."""
    points, weights = legendre.leggauss(_STAGES)
    nodes = np.asarray(0.5 * (points + 1.0), dtype=np.float64)
    powers = nodes[:, np.newaxis] ** np.arange(_STAGES)
    over = nodes[:, np.newaxis] ** np.arange(1, _STAGES + 1) / np.arange(1, _STAGES + 1)
    up_to = np.asarray(np.linalg.solve(powers.T, over.T).T, dtype=np.float64)
    return nodes, up_to, 0.5 * np.asarray(weights, dtype=np.float64)


_NODES, _WEIGHTS, _LAST_WEIGHTS = _collocation()
