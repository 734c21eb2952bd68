"""Fit coefficients to events whose initial values have measurement errors, too.

A model maps the measured values before an event, z, to the values seen after it, y. Both have
errors. For given coefficients, the best z of each event is computed: the one with the least sum of
squares of the residuals of y and of z, in measurement errors. The remaining misfit depends on the
coefficients only, and SciPy's `least_squares` minimises it. This is orthogonal distance regression
(Boggs, Byrd and Schnabel 1987), event by event.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import least_squares

from ghostball.model import Physics
from ghostball.model.arrays import FloatArray
from ghostball.validation.measured.fit.event_simulation import StartedEvent
from ghostball.validation.measured.fit.events import FitEvent

Predict = Callable[[Physics, Sequence[StartedEvent]], Sequence[FloatArray]]
"""Simulates events from given initial values, and returns the values that would be seen."""

HUBER = 2.5
"""Size of a residual, in errors, above which it counts linearly instead of by its square (Huber
1964).
"""
_TRIALS = 30
"""Largest number of steps of a search."""
_HALVINGS = 6
_LINEAR = 0.02
"""Largest deviation of an event from its linear approximation, in errors."""
_CONVERGED = 0.05
"""Change of a value, in standard errors, below which a search has converged."""
_LONGEST_STEP = 40.0
"""Largest change of a value in one step, in difference steps: beyond it, no model is linear."""


@dataclass(frozen=True)
class Field:
    """A coefficient of the physics that can be fitted."""

    name: str
    low: float
    high: float
    step: float  # for derivatives
    felt_by: frozenset[str]  # families of events that it affects


@dataclass(frozen=True)
class Assumed:
    """An assumption about a field before the fit: its mean and its standard deviation."""

    mean: float
    spread: float


@dataclass(frozen=True)
class Solution:
    """Fitted values (p,), their covariance (p, p), and the residuals of the events."""

    values: FloatArray
    covariance: FloatArray
    residuals: FloatArray
    """The residuals of each event, in measurement errors (n, k)."""
    befores: Sequence[FloatArray]
    """The values before each event with the best agreement."""
    free: int
    """Number of seen values, minus one for each event with an unknown side."""
    misfit: float
    """The minimised misfit: of all events and of the assumptions."""
    settled: bool
    """Whether the search converged."""
    assumed: Mapping[str, float] = field(default_factory=dict)
    """The values found for assumed fields, which aren't among `values`."""

    @property
    def misfits(self) -> FloatArray:
        """The misfit of each event (n,): the sum of squared residuals, with large ones reduced."""
        return np.asarray(np.sum(_huber(self.residuals), axis=1))

    @property
    def errors(self) -> FloatArray:
        """The standard errors of the values, (p,)."""
        return np.sqrt(np.diag(self.covariance))


def goodness(solutions: Sequence[Solution]) -> float:
    """Return the misfit for each degree of freedom: 1 if only noise is left."""
    spare = sum(one.free - len(one.values) for one in solutions)
    return float(sum(np.sum(one.misfits) for one in solutions)) / max(spare, 1)


@dataclass(frozen=True)
class _Nearest:
    """The values before an event, z (m,), with the best agreement.

    `left` (k + m,): residuals of the seen values and of the values before, in errors; `slope` (k +
        m, m): their derivatives by z.
    """

    before: FloatArray
    left: FloatArray
    slope: FloatArray


Asking = Generator[Sequence[FloatArray], Sequence[FloatArray], _Nearest]
"""A search that requests simulations of an event from several initial values, and returns the best.
"""


class _Weighed:
    """An event, with matrices that make its measurement errors independent and of variance 1."""

    def __init__(self, event: FitEvent) -> None:
        self.event = event
        self._seen = np.linalg.inv(np.linalg.cholesky(event.seen_covariance))
        self._given = np.linalg.inv(np.linalg.cholesky(event.given_covariance))

    def nearest(self, starts: Sequence[FloatArray], known: FloatArray | None = None) -> Asking:
        """Search the best values before the event by the Gauss-Newton method, from the best start.

        `known`: the derivatives at the only start, if they are known.
        """
        lefts = yield from self._ask(starts)
        best = min(range(len(starts)), key=lambda k: _squares(lefts[k]))
        before, left = starts[best], lefts[best]
        for trial in range(_TRIALS):
            if known is None or trial:
                steps = self.event.steps
                moved = yield from self._ask([before + step for step in np.diag(steps)])
                slope = (np.column_stack(moved) - left[:, None]) / steps
            else:
                slope = known
            step = np.linalg.lstsq(slope, -left, rcond=None)[0]
            change = slope @ step
            if _squares(change) < _LINEAR**2:
                return _Nearest(before + step, left + change, slope)
            for _ in range(_HALVINGS):
                (tried,) = yield from self._ask([before + step])
                if _squares(tried - left - change) < _LINEAR**2:
                    return _Nearest(before + step, tried, slope)
                if _squares(tried) < _squares(left):
                    before, left = before + step, tried
                    break
                step, change = step / 2.0, change / 2.0
            else:
                break
        return _Nearest(before, left, slope)

    def _ask(
        self, befores: Sequence[FloatArray]
    ) -> Generator[Sequence[FloatArray], Sequence[FloatArray], list[FloatArray]]:
        """Return the residuals for each of some initial values, (k + m,)."""
        seen = yield befores
        return [
            np.concatenate(
                [self._seen @ (self.event.seen - one), self._given @ (self.event.given - before)]
            )
            for one, before in zip(seen, befores, strict=True)
        ]

    def seen_left(self, near: _Nearest) -> FloatArray:
        """Return the residuals of the seen values alone (k,), with the errors of both sides."""
        count = len(self._seen)
        pull = near.slope[:count] @ np.linalg.inv(near.slope[count:])
        spread = np.linalg.cholesky(np.eye(count) + pull @ pull.T)
        return np.asarray(np.linalg.solve(spread, near.left[:count] - pull @ near.left[count:]))


class FitProblem:
    """A fit of coefficients to events.

    `events`: of one family.
    `fields`: the coefficients; `build` returns the physics for their values.
    `predict`: simulates events.
    `assumed`: by field, an assumption about its value.
    """

    def __init__(
        self,
        events: Sequence[FitEvent],
        fields: Sequence[Field],
        build: Callable[[FloatArray], Physics],
        predict: Predict,
        assumed: Mapping[str, Assumed] | None = None,
    ) -> None:
        self._events = [_Weighed(one) for one in events]
        self._build, self._predict = build, predict
        self._low = np.array([one.low for one in fields])
        self._high = np.array([one.high for one in fields])
        self._steps = np.array([one.step for one in fields])
        known = [(assumed or {}).get(one.name) for one in fields]
        self._means = np.array([0.0 if one is None else one.mean for one in known])
        self._precisions = np.array([0.0 if one is None else one.spread**-2 for one in known])

    def solve(self, start: FloatArray, befores: Sequence[FloatArray] | None = None) -> Solution:
        """Return the values with the best fit.

        `start`: initial values of the search.
        `befores`: the values before each event from an earlier fit, if there was one.
        """
        values = np.clip(start, self._low, self._high)
        starts = [one.event.guesses for one in self._events]
        if befores is not None:
            starts = [[before, *guesses] for before, guesses in zip(befores, starts, strict=True)]
        found: Sequence[_Nearest] = self._together(
            values, [one.nearest(own) for one, own in zip(self._events, starts, strict=True)]
        )
        shots = [
            one.event.shot for one, near in zip(self._events, found, strict=True) for _ in near.left
        ]
        for _ in range(_TRIALS):
            slopes = self._slopes(values, found)
            before = values
            values, found, settled = self._better(values, found, slopes)
            if np.array_equal(values, before):
                break
        return Solution(
            values,
            covariance_of(slopes, _left(found), shots, self._precisions),
            np.array([one.seen_left(near) for one, near in zip(self._events, found, strict=True)]),
            [near.before for near in found],
            sum(len(one.event.seen) - one.event.hides_side for one in self._events),
            self._misfit(values, found),
            settled,
        )

    def _better(
        self, values: FloatArray, found: Sequence[_Nearest], slopes: FloatArray
    ) -> tuple[FloatArray, Sequence[_Nearest], bool]:
        """Return better values, the values before each event, and whether they have converged.

        The step is that of the linear approximation, halved until the misfit decreases. The values
        are unchanged and converged if the full step is negligible; unchanged and not converged if
        the misfit doesn't decrease along the step.
        """
        weights = np.sqrt(self._precisions)
        left = np.concatenate([_left(found), weights * (values - self._means)])
        every = np.vstack([slopes, np.diag(weights)])
        told = np.linalg.pinv(every.T @ every, hermitian=True)
        errors = np.sqrt(np.maximum(np.diag(told), 0.0))
        reach = _LONGEST_STEP * self._steps
        step = (
            least_squares(
                lambda numbers: left + every @ (numbers - values),
                values,
                lambda _: every,
                bounds=(
                    np.maximum(self._low, values - reach),
                    np.minimum(self._high, values + reach),
                ),
                x_scale=self._steps,
                loss="huber",
                f_scale=HUBER,
            ).x
            - values
        )
        step[~np.any(every, axis=0)] = 0.0
        close = _CONVERGED * errors
        if np.all(np.abs(step) <= close):
            return values, found, True
        for _ in range(_HALVINGS):
            nearest = self._beside(values + step, found)
            if self._misfit(values + step, nearest) < self._misfit(values, found):
                return values + step, nearest, False
            step = step / 2.0
            if np.all(np.abs(step) <= close):
                break
        return values, found, False

    def _misfit(self, values: FloatArray, found: Sequence[_Nearest]) -> float:
        """Return the misfit of all events and of the assumptions."""
        assumed = np.sqrt(self._precisions) * (values - self._means)
        return float(np.sum(_huber(np.concatenate([_left(found), assumed]))))

    def _slopes(self, values: FloatArray, found: Sequence[_Nearest]) -> FloatArray:
        """Return the derivatives of the residuals by the fields."""
        room = values + self._steps <= self._high
        moves = np.where(room, self._steps, -self._steps)
        # computed with the same accuracy as the shifted ones
        here = _left(self._beside(values, found))
        changes = [
            (_left(self._beside(values + move, found)) - here) / np.sum(move)
            for move in np.diag(moves)
        ]
        return np.column_stack(changes)

    def _beside(self, values: FloatArray, found: Sequence[_Nearest]) -> list[_Nearest]:
        """Return the values before each event for coefficients near those of `found`."""
        searches = [
            one.nearest([near.before], near.slope)
            for one, near in zip(self._events, found, strict=True)
        ]
        return self._together(values, searches)

    def _together(self, values: FloatArray, searches: Sequence[Asking]) -> list[_Nearest]:
        """Return the results of searches, one for each event, with their simulations combined."""
        physics = self._build(values)
        found: dict[int, _Nearest] = {}
        asked = {k: next(search) for k, search in enumerate(searches)}
        while asked:
            played = [
                (self._events[k].event, before)
                for k, befores in asked.items()
                for before in befores
            ]
            seen = iter(self._predict(physics, played))
            again = {}
            for k, befores in asked.items():
                try:
                    again[k] = searches[k].send([next(seen) for _ in befores])
                except StopIteration as end:
                    found[k] = end.value
            asked = again
        return [found[k] for k in range(len(searches))]


def _squares(numbers: FloatArray) -> float:
    return float(numbers @ numbers)


def _left(found: Sequence[_Nearest]) -> FloatArray:
    return np.concatenate([near.left for near in found])


def covariance_of(
    slopes: FloatArray, left: FloatArray, shots: Sequence[str], precisions: FloatArray | None = None
) -> FloatArray:
    """Return the covariance (p, p) of values, from the effect of each shot and of assumptions.

    Events of one shot share samples, and errors of the model. Shots are therefore left out
    one by one, to first order (the jackknife, CR3 of Bell and McCaffrey 2002); measurement errors
    give only the weights. An assumed value may be off by its stated spread, whatever the shots
    show. The variance of a value that no event determines is infinite.

    `slopes` (n, p), `left` (n,): for all seen values; `shots`: the shot of each.
    `precisions` (p,): inverse variance of each assumed value; 0 for other values.
    """
    count = slopes.shape[1]
    known = np.diag(np.zeros(count) if precisions is None else precisions)
    near = (np.abs(left) < HUBER).astype(float)
    bread = np.linalg.pinv((slopes.T * near) @ slopes + known, hermitian=True)
    moves = np.zeros((count, count))
    _, index = np.unique(np.array(shots), return_inverse=True)
    order = np.argsort(index, kind="stable")
    parts = np.split(order, np.flatnonzero(np.diff(index[order])) + 1)
    for part in parts:
        own, pull = slopes[part], np.clip(left[part], -HUBER, HUBER)
        leverage = (own * near[part, None]) @ bread @ own.T
        without = np.linalg.lstsq(np.eye(len(part)) - leverage, pull, rcond=None)[0]
        move = bread @ (own.T @ without)
        moves += np.outer(move, move)
    covariance = moves * (len(parts) - 1) / len(parts) + bread @ known @ bread
    untold = np.diag((slopes.T * near) @ slopes + known) == 0.0
    covariance[untold, untold] = np.inf
    return np.asarray(covariance)


def _huber(left: FloatArray) -> FloatArray:
    size = np.abs(left)
    return np.where(size < HUBER, size**2, 2.0 * HUBER * size - HUBER**2)
