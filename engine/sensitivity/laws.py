"""Derivatives of impacts, by central differences, so that a new law needs no code here.

The compiled kernel of shots simulates all impacts that differ by a step, in one call.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ghostball.engine.core import state as st
from ghostball.engine.core.state import Laws
from ghostball.engine.event_loop import play
from ghostball.engine.running.from_scene import SceneLayout
from ghostball.engine.sensitivity.replay import alone, states_after

FloatArray = NDArray[np.float64]

_SLIDES = Laws._fields.index("slides")

# Numbers of a ball's motion in the coordinates of its contact.
VN, VT, WN, WT, WZ = range(5)
SEEN = 5

_STEP = 2.0**-14
"""Step of a central difference, relative to the largest speed or, along n, to the approach speed.

The relative error of the derivative is about 1e-8. It is 1e-5 for a law that integrates, because
the error of such a law, 1e-9, is divided by the step.
"""

_OVERLAP = 2.0**-48
"""Overlap of bodies at the start of a simulated impact [m], so that rounding doesn't delay it."""

_INSTANT = 2.0**-40
"""Duration of the simulation of an impact [s]."""


def differentiated(
    outcomes: Callable[[FloatArray], FloatArray], seen: FloatArray, radii: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the motions of c balls after m impacts, (m, c SEEN), and their derivatives.

    The derivatives by the motions before the impacts are (m, c SEEN, c SEEN).

    `outcomes`: function from motions before the impacts, (k, m, c, SEEN), to motions after them;
        see `played`.
    `seen` (m, c, SEEN): the motions before the impacts.
    `radii` (m, c) [m].
    """
    m, c, _ = seen.shape
    steps = _steps(seen, radii).reshape(m, -1)
    d = steps.shape[1]
    by = np.zeros((2 * d + 1, m, d))
    for k in range(d):
        by[2 * k, :, k], by[2 * k + 1, :, k] = steps[:, k], -steps[:, k]
    after = outcomes(seen + by.reshape(-1, m, c, SEEN)).reshape(by.shape)
    slopes = (after[:-1:2] - after[1:-1:2]) * (0.5 / steps.T)[:, :, np.newaxis]
    return after[-1], slopes.transpose(1, 2, 0)


def _steps(seen: FloatArray, radii: FloatArray) -> FloatArray:
    """Return the steps of the differences, (m, c, SEEN).

    Bodies that separate have no impact, so the step along n is a part of the approach speed.
    """
    size = np.abs(seen)
    speeds = np.maximum(np.sum(size[..., :WN], axis=2), radii * np.sum(size[..., WN:], axis=2))
    steps = np.empty_like(seen)
    steps[...] = np.max(speeds, axis=1)[:, np.newaxis, np.newaxis]
    steps[..., WN:] /= radii[..., np.newaxis]
    steps[..., VN] = (seen[:, 0, VN] - np.sum(seen[:, 1:, VN], axis=1))[:, np.newaxis]
    return _STEP * steps


def played(
    layout: SceneLayout,
    balls: NDArray[np.intp],
    places: FloatArray,
    frame: FloatArray,
    met: Sequence[tuple[int, ...]],
) -> Callable[[FloatArray], FloatArray]:
    """Return the map of motions before m impacts to those after them, (k, m, c, SEEN) each.

    The engine simulates each impact alone.

    `layout`: that of the scene.
    `balls` (m, c): indices of the balls, one or two for each impact.
    `places` (m, c, 2): their positions [m]; the contact is along n, from the first ball on.
    `frame` (m, 2, 2): maps a vector to its components along n and t.
    `met`: the rows of the obstacles that the balls hit, for each impact.
    """
    moved = places.copy()
    moved[:, 0] += _OVERLAP * frame[:, 0]
    back = frame.transpose(0, 2, 1)
    constants = layout.state[:, st.RADIUS : st.CLOTH_FRICTION + 1]
    like: dict[tuple[bytes, tuple[int, ...]], list[int]] = {}  # impacts of balls that are alike
    for k, (its, rows) in enumerate(zip(balls, met, strict=True)):
        like.setdefault((constants[its].tobytes(), rows), []).append(k)
    slides = layout.laws[_SLIDES] != 0.0

    def outcomes(seen: FloatArray) -> FloatArray:
        starts = np.zeros((*seen.shape[:3], play.START_COLUMNS))
        starts[..., play.START_X : play.START_RISE] = moved
        starts[..., play.START_VX : play.START_UP] = _in_frame(back, seen, VN)
        starts[..., play.START_WX : play.START_WZ] = _in_frame(back, seen, WN)
        starts[..., play.START_WZ] = seen[..., WZ]
        starts[..., play.START_PHASE] = st.SLIDING if slides else st.ROLLING
        ends = np.empty((*seen.shape[:2], 3, seen.shape[2], 3))
        for (_, rows), these in like.items():
            shots = starts[:, these].reshape(-1, *starts.shape[2:])
            found = states_after(alone(layout, balls[these[0]], rows), shots, _INSTANT)
            ends[:, these] = found.reshape(len(seen), len(these), *ends.shape[2:])
        after = np.empty_like(seen)
        after[..., VN : VT + 1] = _in_frame(frame, ends[:, :, 1], 0)
        after[..., WN : WT + 1] = _in_frame(frame, ends[:, :, 2], 0)
        after[..., WZ] = ends[:, :, 2, :, 2]
        return after

    return outcomes


def _in_frame(frame: FloatArray, vectors: FloatArray, first: int) -> FloatArray:
    """Return components `first` and the next of vectors (k, m, c, d) in frames (m, 2, 2)."""
    turned: FloatArray = np.einsum("mij,kmcj->kmci", frame, vectors[..., first : first + 2])
    return turned
