"""How a ball that air or fast rolling slows depends on how it began: derivatives of its motion.

A ball that only goes straight on, dv/dt = -(a + b v^2), has closed forms. With w = sqrt(a b),
S = sin(w t) / w and c = cos(w t) + b v0 S:

    v = (v0 cos(w t) - a S) / c,  x = ln(c) / b,  dv/dv0 = 1 / c^2,  dx/dv0 = S / c.

A ball that slides turns, and has none: with the slip u, e = u / |u| and the cloth's a,

    v' = -a e - k |v| v,   u' = -(7/2) a e - k |v| v.

What a small change of both becomes is what the linear equation along the integrated motion says:

    dv' = -a E du - k D dv,   du' = -(7/2) a E du - k D dv,
    E = (1 - e e^T) / |u|,    D = |v| (1 + v v^T / |v|^2).

It is integrated by collocation at Gauss's points (Hairer, Norsett and Wanner, Solving Ordinary
Differential Equations I, section II.7), whose error falls with the 12th power of the step. Pieces
of the motion are as short as a quarter of the time in which the slip or the velocity might vanish,
so that it is below rounding.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from ghostball.model.arrays import FloatArray

SLIP_RATE = 3.5
"""By what the cloth slows a slip, in units of that by which it slows the ball."""

_STAGES = 6

_STEP = 0.3
"""Longest step, in units of the time in which the slip would end."""

_LAST = 2.0**-29
"""What is left of a slide when it counts as its end [s]: the drag then is the same to 1e-9.

Pieces are recorded to half of that before the end.
"""


class Straight(NamedTuple):
    """What a ball that goes straight on has come to after a time.

    `speed` [m/s].
    `displacement` [m].
    `speed_by_speed`, `displacement_by_speed` [1] and [s]: derivatives by the first speed.
    """

    speed: float
    displacement: float
    speed_by_speed: float
    displacement_by_speed: float


def straight(v: float, a: float, b: float, t: float) -> Straight:
    """Return how far a ball comes in a time t [s], b > 0, slowed by a + b v^2 [m/s^2]."""
    w = math.sqrt(a * b)
    turn = w * t
    s = math.sin(turn) / w if turn > 0.0 else t
    beyond = b * v * s - 2.0 * math.sin(0.5 * turn) ** 2  # c - 1
    c = 1.0 + beyond
    speed = max((v * math.cos(turn) - a * s) / c, 0.0)
    return Straight(speed, math.log1p(beyond) / b, 1.0 / (c * c), s / c)


def straight_flow(
    vx: float, vy: float, a: float, b: float, t: float
) -> tuple[FloatArray, FloatArray]:
    """Return the derivatives of place and velocity by the first velocity, (2, 2) each."""
    v = math.hypot(vx, vy)
    after = straight(v, a, b, t)
    x, y = vx / v, vy / v
    along = np.array([[x * x, x * y], [x * y, y * y]])
    across = np.eye(2) - along
    place = after.displacement_by_speed * along + (after.displacement / v) * across
    velocity = after.speed_by_speed * along + (after.speed / v) * across
    return place, velocity


class Series(NamedTuple):
    """Velocity and slip of a slide in powers of the time since a piece began, (powers, 2) each."""

    velocity: FloatArray
    slip: FloatArray

    def at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return velocity and slip at some times, (k, 2) each."""
        powers = times[:, np.newaxis] ** np.arange(len(self.velocity))
        return powers @ self.velocity, powers @ self.slip


class Slide(NamedTuple):
    """A piece of a slide in air.

    `e` (2,) float64: where the slip points to as the piece begins: its series may have but rounding
        left.
    `a`, `k` [m/s^2] and [1/m]: friction of the cloth, and the air's drag.
    """

    series: Series
    e: FloatArray
    a: float
    k: float

    def flow(self, t: float) -> FloatArray:
        """Return the derivatives a time t [s] into the piece, (6, 4).

        Of place, velocity and slip then by velocity and slip at its start.
        """
        flow, done, e = self._until_last(t)
        if done == t:
            return flow
        _, (u,) = self.series.at(np.array([done]))
        return _last(e, float(np.hypot(*u)), self.a, t - done) @ flow

    def end(self, t: float) -> tuple[FloatArray, FloatArray]:
        """Return the same where the slide ends after a time t, and how much later it ends, (4,).

        With the drag D and c = (7/2) a, c |u| - D.u falls at the rate c^2 - D^2, whatever way the
        slip turns: so the end comes later by (c e - D).du / (c^2 - D^2), of any instant shortly
        before. Nor does v - (2/7) u change by the friction. So both are carried on as they are: the
        slip turns without end, as the logarithm of the time that is left, and what is across it
        does not vanish.
        """
        flow, done, e = self._until_last(t)
        (v,), _ = self.series.at(np.array([done]))
        drag, c = self.k * float(np.hypot(*v)) * v, SLIP_RATE * self.a
        later = (c * e - drag) / (c * c - float(drag @ drag)) @ flow[4:]
        flow[:2] += (t - done) * flow[2:4]
        return flow, later

    def _until_last(self, t: float) -> tuple[FloatArray, float, FloatArray]:
        """Return the derivatives up to a time t, or to shortly before the end; that time, and e."""
        flow = np.zeros((6, 4))
        flow[2:] = np.eye(4)
        done, e = 0.0, self.e
        while done < t:
            (v,), (u,) = self.series.at(np.array([done]))
            size = float(np.hypot(*u))
            e = u / size if done > 0.0 else e
            left = size / (SLIP_RATE * self.a + self.k * float(v @ v))
            if left <= _LAST:
                break
            step = min(t - done, _STEP * left)
            flow = _collocated(self.series, self.a, self.k, done, step) @ flow
            done = t if step == t - done else done + step
        return flow, done, e


def _last(e: FloatArray, size: float, a: float, t: float) -> FloatArray:
    """Return the derivatives by place, velocity and slip, (6, 6), where air changes nothing."""
    flow = np.eye(6)
    flow[0:2, 2:4] = t * np.eye(2)
    if size > 0.0 and math.isfinite(a / size):
        turn = -(a / size) * (np.eye(2) - np.outer(e, e))
        flow[0:2, 4:6] = 0.5 * t * t * turn
        flow[2:4, 4:6] = t * turn
        flow[4:6, 4:6] += SLIP_RATE * t * turn
    return flow


def _collocated(series: Series, a: float, k: float, start: float, step: float) -> FloatArray:
    """Return the derivatives over a step by place, velocity and slip, (6, 6)."""
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
    """Return Gauss's points on [0, 1], and the weights up to each of them and up to 1."""
    points, weights = legendre.leggauss(_STAGES)
    nodes = np.asarray(0.5 * (points + 1.0), dtype=np.float64)
    powers = nodes[:, np.newaxis] ** np.arange(_STAGES)
    over = nodes[:, np.newaxis] ** np.arange(1, _STAGES + 1) / np.arange(1, _STAGES + 1)
    up_to = np.asarray(np.linalg.solve(powers.T, over.T).T, dtype=np.float64)
    return nodes, up_to, 0.5 * np.asarray(weights, dtype=np.float64)


_NODES, _WEIGHTS, _LAST_WEIGHTS = _collocation()
