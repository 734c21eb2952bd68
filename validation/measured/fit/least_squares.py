"""Fields of physics fitted to events whose own measurements have errors, too.

A model goes from what was measured before an event, z, to what was seen after it, y. Both have
errors, so the best z is sought with the fields: near a first guess the model is linear in it,
f(z') = f(z) + J (z' - z), and what is left, y - f(z) - J (z_measured - z), has the covariance
Y + J Z J'. This is orthogonal distance regression (Boggs, Byrd and Schnabel 1987), event by event.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import least_squares

from ghostball.model import Physics
from ghostball.model.arrays import FloatArray
from ghostball.validation.measured.fit.events import Event

Predict = Callable[[Physics, Event, FloatArray], FloatArray]
"""What a model makes of an event begun as given: what would be seen of it."""

Known = Mapping[str, Sequence[FloatArray]]

HUBER = 2.5
"""Errors from which on a residual counts by its size, no longer by its square (Huber 1964)."""
_PASSES = 8
_GUESSING = 2
"""Passes before which what was before an event is guessed anew."""
_REACH = 40.0
"""Steps of differences by which a value may move in a pass: farther, no model is linear."""
_SETTLED = 0.05
"""Part of its standard error by which a value may still move when a fit counts as done."""


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
    residuals: Mapping[str, FloatArray]
    """By family, for each event (n, k): what is left of each number, in errors of measurement."""
    known: Known
    """By family, what was before each event, where it and what was seen agree best."""
    free: int
    """Numbers that were seen, but for one of each event that tells a side that was not."""
    assumed: Mapping[str, float] = field(default_factory=dict)
    """Values found for fields of which something was assumed, and that aren't among `values`."""

    @property
    def misfits(self) -> FloatArray:
        """The misfit of each event (n,): the squares of what is left, large ones taken for less."""
        every = [np.sum(_huber(left), axis=1) for left in self.residuals.values()]
        return np.concatenate([np.empty(0), *every])

    @property
    def goodness(self) -> float:
        """The misfit for each number that was seen more than fitted: 1 where only noise is left."""
        return float(np.sum(self.misfits)) / max(self.free - len(self.values), 1)

    @property
    def errors(self) -> FloatArray:
        """The standard errors of the values, (p,)."""
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True)
class _Linear:
    """An event near a guess of the fields and of what was before it."""

    event: Event
    at: FloatArray  # values of the fields (p,)
    before: FloatArray  # z (m,)
    predicted: FloatArray  # f (k,)
    slope: FloatArray  # J (k, m)
    fields: FloatArray  # derivatives by the fields (k, p)
    whitening: FloatArray  # lower L with L L' = Y + J Z J'

    @property
    def left(self) -> FloatArray:
        """What is left of the prediction, in errors of measurement (k,)."""
        shift = self.slope @ (self.event.given - self.before)
        return self.whiten(self.event.seen - self.predicted - shift)

    @property
    def slopes(self) -> FloatArray:
        """The derivatives of what is left by the fields (k, p)."""
        return -self.whiten(self.fields)

    def left_at(self, values: FloatArray) -> FloatArray:
        """Return what is left where the fields have other values (k,)."""
        return self.left + self.slopes @ (values - self.at)

    def whiten(self, numbers: FloatArray) -> FloatArray:
        """Return numbers (k,) or (k, p) as independent ones of variance 1."""
        return np.asarray(solve_triangular(self.whitening, numbers, lower=True))

    def improved(self, left: FloatArray) -> FloatArray:
        """Return the z that fits best, where so much is left."""
        whitened = solve_triangular(self.whitening, left, lower=True, trans="T")
        step = self.event.given_covariance @ self.slope.T @ whitened
        return np.asarray(self.event.given + step)


class Problem:
    """What is fitted to what.

    `families` of events; `fields` of the physics that `build` makes of their values; `predict`,
    which plays a model; `assumed`, by field, what is assumed of its value beside the events.
    """

    def __init__(
        self,
        families: Mapping[str, Sequence[Event]],
        fields: Sequence[Field],
        build: Callable[[FloatArray], Physics],
        predict: Predict,
        assumed: Mapping[str, Assumed] | None = None,
    ) -> None:
        self._families, self._fields = families, fields
        self._build, self._predict = build, predict
        self._low = np.array([one.low for one in fields])
        self._high = np.array([one.high for one in fields])
        known = [(assumed or {}).get(one.name) for one in fields]
        self._means = np.array([0.0 if one is None else one.mean for one in known])
        self._precisions = np.array([0.0 if one is None else one.spread**-2 for one in known])

    def solve(self, start: FloatArray, known: Known | None = None) -> Solution:
        """Return the values that fit best, sought from some on.

        `known`: of families that were fitted before, what was before each event.
        """
        values, told = start, set(known or ())
        befores: Known = known or {}
        linear: dict[str, list[_Linear]] = {}
        moving = set(self._families)
        for k in range(_PASSES):
            if k < _GUESSING:
                physics = self._build(values)
                befores = {
                    name: befores[name]
                    if name in told
                    else self._nearest(physics, name, befores.get(name))
                    for name in self._families
                }
            linear |= {name: self._linear(name, values, befores[name]) for name in sorted(moving)}
            solution = self._best(values, linear)
            moved = np.abs(solution.values - values) > _SETTLED * solution.errors
            values = solution.values
            befores = solution.known if k < _GUESSING else _halfway(befores, solution.known)
            if k >= _GUESSING - 1:
                # One whose fields stay is still as linear as it was.
                moving = {name for name in self._families if self._feels(name, moved.tolist())}
            if k and not np.any(moved):
                break
        return solution

    def _feels(self, name: str, moved: Sequence[bool]) -> bool:
        """Whether one of the fields that moved is felt by a family."""
        return any(
            one and name in field.felt_by for one, field in zip(moved, self._fields, strict=True)
        )

    def _nearest(
        self, physics: Physics, name: str, known: Sequence[FloatArray] | None
    ) -> list[FloatArray]:
        """Return what was before each event of a family: the best of what is known, and of guesses.

        Where a contact slips, a model has several sides that fit nearly as well.
        """
        nearest = []
        for k, event in enumerate(self._families[name]):
            guesses = event.guesses if known is None else [known[k], *event.guesses]
            off = partial(self._off, physics, event)
            nearest.append(guesses[0] if not event.hides_side else min(guesses, key=off))
        return nearest

    def _off(self, physics: Physics, event: Event, before: FloatArray) -> float:
        """Return the squares of errors by which an event is off that began so."""
        left, step = event.seen - self._predict(physics, event, before), event.given - before
        seen = np.linalg.solve(event.seen_covariance, left)
        given = np.linalg.solve(event.given_covariance, step)
        return float(left @ seen + step @ given)

    def _linear(
        self, name: str, values: FloatArray, befores: Sequence[FloatArray]
    ) -> list[_Linear]:
        """Return the events of a family near values of the fields, and what was before them."""
        steps = [
            one.step if value + one.step <= one.high else -one.step
            for one, value in zip(self._fields, values, strict=True)
        ]
        here = self._build(values)
        shifted = [
            self._build(values + step) if name in one.felt_by else None
            for one, step in zip(self._fields, np.diag(steps), strict=True)
        ]
        return [
            self._linear_near(event, before, values, here, shifted, steps)
            for event, before in zip(self._families[name], befores, strict=True)
        ]

    def _linear_near(
        self,
        event: Event,
        before: FloatArray,
        values: FloatArray,
        here: Physics,
        shifted: Sequence[Physics | None],
        steps: Sequence[float],
    ) -> _Linear:
        predicted = self._predict(here, event, before)
        slope = np.column_stack(
            [
                (self._predict(here, event, before + step) - predicted) / np.sum(step)
                for step in np.diag(event.steps)
            ]
        )
        fields = np.zeros((len(predicted), len(steps)))
        for k, (physics, step) in enumerate(zip(shifted, steps, strict=True)):
            if physics is not None:
                fields[:, k] = (self._predict(physics, event, before) - predicted) / step
        covariance = event.seen_covariance + slope @ event.given_covariance @ slope.T
        whitening = np.asarray(cholesky(covariance, lower=True))
        return _Linear(event, values, before, predicted, slope, fields, whitening)

    def _best(self, values: FloatArray, linear: Mapping[str, list[_Linear]]) -> Solution:
        """Return the values that fit best where all is linear near some values."""
        every = [one for ones in linear.values() for one in ones]
        left = np.concatenate([one.left_at(values) for one in every])
        slopes = np.vstack([one.slopes for one in every])
        best = values
        # What is assumed counts like measurements of the fields themselves.
        weights = np.sqrt(self._precisions)
        stated = np.concatenate([left, weights * (values - self._means)])
        all_slopes = np.vstack([slopes, np.diag(weights)])
        if len(values):
            reach = _REACH * np.array([one.step for one in self._fields])
            best = least_squares(
                lambda numbers: stated + all_slopes @ (numbers - values),
                values,
                lambda _: all_slopes,
                bounds=(
                    np.maximum(self._low, values - reach),
                    np.minimum(self._high, values + reach),
                ),
                x_scale=[one.step for one in self._fields],
                loss="huber",
                f_scale=HUBER,
            ).x
        move = best - values
        shots = [one.event.shot for one in every for _ in one.predicted]
        residuals = {
            name: np.array([one.left_at(best) for one in ones]) for name, ones in linear.items()
        }
        return Solution(
            np.asarray(best),
            covariance_of(slopes, left + slopes @ move, shots, self._precisions),
            residuals,
            {
                name: [one.improved(each) for one, each in zip(ones, residuals[name], strict=True)]
                for name, ones in linear.items()
            },
            sum(len(one.predicted) - one.event.hides_side for one in every),
        )


def _halfway(old: Known, new: Known) -> Known:
    """Return what is between two guesses: where a model bends, whole steps go to and fro."""
    return {
        name: [(one + other) / 2.0 for one, other in zip(old[name], new[name], strict=True)]
        for name in new
    }


def covariance_of(
    slopes: FloatArray,
    left: FloatArray,
    shots: Sequence[str],
    precisions: FloatArray | None = None,
) -> FloatArray:
    """Return the covariance (p, p) of values: how far each shot, and what is assumed, moves them.

    Events of one shot share samples, and what a model lacks of a real table. So shots are left out
    one by one, to first order (the jackknife, CR3 of Bell and McCaffrey 2002); from the errors of
    measurement come the weights alone. A value that is assumed may be off by its stated spread,
    whatever the shots say.

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
    return moves * (len(parts) - 1) / len(parts) + bread @ known @ bread


def _huber(left: FloatArray) -> FloatArray:
    size = np.abs(left)
    return np.where(size < HUBER, size**2, 2.0 * HUBER * size - HUBER**2)
