"""Tell the sliding parts of a path from the rolling ones: what every picture of a motion shares."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ghostball.model import Phase
from ghostball.model.arrays import FloatArray
from ghostball.reports.shots import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes


SLIDING_WIDER = 1.2
"""Added to a line's width where the ball slides [pt]."""

SLIDING_DARKER = 1.5
"""Factor on a line's opacity where the ball slides."""


def draw_motion(
    axes: Axes,
    run: Run,
    *,
    against_time: bool = False,
    colours: Sequence[str] | None = None,
    **look: Any,
) -> None:
    """Draw the paths of all balls of a run; where they slide, as `sliding_look` says.

    `run`: with a motion.
    `against_time`: draw x against time rather than y against x.
    `colours`: of the balls' paths, instead of one for all in `look`.
    `**look`: goes to matplotlib's `plot`; `linewidth` and `alpha` must be in it.
    """
    motion = run.motion
    assert motion is not None
    for ball in range(motion.positions.shape[1]):
        if colours is not None:
            look["color"] = colours[ball]
        x, y = motion.positions[:, ball, 0], motion.positions[:, ball, 1]
        line = np.column_stack((motion.times, x) if against_time else (x, y))
        if motion.phases is None:
            axes.plot(*line.T, **look)
            continue
        for slides, part in parts_of(line, motion.phases[:, ball] == Phase.SLIDING):
            # Rounded ends of two parts would overlap and show through each other.
            ends = {"solid_capstyle": "butt"}
            axes.plot(*part.T, **(look | ends | (sliding_look(look) if slides else {})))


def sliding_look(look: dict[str, Any]) -> dict[str, Any]:
    """Return what of a line's look differs where the ball slides.

    Wider and darker: that prints, and everyone sees it. Dashes would hide a slide of a few
    centimetres, and the colour says whose line it is.
    """
    return {
        "linewidth": look["linewidth"] + SLIDING_WIDER,
        "alpha": min(SLIDING_DARKER * look["alpha"], 1.0),
    }


def parts_of(line: FloatArray, slides: NDArray[np.bool_]) -> Iterator[tuple[bool, FloatArray]]:
    """Yield whether a part slides, and its points, (m, 2), for the rolling and the sliding part.

    `line` (k, 2) float64.
    `slides` (k,) bool: whether the ball slides from each point on.

    Stretches of the same part are joined by NaN, where matplotlib lifts the pen: one line however
    often the phase changes. Neighbouring stretches share a point, so that no gap opens.
    """
    changes = np.flatnonzero(np.diff(slides[:-1])) + 1
    bounds = [0, *changes.tolist(), len(line) - 1]
    for wanted in (False, True):
        stretches = [
            np.vstack((line[start : end + 1], np.full((1, line.shape[1]), np.nan)))
            for start, end in pairwise(bounds)
            if slides[start] == wanted
        ]
        if stretches:
            yield wanted, np.concatenate(stretches)[:-1]
