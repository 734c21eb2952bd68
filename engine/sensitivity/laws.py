"""Derivatives of the impact laws, by central differences, so that a new law needs no code here.

A law that integrates over the impact takes about 30 ms in interpreted Python. For these laws, the
compiled kernel simulates all impacts that differ by a step, in one call.
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
    """The law for the balls of m impacts, in the coordinates of their contacts.

    `given`: maps motions of the balls before the impacts, (k, m, d), to impulses (k, m, p).
    `spread` (m, d, p): the change of the balls' motion per impulse. The same impulse acts on both
        balls, so that rounding of differences doesn't change the momentum.
    """

    given: Callable[[FloatArray], FloatArray]
    spread: FloatArray


# Numbers of a ball's motion in the coordinates of its contact.
VN, VT, WN, WT, WZ = range(5)
SEEN = 5

_STEP = 2.0**-14
"""Step of a central difference, relative to the largest speed.

The relative error of the derivative is about 1e-8. It is 1e-5 for a law that integrates, because
the error of such a law, 1e-9, is divided by the step.
"""

_OVERLAP = 2.0**-48
"""Overlap of bodies at the start of a simulated impact [m], so that rounding doesn't delay it."""

_INSTANT = 2.0**-40
"""Duration of the simulation of an impact [s]."""


def differentiated(law: Law, seen: FloatArray, steps: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return motions after m impacts, (m, d), and their derivatives, (m, d, d), by motions before.

    `seen` (m, d): the motions before the impacts.
    `steps` (m, d): the steps of the differences.
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
    """Return the steps of differences for impacts of two balls, (m, 10)."""
    by_ball = np.abs(seen.reshape(-1, 2, SEEN))
    speeds = np.maximum(
        np.sum(by_ball[:, :, :WN], axis=2), radii * np.sum(by_ball[:, :, WN:], axis=2)
    )
    step = _STEP * np.max(speeds, axis=1)[:, np.newaxis]
    each = np.stack([step + 0.0 * radii] * WN + [step / radii] * 3, axis=2)
    return each.reshape(len(seen), -1)


def steps_of_bounces(seen: FloatArray, radii: FloatArray) -> FloatArray:
    """Return the steps of differences for bounces, (m, 5).

    No law is defined for a ball that moves away, so the step along n is a part of the approach.
    """
    size = np.abs(seen)
    speed = np.maximum(np.sum(size[:, :WN], axis=1), radii * np.sum(size[:, WN:], axis=1))
    steps = np.empty_like(seen)
    steps[:, VN], steps[:, VT] = _STEP * seen[:, VN], _STEP * speed
    steps[:, WN:] = (_STEP * speed / radii)[:, np.newaxis]
    return steps


def impacts_by_law(laws: Laws, radii: FloatArray, masses: FloatArray, cloth: FloatArray) -> Law:
    """Return the law of impacts of balls, called as interpreted Python.

    `radii`, `masses`, `cloth` (m, 2): the constants of the balls that the law uses.
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
    """Return the obstacles' laws, called as interpreted Python.

    `rows`: rows of the obstacles.
    `radii`, `masses`, `cloth` (m,): the constants of the balls that the laws use.
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
    """Return the law of impacts of one or two balls, from simulations by the engine.

    `balls` (m, c): indices of the balls.
    `places` (m, c, 2): their positions [m]; the contact is along n, from the first ball on.
    `frame` (m, 2, 2): maps a vector to its components along n and t.
    `there`: the rows of the obstacles that exist for each impact.
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
    """Return components `first` and the next of vectors (k, m, c, d) in frames (m, 2, 2)."""
    turned: FloatArray = np.einsum("mij,kmcj->kmci", frame, vectors[..., first : first + 2])
    return turned
