"""What the worlds of foreign engines share: which contacts push, and which of them are new."""

from __future__ import annotations

from collections.abc import Set

import numpy as np

from ghostball.model import Scene
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.stepping.laws import largest_momenta
from ghostball.reference_adapters.stepping.plane import Collision, untouched

Part = tuple[int, bool]
"""A ball or a cushion of a world: its index, and whether it is a cushion."""

SINGLE = 16.0 * float(np.finfo(np.float32).eps)
"""Share of the largest momentum below which an impulse of single precision is rounding."""

DOUBLE = 1e-12
"""The same of double precision, and of what a solver leaves."""


class ContactWorld:
    """Part of a `PlaneWorld`: its steps find contacts, solve velocities, then move.

    `noise`: impulse that is none, over the largest momentum that a ball may have.
    `rubs`: whether contacts may turn balls.
    `units` [1/m]: units of the engine in a metre.

    `collisions`, `contacts_solved`, `rubs`: as `PlaneWorld` has them.
    """

    collides_first = True

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
        """Return what the step's contacts added to the spins, (n, 3) [rad/s]: nothing rubs."""
        return np.zeros_like(self._start)

    def _note(self, pushing: Set[Collision], near: Set[Collision] = frozenset()) -> None:
        """Take the contacts that pushed in a step: those that did not push before are collisions.

        One that stops pushing for a step, but stays `near`, is still the same collision.
        """
        self.contacts_solved += len(pushing)
        self.collisions = sorted(pushing - self._lasting)
        self._lasting = pushing | (self._lasting & near)
        self._pushing = pushing

    def _kept(self, velocities: FloatArray) -> FloatArray:
        """Return the velocities, (n, 2) [m/s], of balls that nothing pushed as they were given."""
        free = untouched(len(velocities), self._pushing)
        velocities[free] = self._given[free]
        return velocities

    def _turned(self, spins: FloatArray) -> FloatArray:
        turns = spins - self._start
        turns[untouched(len(turns), self._pushing)] = 0.0
        return turns


def collision_of(one: Part, other: Part) -> Collision:
    """Return the collision of two parts of a world; of two balls, the first one comes first."""
    first, second = (one, other) if one[::-1] <= other[::-1] else (other, one)
    return Collision(first[0], *second)
