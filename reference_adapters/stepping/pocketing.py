"""Detection of pocketed balls for all time-stepping engines, which have no holes.

A ball is pocketed when its centre enters the circle of a hole, on the straight line between its
positions at the start and the end of a step. It is then removed from the engine's world: it keeps
its position without motion, and no ball can meet it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ghostball.model import Samples, Scene
from ghostball.model.arrays import BoolArray, FloatArray

DISTANCE_MARGIN = 1e-12
"""Fraction by which a distance is reduced, far more than rounding [1]."""


class Fall(NamedTuple):
    """A ball that is pocketed within a step.

    `pocket`: index in `POCKETS`.
    `part`: fraction of the step that has passed, from 0 to 1.
    `place`: (2,) float64 [m], the centre at that time.
    """

    ball: int
    pocket: int
    part: float
    place: FloatArray


class Pocketing:
    """The holes of a scene, and the balls that have fallen into them.

    `gone`: (n,) bool, which balls have fallen.
    """

    def __init__(self, scene: Scene) -> None:
        holes = () if scene.table is None else scene.table.holes
        self._pockets = [hole.pocket for hole in holes]
        self._centres = np.array([hole.centre for hole in holes]).reshape(-1, 2)
        self._radii = np.array([hole.radius for hole in holes])
        self._places = np.zeros((len(scene.balls), 2))
        self._heights = scene.radii
        self.gone = np.zeros(len(scene.balls), dtype=np.bool_)
        self._any_gone = False
        # Distance that a ball can certainly move before it is in a hole; it makes most steps cheap.
        self._free = np.zeros(len(scene.balls))

    def __bool__(self) -> bool:
        return bool(self._pockets)

    @property
    def here(self) -> BoolArray | slice:
        """Which balls are on the table, as an index; all of them while none is gone."""
        return ~self.gone if self._any_gone else slice(None)

    def take(self, before: FloatArray, after: FloatArray) -> list[Fall]:
        """Return the balls that fall in a step, in order of time; they are gone from now on.

        `before`, `after`: (n, 2) float64 [m], the centres at the start of the step, and at its end
            without falls.
        """
        moves = after - before
        self._free -= np.hypot(moves[:, 0], moves[:, 1])
        near = np.flatnonzero(~(self._free > 0.0) & ~self.gone)
        return self._take_near(near, before, after) if len(near) else []

    def _take_near(
        self, near: NDArray[np.intp], before: FloatArray, after: FloatArray
    ) -> list[Fall]:
        move = (after - before)[near, np.newaxis]
        off = before[near, np.newaxis] - self._centres
        away = np.hypot(off[..., 0], off[..., 1])
        length2 = np.sum(move * move, axis=2)
        along = np.sum(off * move, axis=2)
        gap = (away - self._radii) * (away + self._radii)
        discriminant = along * along - length2 * gap
        enters = (gap > 0.0) & (along < 0.0) & (discriminant >= 0.0)
        # The smaller root of length2 p^2 + 2 along p + gap = 0, computed without cancellation.
        divisor = np.sqrt(np.maximum(discriminant, 0.0)) - along
        parts = np.where(enters, gap / np.where(enters, divisor, 1.0), np.inf)
        parts[gap <= 0.0] = 0.0  # contacts have pushed the ball inside
        length = np.sqrt(length2[:, 0])
        self._free[near] = np.min(away - self._radii, axis=1) * (1.0 - DISTANCE_MARGIN) - length
        falls = []
        for k in np.flatnonzero(np.any(parts <= 1.0, axis=1)).tolist():
            ball, hole = int(near[k]), int(np.argmin(parts[k]))
            part = float(parts[k, hole])
            place = before[ball] + part * (after[ball] - before[ball])
            falls.append(Fall(ball, self._pockets[hole], part, place))
            self.gone[ball] = self._any_gone = True
            self._places[ball] = place
        return sorted(falls, key=lambda fall: fall.part)

    def keep(self, positions: FloatArray) -> None:
        """Write the positions of balls that are gone into positions, (n, 2) or (n, 3) [m]."""
        if not self._any_gone:
            return
        positions[self.gone, :2] = self._places[self.gone]
        if positions.shape[1] > 2:
            positions[self.gone, 2] = self._heights[self.gone]


def instant_of(fall: Fall, start: float, end: float) -> float:
    """Return the time at which a ball fell in a step from `start` to `end` [s]."""
    return min(start + fall.part * (end - start), end)


def states_at_falls(
    before: FloatArray, moving: Samples, falls: list[Fall]
) -> Iterator[tuple[Fall, Samples]]:
    """Yield each fall of a step twice, with the states just before and just after it.

    `before`: (n, 2) float64 [m], the centres at the start of the step.
    `moving`: Samples, arrays (1, n, 3), the state at the end of the step without falls.
    """
    state = Samples(*(array.copy() for array in moving))
    for fall in falls:
        places = moving.positions.copy()
        places[0, :, :2] = before + fall.part * (places[0, :, :2] - before)
        for earlier in falls:
            if earlier.part <= fall.part:
                places[0, earlier.ball, :2] = earlier.place
        state = state._replace(positions=places)
        yield fall, state
        velocities, spins = state.velocities.copy(), state.angular_velocities.copy()
        velocities[0, fall.ball] = spins[0, fall.ball] = 0.0
        state = Samples(places, velocities, spins)
        yield fall, state
