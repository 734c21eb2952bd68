"""Derivatives of the laws of impacts, by central differences: a new law needs nothing here.

A law that integrates over the impact takes interpreted Python some 30 ms. Such impacts are played
by the kernel of shots, those that differ by a step all at once.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ghostball.engine.core import state as st
from ghostball.engine.core.state import Laws
from ghostball.engine.event_loop import play
from ghostball.engine.impacts.laws.dispatch import (
    ball_law,
    cushion_law,
)
from ghostball.engine.impacts.laws.interface import BallImpact, BallImpulse, CushionImpact
from ghostball.engine.sensitivity.motion import SPIN_OVER_RADIUS
from ghostball.engine.sensitivity.replay import Replay

FloatArray = NDArray[np.float64]


class Law(NamedTuple):
    """What changes the balls of m impacts, seen in the frames of their contacts.

    `given`: takes how the balls come to the impacts, (k, m, d), and returns impulses (k, m, p).
    `spread` (m, d, p): by how much each impulse changes how the balls move. One impulse acts on two
        balls, so that no momentum is lost by the rounding of differences.
    """

    given: Callable[[FloatArray], FloatArray]
    spread: FloatArray


# Parts of how a ball moves in the frame of its contact.
VN, VT, WN, WT, WZ = range(5)
SEEN = 5

_STEP = 2.0**-14
"""Of a central difference, over the largest speed: its error is some 1e-8 of the derivative, or
1e-5 where a law integrates, whose own error of 1e-9 it divides."""

_OVERLAP = 2.0**-48
"""By which balls overlap what they meet where an impact is played [m]: rounding mustn't let it come
later."""

_INSTANT = 2.0**-40
"""For how long an impact is played [s]."""


def differentiated(law: Law, seen: FloatArray, steps: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how balls leave m impacts, (m, d), and its derivative by how they come, (m, d, d).

    `seen` (m, d): how the balls come.
    `steps` (m, d): by how much that changes for a difference.
    """
    m, d = seen.shape
    by = np.zeros((2 * d + 1, m, d))
    for k in range(d):
        by[2 * k, :, k], by[2 * k + 1, :, k] = steps[:, k], -steps[:, k]
    given = law.given(seen + by)
    slopes = (given[:-1:2] - given[1:-1:2]) * (0.5 / steps.T)[:, :, np.newaxis]
    after = seen + (law.spread @ given[-1, :, :, np.newaxis])[:, :, 0]
    return after, np.eye(d) + law.spread @ slopes.transpose(1, 2, 0)


def steps_of_impacts(seen: FloatArray, radii: FloatArray) -> FloatArray:
    """Return steps for differences of impacts of two balls, (m, 10)."""
    by_ball = np.abs(seen.reshape(-1, 2, SEEN))
    speeds = np.maximum(
        np.sum(by_ball[:, :, :WN], axis=2), radii * np.sum(by_ball[:, :, WN:], axis=2)
    )
    step = _STEP * np.max(speeds, axis=1)[:, np.newaxis]
    each = np.stack([step + 0.0 * radii] * WN + [step / radii] * 3, axis=2)
    return each.reshape(len(seen), -1)


def steps_of_bounces(seen: FloatArray, radii: FloatArray) -> FloatArray:
    """Return steps for differences of bounces, (m, 5).

    No law is defined for a ball that leaves: the step along n is a part of the approach.
    """
    size = np.abs(seen)
    speed = np.maximum(np.sum(size[:, :WN], axis=1), radii * np.sum(size[:, WN:], axis=1))
    steps = np.empty_like(seen)
    steps[:, VN], steps[:, VT] = _STEP * seen[:, VN], _STEP * speed
    steps[:, WN:] = (_STEP * speed / radii)[:, np.newaxis]
    return steps


def impacts_by_law(laws: Laws, radii: FloatArray, masses: FloatArray, cloth: FloatArray) -> Law:
    """Return what the balls' law makes of impacts, called as the Python that it is.

    `radii`, `masses`, `cloth` (m, 2): what the law is told of the balls.
    """
    constants = np.stack((radii, masses, cloth), axis=2).tolist()
    share = masses[:, ::-1] / np.sum(masses, axis=1)[:, np.newaxis]
    turn = SPIN_OVER_RADIUS / radii
    spread = np.zeros((len(radii), 2 * SEEN, len(BallImpulse._fields)))
    for k, sign in ((0, -1.0), (1, 1.0)):
        ball, rub_n, rub_t = SEEN * k, 3 + 2 * k, 4 + 2 * k
        spread[:, ball + VN, 0] = spread[:, ball + VT, 1] = sign * share[:, k]
        spread[:, ball + WT, 2] = turn[:, k] * share[:, k]
        spread[:, ball + WZ, 1] = -turn[:, k] * share[:, k]
        spread[:, ball + VN, rub_n] = spread[:, ball + VT, rub_t] = 1.0
        spread[:, ball + WN, rub_t], spread[:, ball + WT, rub_n] = turn[:, k], -turn[:, k]

    def given(seen: FloatArray) -> FloatArray:
        return np.array(
            [
                [
                    ball_law(BallImpact(*one[:SEEN], *first, *one[SEEN:], *second), laws)
                    for one, (first, second) in zip(each, constants, strict=True)
                ]
                for each in seen.tolist()
            ]
        )

    return Law(given, spread)


def bounces_by_law(
    laws: Laws, rows: list[int], radii: FloatArray, masses: FloatArray, cloth: FloatArray
) -> Law:
    """Return what the laws of obstacles make of bounces, called as the Python that they are.

    `rows`: of the obstacles.
    `radii`, `masses`, `cloth` (m,): what the laws are told of the balls.
    """
    constants = list(zip(np.stack((radii, masses, cloth), axis=1).tolist(), rows, strict=True))

    def given(seen: FloatArray) -> FloatArray:
        after = np.array(
            [
                [
                    cushion_law(CushionImpact(*one, *ball), laws, row)[:SEEN]
                    for one, (ball, row) in zip(each, constants, strict=True)
                ]
                for each in seen.tolist()
            ]
        )
        change: FloatArray = after - seen
        return change

    return Law(given, _each_alone(len(rows), SEEN))


def played(
    replay: Replay,
    balls: NDArray[np.intp],
    places: FloatArray,
    frame: FloatArray,
    there: Sequence[tuple[int, ...]],
) -> Law:
    """Return what the engine makes of impacts of one or two balls, by playing them.

    `balls` (m, c): which they are.
    `places` (m, c, 2): where they are [m]; the contact is along n, from the first ball on.
    `frame` (m, 2, 2): what takes a vector to its parts along n and t.
    `there`: rows of the obstacles that are there for each.
    """
    m, count = balls.shape
    which = np.arange(m)[:, np.newaxis]
    moved = places.copy()
    moved[:, 0] += _OVERLAP * frame[:, 0]

    def given(seen: FloatArray) -> FloatArray:
        starts = np.zeros((len(seen), m, replay.count, play.START_COLUMNS))
        starts[..., play.START_PHASE] = st.GONE
        coming = seen.reshape(len(seen), m, count, SEEN)
        its = np.zeros((len(seen), m, count, play.START_COLUMNS))
        its[..., play.START_X : play.START_RISE] = moved
        its[..., play.START_VX : play.START_UP] = _in_frame(frame.transpose(0, 2, 1), coming, VN)
        its[..., play.START_WX : play.START_WZ] = _in_frame(frame.transpose(0, 2, 1), coming, WN)
        its[..., play.START_WZ] = coming[..., WZ]
        its[..., play.START_PHASE] = st.SLIDING
        starts[:, which, balls] = its
        ends = np.empty((len(seen), m, 3, replay.count, 3))
        for alone in set(there):
            these = [k for k in range(m) if there[k] == alone]
            shots = starts[:, these].reshape(-1, *starts.shape[2:])
            played_on = replay.after(shots, _INSTANT, alone)
            ends[:, these] = played_on.reshape(len(seen), len(these), *ends.shape[2:])
        _, velocities, spins = ends[:, which, :, balls].transpose(3, 2, 0, 1, 4)
        after = np.empty_like(coming)
        after[..., VN : VT + 1] = _in_frame(frame, velocities, 0)
        after[..., WN : WT + 1] = _in_frame(frame, spins, 0)
        after[..., WZ] = spins[..., 2]
        return after.reshape(seen.shape) - seen

    return Law(given, _each_alone(m, count * SEEN))


def _each_alone(m: int, d: int) -> FloatArray:
    return np.broadcast_to(np.eye(d), (m, d, d))


def _in_frame(frame: FloatArray, vectors: FloatArray, first: int) -> FloatArray:
    """Return parts `first` and the next of vectors (k, m, c, d), turned by frames (m, 2, 2)."""
    turned: FloatArray = np.einsum("mij,kmcj->kmci", frame, vectors[..., first : first + 2])
    return turned
