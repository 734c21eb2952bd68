"""What becomes of small changes of a shot: of which kind the answer is, whoever finds it."""

from __future__ import annotations

from typing import Protocol

from numpy.typing import ArrayLike

from ghostball.model.arrays import FloatArray


class TangentMap(Protocol):
    """What becomes of m small changes of a shot's first state, to first order."""

    def sample(self, times: ArrayLike) -> FloatArray:
        """Return the changes at `times`, (k, m, n, 7) float64.

        For each ball the change of its position x, y [m], velocity x, y [m/s] and angular velocity
        x, y, z [rad/s] at the same instant; not finite where no derivative exists. `times` (k,)
        are in any order; past the end it is as at the end.
        """
        ...

    @property
    def event_shifts(self) -> FloatArray:
        """How much later each event comes [s], (events, m); NaN where no derivative exists."""
        ...

    def growth(self, times: ArrayLike) -> FloatArray:
        """Return how far each ball is displaced, (k, n) [m]: root mean square over the changes.

        Infinite where no derivative exists.
        """
        ...

    def horizon(self, instants: FloatArray, tolerance: float, error: float | None) -> float:
        """Return the first instant at which error times `growth` exceeds a tolerance [s].

        inf where that never happens. `instants` (k,), increasing, are those of the events; between
        two of them growth is looked for at a few instants only. `tolerance` is in metres; `error`
        is what a growth is multiplied by, None what the engine itself stays within.
        """
        ...
