"""The interface of tangent maps: the effect of small changes on a shot, for any engine."""

from __future__ import annotations

from typing import Protocol

from numpy.typing import ArrayLike

from ghostball.model.arrays import FloatArray


class TangentMap(Protocol):
    """Effect of m small changes of the initial state of a shot, to first order."""

    def sample(self, times: ArrayLike) -> FloatArray:
        """Return the changes of the state at `times`, (k, m, n, 7) float64.

        For each ball: the changes of position x, y [m], velocity x, y [m/s] and angular velocity x,
        y, z [rad/s] at the given time; not finite if no derivative exists. `times` (k,) are in any
        order; after the end, the changes at the end are returned.
        """
        ...

    @property
    def event_shifts(self) -> FloatArray:
        """Delay of each event [s], (events, m); NaN if no derivative exists."""
        ...

    def growth(self, times: ArrayLike) -> FloatArray:
        """Return the displacement of each ball, (k, n) [m]: root mean square over the changes.

        Infinite if no derivative exists.
        """
        ...

    def horizon(self, instants: FloatArray, tolerance: float, error: float | None) -> float:
        """Return the first time at which `error` times `growth` exceeds the tolerance [s], or inf.

        `instants` (k,), increasing, are the times of the events; between two of them, growth is
        checked at a few times only. `tolerance` is in metres. `error` multiplies the growth; None
        is the bound that the engine guarantees for itself.
        """
        ...
