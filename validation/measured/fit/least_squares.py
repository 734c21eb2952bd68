"""Fields of physics fitted to events whose own measurements have errors, too.

A model goes from what was measured before an event, z, to what was seen after it, y. Both have
errors. So for some physics the nearest z of each event is sought: that which leaves the least
squares of y and of the measured z, in errors of measurement. What it leaves is a function of the
fields alone, and SciPy's `least_squares` makes that small. This is orthogonal distance regression
(Boggs, Byrd and Schnabel 1987), event by event.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import least_squares

from ghostball.model import Physics
from ghostball.model.arrays import FloatArray
from ghostball.validation.measured.fit.events import Event
from ghostball.validation.measured.fit.playing import Played

Predict = Callable[[Physics, Sequence[Played]], Sequence[FloatArray]]
"""What a model makes of events begun as given: what would be seen of each."""

HUBER = 2.5
"""Errors from which on a residual counts by its size, no longer by its square (Huber 1964)."""
_TRIALS = 30
"""Steps of a search."""
_HALVINGS = 6
_CLOSE = 0.02
"""What an event may be off its derivatives, in errors, where it counts as linear."""
_SETTLED = 0.05
"""Part of its standard error by which a value may still move when it counts as found."""
_REACH = 40.0
"""Steps of differences by which a value may move in a step: farther, no model is linear."""


@dataclass(frozen=True)
class Field:
    """A number of the physics that can be fitted."""

    name: str
    low: float
    high: float
    step: float  # of differences
    felt_by: frozenset[str]  # families of events


@dataclass(frozen=True)
class Assumed:
    """What is assumed of a field's value before the fit: its mean and its standard deviation."""

    mean: float
    spread: float


@dataclass(frozen=True)
class Solution:
    """Fitted values (p,), their covariance (p, p), and what is left of the events."""

    values: FloatArray
    covariance: FloatArray
    residuals: FloatArray
    """What is left of each event's numbers, in errors of measurement (n, k)."""
    befores: Sequence[FloatArray]
    """What was before each event, where it and what was seen agree best."""
    free: int
    """Numbers that were seen, but for one of each event that tells a side that was not."""
    misfit: float
    """What the search made small: the misfit of all events and of what is assumed."""
    settled: bool
    """Whether the search ended where no other values are better."""
    assumed: Mapping[str, float] = field(default_factory=dict)
    """Values found for fields of which something was assumed, and that aren't among `values`."""

    @property
    def misfits(self) -> FloatArray:
        """The misfit of each event (n,): the squares of what is left, large ones taken for less."""
        return np.asarray(np.sum(_huber(self.residuals), axis=1))

    @property
    def errors(self) -> FloatArray:
        """The standard errors of the values, (p,)."""
        return np.sqrt(np.diag(self.covariance))


def goodness(solutions: Sequence[Solution]) -> float:
    """Return the misfit for each number seen more than fitted: 1 where only noise is left."""
    spare = sum(one.free - len(one.values) for one in solutions)
    return float(sum(np.sum(one.misfits) for one in solutions)) / max(spare, 1)


@dataclass(frozen=True)
class _Nearest:
    """What was before an event, z (m,), where it and what was seen agree best.

    `left` (k + m,): what is left of the numbers seen and of those measured before, in errors;
    `slope` (k + m, m): its derivatives by z.
    """

    before: FloatArray
    left: FloatArray
    slope: FloatArray


Asking = Generator[Sequence[FloatArray], Sequence[FloatArray], _Nearest]
"""A search that asks what would be seen of an event begun in several ways, and returns the best."""


class _Weighed:
    """An event, and what makes its errors of measurement independent and of variance 1."""

    def __init__(self, event: Event) -> None:
        self.event = event
        self._seen = np.linalg.inv(np.linalg.cholesky(event.seen_covariance))
        self._given = np.linalg.inv(np.linalg.cholesky(event.given_covariance))

    def nearest(self, starts: Sequence[FloatArray], known: FloatArray | None = None) -> Asking:
        """Search what was before the event by the Gauss-Newton method, from the best start on.

        `known`: the derivatives at the only start, if they are.
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
            if _squares(change) < _CLOSE**2:
                return _Nearest(before + step, left + change, slope)
            for _ in range(_HALVINGS):
                (tried,) = yield from self._ask([before + step])
                if _squares(tried - left - change) < _CLOSE**2:
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
        """Return what is left where the event began so, each (k + m,)."""
        seen = yield befores
        return [
            np.concatenate(
                [self._seen @ (self.event.seen - one), self._given @ (self.event.given - before)]
            )
            for one, before in zip(seen, befores, strict=True)
        ]

    def seen_left(self, near: _Nearest) -> FloatArray:
        """Return what is left of the numbers seen alone (k,), in errors on both sides."""
        count = len(self._seen)
        pull = near.slope[:count] @ np.linalg.inv(near.slope[count:])
        spread = np.linalg.cholesky(np.eye(count) + pull @ pull.T)
        return np.asarray(np.linalg.solve(spread, near.left[:count] - pull @ near.left[count:]))


class Problem:
    """What is fitted to what.

    `events` of one family; `fields` of the physics that `build` makes of their values; `predict`,
    which plays a model; `assumed`, by field, what is assumed of its value beside the events.
    """

    def __init__(
        self,
        events: Sequence[Event],
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
        """Return the values that fit best, sought from some on.

        `befores`: what was before each event, if the events were fitted before.
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
        """Return better values, what was before each event then, and whether these are settled.

        Those that fit best if all is linear; where it isn't, so little of the way there that the
        misfit falls. The same values if the whole way is hardly a step: they are settled. The same
        values, not settled, if the misfit falls nowhere on the way.
        """
        weights = np.sqrt(self._precisions)
        left = np.concatenate([_left(found), weights * (values - self._means)])
        every = np.vstack([slopes, np.diag(weights)])
        told = np.linalg.pinv(every.T @ every, hermitian=True)
        errors = np.sqrt(np.maximum(np.diag(told), 0.0))
        reach = _REACH * self._steps
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
        close = _SETTLED * errors
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
        """Return the misfit of all events, and of what is assumed."""
        assumed = np.sqrt(self._precisions) * (values - self._means)
        return float(np.sum(_huber(np.concatenate([_left(found), assumed]))))

    def _slopes(self, values: FloatArray, found: Sequence[_Nearest]) -> FloatArray:
        """Return the derivatives of what is left by the fields."""
        room = values + self._steps <= self._high
        moves = np.where(room, self._steps, -self._steps)
        here = _left(self._beside(values, found))  # as near to the nearest as those beside it
        changes = [
            (_left(self._beside(values + move, found)) - here) / np.sum(move)
            for move in np.diag(moves)
        ]
        return np.column_stack(changes)

    def _beside(self, values: FloatArray, found: Sequence[_Nearest]) -> list[_Nearest]:
        """Return what was before each event where the fields have values near those of `found`."""
        searches = [
            one.nearest([near.before], near.slope)
            for one, near in zip(self._events, found, strict=True)
        ]
        return self._together(values, searches)

    def _together(self, values: FloatArray, searches: Sequence[Asking]) -> list[_Nearest]:
        """Return what searches find, one for each event. What they ask is played together."""
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
    """Return the covariance (p, p) of values: how far each shot, and what is assumed, moves them.

    Events of one shot share samples, and what a model lacks of a real table. So shots are left out
    one by one, to first order (the jackknife, CR3 of Bell and McCaffrey 2002); from the errors of
    measurement come the weights alone. A value that is assumed may be off by its stated spread,
    whatever the shots say. The variance of a value that nothing tells is infinite.

    `slopes` (n, p), `left` (n,): of all numbers that were seen; `shots`: the shot of each.
    `precisions` (p,): one over the variance of each value that is assumed, 0 for the others.
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
