"""Fit the physics of a real table, or an engine's settings for it, to tracks of its balls."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from scipy.special import stdtrit
from threadpoolctl import threadpool_limits

from ghostball.model import GhostballError, Physics
from ghostball.model.arrays import FloatArray
from ghostball.model.features import has_feature
from ghostball.model.impact_laws import CUSHION_LAWS, LawEntry
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.measured.fit.choices import (
    MOST_HEIGHTS,
    by_name,
    laws_alike,
    mean_of,
    moves_by_law,
    pairs_alike,
    solutions_around,
)
from ghostball.validation.measured.fit.clean_events import CleanEvents
from ghostball.validation.measured.fit.event_simulation import EventSimulator, Progress
from ghostball.validation.measured.fit.fields import (
    CUSHION,
    DEFAULT_FIELDS,
    FIELDS,
    INITIAL_VALUES,
    NEEDED_FEATURES,
    assumed_of,
    cushion_laws,
    determined_by,
    lacking,
    own_fields,
)
from ghostball.validation.measured.fit.fit_result import Assumptions, Fit
from ghostball.validation.measured.fit.least_squares import (
    Assumed,
    Field,
    FitProblem,
    Solution,
    goodness,
)
from ghostball.validation.measured.simulated_ball import Play

LEAST_EVENTS: Final = 8
"""Number of events below which a family isn't fitted."""
NORMAL_95: Final = 1.96
"""Standard errors that contain 95 % of normally distributed numbers."""


class NotEnoughError(GhostballError):
    """Tracks with too few clean events for the requested fit."""


def fit_table(
    found: CleanEvents,
    engine: ReferenceEngine,
    play: Play,
    *,
    preset: str = "pool",
    law: str | None = None,
    fields: Sequence[str] = (),
    nose_height: float | None = None,
    progress: Progress | None = None,
) -> Fit:
    """Return the physics with which an engine fits the events of tracks best.

    `play`: simulates a scene on the engine and records the motion.
    `preset`: gives the coefficients that aren't fitted.
    `law`: the cushion law; None: the engine's law with the best fit, or the preset's law if it
        can't be distinguished from the best.
    `fields`: the fitted coefficients; empty: all of `DEFAULT_FIELDS` that the events and the engine
        have.
    `nose_height` [m]: measured height of the cushion nose; None: that of the preset, with an
        uncertainty.

    Raises `NotEnoughError` if there are too few events for any fit, or for a requested field;
    `GhostballError` if the engine has no such law.
    """
    # The matrices are small: several threads would mostly wait for each other.
    with threadpool_limits(limits=1, user_api="blas"):
        return _Fitting(
            found, engine, play, preset, law, tuple(fields), nose_height, progress
        ).run()


class _Fitting:
    """One fit: the fixed values, the fitted values, and the fields with too few events.

    Families are fitted one after another. The results of one family, with their errors, are assumed
    in the fits of the next ones.
    """

    def __init__(
        self,
        found: CleanEvents,
        engine: ReferenceEngine,
        play: Play,
        preset: str,
        law: str | None,
        asked: tuple[str, ...],
        nose_height: float | None,
        progress: Progress | None,
    ) -> None:
        self._engine, self._player = engine, EventSimulator(engine, play, progress)
        self._asked, self._law = asked, law
        self._noise = found.noise
        self._families = {
            name: events for name, events in found.families.items() if len(events) >= LEAST_EVENTS
        }
        self._counts = {name: len(events) for name, events in found.families.items()}
        self._lacking = lacking(engine, preset)
        if nose_height is not None:
            self._lacking["cushion_height"] = nose_height
        self._measured = set() if nose_height is None else {"cushion_height"}
        self._base = Physics(preset=preset, **self._lacking)
        self._held = {} if law is None else {"cushion": law}
        self._not_told: dict[str, str] = {}
        self._assumed: Assumptions = {}  # including the results of earlier families
        self._values: dict[str, float] = {}
        self._solutions: dict[str, Solution] = {}
        self._errors: dict[str, float] = {}

    def run(self) -> Fit:
        """Perform the fit and return its result."""
        fields = self._determined(self._asked or DEFAULT_FIELDS)
        if not fields:
            raise NotEnoughError(f"not enough data for a fit: {self._too_few(frozenset(_NAMES))}")
        assumed = self._assumptions(fields)
        self._assumed = dict(assumed)
        self._values = self._begin(fields)
        own = {name: [one for one in fields if determined_by(one) == {name}] for name in _NAMES}
        laws = self._laws(own["cushion"])
        tries_frictions = bool(own["hit"]) and self._is_friction_open()
        steps = sum(map(bool, own.values())) + tries_frictions + len(laws)
        if "cushion_height" in assumed and any("cushion_height" in law.uses for law in laws):
            steps += MOST_HEIGHTS
        self._player.steps = steps
        if own["rolling"]:
            self._keep("rolling", own["rolling"], self._solve("rolling", own["rolling"]), {})
        if own["hit"]:
            self._keep("hit", own["hit"], *self._by_friction(own["hit"]))
        tried: dict[str, Solution] = {}
        alike: list[str] = []
        if own["cushion"]:
            tried = self._by_law(laws, own["cushion"])
            alike = laws_alike(tried)
            kept = self._base.cushion if self._base.cushion in alike else alike[0]
            moves = moves_by_law(laws, own["cushion"], tried, kept, alike)
            self._held = {"cushion": kept}
            own["cushion"] = own_fields(next(one for one in laws if one.name == kept), fields)
            best = tried[kept]
            if self._is_height_open():
                best = self._over_heights(own["cushion"], best)
            self._keep("cushion", own["cushion"], best, moves)
        return Fit(
            self._physics(self._values, self._held),
            self._errors,
            self._solutions,
            self._families,
            self._counts,
            self._noise,
            {name: goodness([one]) for name, one in tried.items()},
            alike,
            [pair for name, one in self._solutions.items() for pair in pairs_alike(own[name], one)],
            self._not_told,
            {
                name: known
                for name, known in assumed.items()
                if name in self._assumed and self._matters(FIELDS[name], set(own), self._held)
            },
            [one.name for ones in own.values() for one in ones if self._ends(one)],
        )

    def _keep(
        self, family: str, fields: Sequence[Field], solution: Solution, moves: Mapping[str, float]
    ) -> None:
        """Store the results of a family, for the final result and for the next families.

        `moves`: uncertainty of each value because of choices that the family doesn't determine.
        """
        self._solutions[family] = solution
        known = {k: one for k, one in solution.assumed.items() if k not in self._errors}
        self._values |= by_name(fields, solution) | known
        for one, error in zip(fields, solution.errors, strict=True):
            wide = float(error) * self._widened(one, fields)
            self._errors[one.name] = math.hypot(wide, moves.get(one.name, 0.0))
            self._assumed[one.name] = Assumed(self._values[one.name], self._errors[one.name])

    def _is_height_open(self) -> bool:
        """Return True if the height of the nose is assumed, and the law uses it."""
        one = FIELDS["cushion_height"]
        return one.name in self._assumed and self._matters(one, CUSHION, self._held)

    def _over_heights(self, fields: Sequence[Field], near: Solution) -> Solution:
        """Return the mean of fits with several heights of the nose, weighted by their misfit.

        If the height were a further fitted value, the best fit would often be where perpendicular
        contacts just stop slipping: the misfit rises steeply on one side and is nearly flat on the
        other. Errors computed near the best fit don't show this: values were wrong by 7 errors.
        """
        height = self._assumed.pop("cushion_height")

        def solve(spreads: int, last: Solution) -> Solution:
            height_there = height.mean + spreads * height.spread
            self._values |= {**by_name(fields, last), "cushion_height": height_there}
            return self._solve("cushion", fields, last.befores)

        first = round((near.assumed["cushion_height"] - height.mean) / height.spread)
        tried = solutions_around(first, near, solve)
        self._assumed["cushion_height"] = height
        mean, there, best = mean_of(tried)
        found = height.mean + there * height.spread
        return replace(mean, assumed={**tried[best].assumed, "cushion_height": found})

    def _is_friction_open(self) -> bool:
        """Return True if the hits must decide between two kinds of friction between balls."""
        return "ball_friction" in self._assumed and isinstance(self._base.ball_friction, str)

    def _by_friction(self, fields: Sequence[Field]) -> tuple[Solution, dict[str, float]]:
        """Fit the hits, and choose the law of friction between balls.

        A preset may have a friction that decreases with the slip speed. The hits then decide
        between this law and an assumed constant. If they can't, the constant is used, and the
        change of each value under the preset's law is added to its error.
        """
        constant = self._solve("hit", fields)
        if not self._is_friction_open():
            return constant, {}
        assumed = self._assumed.pop("ball_friction")
        falling = self._solve("hit", fields)
        alike = laws_alike({"constant": constant, "falling": falling})
        if alike == ["falling"]:
            return falling, {}
        self._assumed["ball_friction"] = assumed
        if alike == ["constant"]:
            return constant, {}
        moved = np.abs(falling.values - constant.values)
        return constant, dict(zip([one.name for one in fields], map(float, moved), strict=True))

    def _by_law(self, laws: Sequence[LawEntry], fields: Sequence[Field]) -> dict[str, Solution]:
        """Return the fit of the contacts for each cushion law."""
        tried = {}
        for law in laws:
            self._held = {"cushion": law.name}
            tried[law.name] = self._solve("cushion", own_fields(law, fields))
        return tried

    def _assumptions(self, fields: Sequence[Field]) -> Assumptions:
        """Return assumptions for the fields that aren't fitted but affect some events.

        Contacts with cushions depend on the friction of the cloth and on the height of the nose,
        hits on the friction between balls. A wrong assumption changes the fitted values, by more
        than the scatter of shots shows.
        """
        fitted = {one.name for one in fields} | self._measured
        radius = next(event.radius for events in self._families.values() for event in events)
        return {
            one.name: known
            for one in FIELDS.values()
            if one.name not in fitted
            and one.felt_by & set(self._families)
            and (known := assumed_of(one.name, self._base, radius)) is not None
        }

    def _ends(self, one: Field) -> bool:
        """Return True if the fitted value of a field is a limit of its range."""
        value = self._values[one.name]
        return min(value - one.low, one.high - value) < one.step / 2.0

    def _widened(self, field: Field, fields: Sequence[Field]) -> float:
        """Return the factor by which the error of a field is widened if there are few shots.

        Then 95 % of true values are within 1.96 stated errors, as with many shots (Student 1908).
        """
        (family,) = determined_by(field)
        shots = {event.shot for event in self._families[family]}
        beside = sum(determined_by(one) == {family} for one in fields)
        return float(stdtrit(max(len(shots) - beside, 1), 0.975)) / NORMAL_95

    def _determined(self, names: Sequence[str]) -> list[Field]:
        """Return the fields that the events determine and the engine supports."""
        told = []
        for name in names:
            one = FIELDS[name]
            why = ""
            if not determined_by(one) <= set(self._families):
                why = self._too_few(determined_by(one))
            elif name in NEEDED_FEATURES and not has_feature(
                self._engine.capabilities, NEEDED_FEATURES[name]
            ):
                why = f"{self._engine.name} doesn't support {NEEDED_FEATURES[name].value}"
            elif determined_by(one) == CUSHION and not cushion_laws(self._engine):
                why = f"{self._engine.name} has no cushion law that can be fitted"
            if why and self._asked:
                raise NotEnoughError(f"can't fit `{name}`: {why}")
            if why:
                self._not_told[name] = why
            else:
                told.append(one)
        return told

    def _too_few(self, families: frozenset[str]) -> str:
        parts = [f"{self._counts[name]} {_NAMES[name]}" for name in _NAMES if name in families]
        return f"{', '.join(parts)} are clean; at least {LEAST_EVENTS} of a kind are needed"

    def _laws(self, fields: Sequence[Field]) -> list[LawEntry]:
        """Return the cushion laws to test; empty if none of their fields is fitted."""
        own = {one.name for one in fields}
        if not own:
            return []
        wanted = own & set(self._asked)
        laws = [
            law
            for law in cushion_laws(self._engine)
            if self._law in (None, law.name) and wanted <= {*law.uses}
        ]
        if not laws:
            asked = f'no law "{self._law}"' if self._law else "no cushion law"
            uses = f" that uses {', '.join(sorted(wanted))}" if wanted else ""
            raise GhostballError(f"{self._engine.name} has {asked}{uses}")
        return laws

    def _begin(self, fields: Sequence[Field]) -> dict[str, float]:
        """Return the initial values of the search."""
        values = {}
        for one in fields:
            value = INITIAL_VALUES.get(one.name, getattr(self._base, one.name))
            values[one.name] = float(min(max(value, one.low), one.high))
        return values

    def _solve(
        self, family: str, fields: Sequence[Field], befores: Sequence[FloatArray] | None = None
    ) -> Solution:
        """Return the best values of some fields for a family; other fields keep their values."""
        self._player.begin(family)
        fitted = {one.name for one in fields}
        beside = [
            FIELDS[name]
            for name, known in self._assumed.items()
            if name not in fitted
            and self._matters(FIELDS[name], {family}, self._held)
            and known.spread > _EXACT_SPREAD * FIELDS[name].step
        ]
        names = [one.name for one in (*fields, *beside)]

        def build(numbers: FloatArray) -> Physics:
            values = {**self._values, **dict(zip(names, numbers, strict=True))}
            return self._physics(values, self._held)

        events = self._families[family]
        problem = FitProblem(events, [*fields, *beside], build, self._player.predict, self._assumed)
        begin = {name: one.mean for name, one in self._assumed.items()} | self._values
        found = problem.solve(np.array([begin[name] for name in names]), befores)
        count = len(fields)  # assumed fields have already widened the errors of these
        return replace(
            found,
            values=found.values[:count],
            covariance=found.covariance[:count, :count],
            assumed=dict(zip(names[count:], map(float, found.values[count:]), strict=True)),
        )

    def _matters(self, one: Field, families: Collection[str], held: Mapping[str, Any]) -> bool:
        """Return True if a field affects events of some families with the chosen cushion law."""
        felt = one.felt_by & set(families) & set(self._families)
        return bool(felt) and (one.felt_by != CUSHION or one.name in self._uses(held))

    def _uses(self, held: Mapping[str, Any]) -> Collection[str]:
        """Return the fields that the cushion law uses."""
        law = held.get("cushion", self._base.cushion)
        return next(one.uses for one in CUSHION_LAWS if one.name == law)

    def _physics(self, values: Mapping[str, float], held: Mapping[str, Any]) -> Physics:
        uses = self._uses(held)
        mine = {
            name: float(value)
            for name, value in values.items()
            if FIELDS[name].felt_by != CUSHION or name in uses
        }
        return Physics(preset=self._base.preset, **{**self._lacking, **held, **mine})


_NAMES = {
    "rolling": "stretches of rolling",
    "cushion": "contacts with cushions",
    "hit": "hits of a ball at rest",
}
_EXACT_SPREAD = 1.5
"""Largest spread of an earlier result that is treated as exact, in difference steps."""
