"""Propagation of small changes through a shot whose motion is known in closed form."""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Iterable, Iterator
from itertools import repeat
from operator import itemgetter

import numpy as np

from ghostball.engine.core import state as st
from ghostball.engine.core.rows import ObstacleRow
from ghostball.engine.running.from_scene import laws_of, layout_of
from ghostball.engine.sensitivity.motion import PARTS, VX, VY, FloatArray, SegmentedMotion
from ghostball.engine.sensitivity.passages import Passages, links_of, passages
from ghostball.engine.sensitivity.rounding import Rounding
from ghostball.model import ExactTrajectory, Scene
from ghostball.model.events import Events

_Obstacle = namedtuple("_Obstacle", ObstacleRow.__annotations__)  # type: ignore[misc]
"""A row of obstacles whose fields are read ten times as fast as those of the engine's rows."""

_MOST_NUMBERS = 2**20
"""Numbers of changes that are processed at the same time: 8 MB."""


class Carried:
    """Changes of a shot that result from changes of its first state; NaN without a derivative.

    `event_shifts` (events, m) float64 [s]: delay of each event.
    """

    def __init__(
        self,
        scene: Scene,
        trajectory: ExactTrajectory,
        events: Events,
        given: FloatArray | None,
        runs: int = 0,
    ) -> None:
        """Propagate changes along a motion.

        `given` (n, PARTS, m): changes of the first state; None: changes by rounding, of the first
            state and at every event.
        `runs`: without `given`, the number of samples of rounding is LANES times this.
        """
        self._motion = motion = _motion(scene, trajectory)
        first = motion.first[:-1]
        rounding = None
        if given is None:
            rounding = Rounding(motion, runs)
            still = np.zeros((len(first), PARTS))
            given = rounding.at_starts(first, still[:, 0], still)
        else:
            # A ball at rest stops again immediately if the cloth slows it.
            rests = np.equal(motion.segments[first, st.PHASE], st.RESTING)
            given = given.copy()
            given[rests & (motion.state[:, st.ROLL_SLOWING] > 0.0), VX : VY + 1] = 0.0
        self._starts = np.full((len(motion.segments), *given.shape[1:]), math.nan)
        self.event_shifts = np.full((len(events), given.shape[2]), math.nan)
        links = links_of(motion, events)
        self._starts[first] = given
        self._starts[links.lost] = math.nan
        with np.errstate(all="ignore"):
            for some in passages(motion, events, links):
                _pass(some, events["t"], self._starts, self.event_shifts, rounding)

    def known(self, times: FloatArray) -> FloatArray:
        """Return the changes at k times, (k, n, PARTS, m)."""
        rows = self._motion.rows_at(times)
        found = np.empty((*rows.shape, *self._starts.shape[1:]))
        for ball, its in enumerate(rows.T):
            flows = self._motion.flows(its, times - self._motion.segments[its, st.EPOCH])
            found[:, ball] = flows @ self._starts[its]
        return found

    def moved(self, times: FloatArray) -> Iterator[FloatArray]:
        """Yield changes of positions (2, k, n, m) [m], for successive groups of the times."""
        rows = self._motion.rows_at(times)
        step = max(1, _MOST_NUMBERS // (rows.shape[1] * self._starts[0].size))
        for start in range(0, len(times), step):
            some = rows[start : start + step]
            s = times[start : start + step, np.newaxis] - self._motion.segments[some, st.EPOCH]
            moved = self._motion.displacements(some.ravel(), s.ravel(), self._starts)
            yield moved.reshape(2, *some.shape, -1)


def _pass(
    some: list[Passages],
    times: FloatArray,
    starts: FloatArray,
    shifts: FloatArray,
    rounding: Rounding | None,
) -> None:
    """Propagate changes through events, in their order, to the segments that start with them."""
    steps: list[tuple[int, Passages, int, FloatArray | float]] = []
    for each in some:
        added: Iterable[FloatArray | float] = repeat(0.0)
        if rounding is not None:
            count = each.after.shape[1]
            instants = np.repeat(times[each.number], count)
            sizes = np.repeat(each.size, count, axis=0)
            noise = rounding.at_starts(each.after.ravel(), instants, sizes)
            added = noise.reshape(len(each.number), count * PARTS, -1)
        numbers = each.number.tolist()
        steps += zip(numbers, repeat(each), range(len(numbers)), added, strict=False)
    lanes = starts.shape[2]
    for number, of, k, more in sorted(steps, key=itemgetter(0)):
        change = starts[of.before[k]].reshape(-1, lanes)
        shifts[number] = of.later[k] @ change
        starts[of.after[k]] = (of.matrix[k] @ change + more).reshape(-1, PARTS, lanes)


def _motion(scene: Scene, trajectory: ExactTrajectory) -> SegmentedMotion:
    laws = laws_of(scene)
    first = np.cumsum([0, *(len(segments) for segments in trajectory.segments)])
    return SegmentedMotion(
        layout_of(scene),
        laws._replace(obstacles=[_Obstacle(*row) for row in laws.obstacles.tolist()]),
        np.concatenate(trajectory.segments),
        first,
    )
