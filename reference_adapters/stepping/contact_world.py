"""Shared code of the worlds of external engines: active contacts, and which of them are new."""

from __future__ import annotations

from collections.abc import Sequence, Set

import numpy as np
from numpy.typing import NDArray

from ghostball.model import Scene
from ghostball.model.arrays import BoolArray, FloatArray
from ghostball.reference_adapters.stepping.laws import largest_momenta
from ghostball.reference_adapters.stepping.plane import Collision, Planned

WorldBody = tuple[int, bool]
"""A ball or a cushion of a world: its index, and True for a cushion."""

SINGLE_PRECISION_NOISE = 16.0 * float(np.finfo(np.float32).eps)
"""Impulses below this fraction of the largest momentum are rounding, in single precision [1]."""

DOUBLE_PRECISION_NOISE = 1e-12
"""The same for double precision, including the residual of a solver [1]."""

THICKNESS = 1e-6
"""Half the thickness of a cushion segment [m]: a thin box, in an engine without finite planes."""

REMOVED_COORDINATE = -1e4
"""Coordinate to which removed balls are moved [m]."""


class UnroundedPlans:
    """Planned steps of a `PlaneWorld` of an engine in double precision.

    There `start` returns the velocities unrounded. A world in single precision must override
    `planned`, unless its `touched` is always True, because then no step is planned.
    """

    def start(self, velocities: FloatArray, spins: FloatArray | None) -> FloatArray:
        """Set the velocities and spins of the balls for a step; see `PlaneWorld`."""
        raise NotImplementedError

    def planned(self, velocities: FloatArray) -> Sequence[Planned]:
        """Return the velocities of coming steps, (k, n, 2) [m/s]; see `PlaneWorld`."""
        return [(one, None) for one in velocities]

    def start_planned(self, planned: Planned) -> None:
        """Set the velocities for a step; see `PlaneWorld`."""
        self.start(planned[0], None)


class ContactWorld(UnroundedPlans):
    """Base class of a `PlaneWorld` whose steps find contacts, then solve velocities, then move.

    `noise`: impulses below this fraction of the largest possible momentum are ignored.
    `rubs`: whether contacts may change spins.
    `units`: units of length of the engine per metre [1/m].

    `collisions`, `contacts_solved`, `touched`, `rubs`: as in `PlaneWorld`.
    """

    collides_first = True
    touched = True

    def __init__(self, scene: Scene, *, noise: float, rubs: bool, units: float = 1.0) -> None:
        self.collisions: list[Collision] = []
        self.contacts_solved = 0
        self.rubs = rubs
        self._scene = scene
        self._units = units
        self._noise = noise * units * float(np.max(largest_momenta(scene)))
        self._pushing: Set[Collision] = set()
        self._lasting: Set[Collision] = set()
        self._given, self._start = scene.velocities[:, :2], scene.angular_velocities

    def turns(self) -> FloatArray:
        """Return the spin changes by contacts of the step, (n, 3) [rad/s]: 0 without friction."""
        return np.zeros_like(self._start)

    def _note(self, pushing: Set[Collision], near: Set[Collision] = frozenset()) -> None:
        """Store the active contacts of a step; contacts that weren't active before are collisions.

        A contact that is inactive during one step, but stays `near`, is still the same collision.
        """
        if not pushing and not self._lasting:
            if self._pushing or self.collisions:
                self._pushing, self.collisions = pushing, []
            return
        self.contacts_solved += len(pushing)
        self.collisions = sorted(pushing - self._lasting)
        self._lasting = pushing | (self._lasting & near)
        self._pushing = pushing

    def _kept(self, velocities: FloatArray) -> FloatArray:
        """Return the velocities, (n, 2) [m/s]; those of balls without contact are unchanged."""
        if not self._pushing:
            return self._given.copy()
        free = untouched(len(velocities), self._pushing)
        velocities[free] = self._given[free]
        return velocities

    def _turned(self, spins: FloatArray) -> FloatArray:
        turns = spins - self._start
        turns[untouched(len(turns), self._pushing)] = 0.0
        return turns


def untouched(n: int, pushing: Set[Collision]) -> BoolArray:
    """Return which of n balls have no active contact, (n,) bool.

    The velocities of these balls may still change by rounding, if the engine uses other frames of
    reference. Such a change isn't a collision.
    """
    free = np.ones(n, dtype=bool)
    for contact in pushing:
        free[contact.balls] = False
    return free


def tuples_of(vectors: NDArray[np.floating]) -> list[tuple[tuple[float, ...], ...]]:
    """Return the vectors of the balls in coming steps, (k, n, m), as k tuples of n tuples.

    Engines read tuples faster than arrays. This function is faster than a loop over balls.
    """
    k, n, m = vectors.shape
    columns = iter(vectors.reshape(k, n * m).T.tolist())
    balls = zip(*[columns] * m, strict=True)
    return list(zip(*(zip(*ball, strict=True) for ball in balls), strict=True))


def collision_of(one: WorldBody, other: WorldBody) -> Collision:
    """Return the collision of two bodies of a world; the ball of smaller index comes first."""
    first, second = (one, other) if one[::-1] <= other[::-1] else (other, one)
    return Collision(first[0], *second)
