"""Physics of a real table, or an engine's settings for it, from tracks of its balls."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any, Final

import numpy as np
from scipy.special import stdtrit
from threadpoolctl import threadpool_limits

from ghostball.model import GhostballError, Physics
from ghostball.model.arrays import FloatArray
from ghostball.model.features import has_feature
from ghostball.model.impact_laws import CUSHION_LAWS, LawEntry
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.measured.fit.events import Event
from ghostball.validation.measured.fit.fields import (
    ALL,
    BEGIN,
    CUSHION,
    DEFAULT_FIELDS,
    FIELDS,
    NEEDS,
    assumed_of,
    cushion_laws,
    lacking,
    own_fields,
    told_by,
)
from ghostball.validation.measured.fit.harvest import Harvest
from ghostball.validation.measured.fit.least_squares import (
    Assumed,
    Field,
    Problem,
    Solution,
)
from ghostball.validation.measured.play import Play

LEAST_EVENTS: Final = 8
"""Events of a family below which it tells nothing."""
NORMAL: Final = 1.96
"""Standard errors within which 95 of 100 normal numbers are."""
ALIKE: Final = 0.95
"""Correlation from which on two values aren't told apart: one makes up for the other."""


class NotEnoughError(GhostballError):
    """Tracks that have too few clean events to tell what is asked of them."""


Assumptions = dict[str, Assumed]
"""What is assumed of fields that aren't fitted, by their names."""

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Fit:
    """What was found: the physics, and how sure each fitted value of it is."""

    physics: Physics
    errors: dict[str, float]
    """The standard error of each fitted field."""
    solution: Solution
    families: dict[str, Sequence[Event]]
    """The events that were fitted, by what they are."""
    counts: dict[str, int]
    """How many clean events there were of each family, those too few for a fit as well."""
    noise: float  # of the tracks, of a coordinate of a sample [m]
    laws: dict[str, float]
    """The goodness of each law of cushions that was tried; none where cushions aren't fitted."""
    laws_alike: list[str]
    """Those of them that the tracks don't tell from the best, with it."""
    not_told_apart: list[tuple[str, str]]
    not_told: dict[str, str]
    """Fields that the tracks tell nothing about, and why."""
    assumed: Assumptions
    """Fields that affect the events but aren't fitted. The errors allow for their spread."""
    ends: list[str]
    """Fields whose best value is the end of what is allowed."""


def fit_table(
    found: Harvest,
    engine: ReferenceEngine,
    play: Play,
    *,
    preset: str = "pool",
    law: str | None = None,
    fields: Sequence[str] = (),
    nose_height: float | None = None,
    progress: Progress | None = None,
) -> Fit:
    """Return the physics with which an engine comes nearest to the events of tracks.

    `play` plays a scene on it, and records the motion. `preset` gives what isn't fitted. `law` is
    that of cushions; None: of those that the engine has, the one that fits best, or the preset's
    where the contacts don't tell it from that. `fields` are fitted; none: all of `DEFAULT_FIELDS`
    that the events and the engine have. `nose_height` [m] is that of the cushions, measured; None:
    the preset's, and the errors allow for what it may be.

    Raises `NotEnoughError` where there are too few events for anything, or for a field that was
    asked for; `GhostballError` where the engine has no such law.
    """
    # The matrices are small. Threads for them only wait for each other, beside another program for
    # far longer than they work.
    with threadpool_limits(limits=1, user_api="blas"):
        return _Fitting(
            found, engine, play, preset, law, tuple(fields), nose_height, progress
        ).run()


class _Fitting:
    """One fit: what is held, what is asked of the tracks, and what they are too few for."""

    def __init__(
        self,
        found: Harvest,
        engine: ReferenceEngine,
        play: Play,
        preset: str,
        law: str | None,
        asked: tuple[str, ...],
        nose_height: float | None,
        progress: Progress | None,
    ) -> None:
        self._engine, self._play, self._progress = engine, play, progress
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
        self._not_told: dict[str, str] = {}
        self._known: dict[str, Sequence[FloatArray]] = {}
        self._played = 0
        self._step = ""
        self._steps_done = 0
        self._steps = 1

    def run(self) -> Fit:
        """Fit, and say what came of it."""
        fields = self._told(self._asked or DEFAULT_FIELDS)
        if not fields:
            raise NotEnoughError(f"not enough to tell anything: {self._too_few(ALL)}")
        assumed = self._assumptions(fields)
        laws = self._laws(fields)
        self._steps = len(laws) + 2 if laws else 1
        values = self._begin(fields)
        others = [one for one in fields if told_by(one) != CUSHION]
        by_friction: dict[str, float] = {}
        if others and (laws or self._is_friction_open(assumed)):
            first, by_friction, assumed = self._by_friction(others, values, assumed)
            values |= _by_name(others, first)
            self._known |= first.known
        if not laws:
            held = {} if self._law is None else {"cushion": self._law}
            solution = self._solve("all", fields, values, held, ALL, assumed)
            return self._fit_of(fields, solution, held, assumed, {}, [], by_friction)
        solutions = self._by_law(laws, fields, values, assumed)
        alike = _laws_alike(solutions)
        chosen = self._base.cushion if self._base.cushion in alike else alike[0]
        own = own_fields(next(law for law in laws if law.name == chosen), fields)
        values |= _by_name(own, solutions[chosen])
        self._known |= solutions[chosen].known
        held = {"cushion": chosen}
        fields = [*others, *own]
        tried = {name: one.goodness for name, one in solutions.items()}
        moves = by_friction | _moves_by_law(laws, fields, solutions, chosen, alike)
        solution = self._solve("all", fields, values, held, ALL, assumed)
        return self._fit_of(fields, solution, held, assumed, tried, alike, moves)

    def _is_friction_open(self, assumed: Assumptions) -> bool:
        """Return True if the hits must decide between two kinds of friction between balls."""
        return "ball_friction" in assumed and isinstance(self._base.ball_friction, str)

    def _by_friction(
        self, fields: Sequence[Field], values: dict[str, float], assumed: Assumptions
    ) -> tuple[Solution, dict[str, float], Assumptions]:
        """Fit the cloth and the balls, and choose the friction between balls.

        A preset may have a friction between balls that falls with the speed of slip. Then the hits
        decide between it and an assumed constant one.

        Returns the fit; how far the preset's friction would move each value, if the hits don't
        decide; and what is assumed from now on.
        """
        step, families = "cloth and balls", ALL - CUSHION
        constant = self._solve(step, fields, values, {}, families, assumed)
        if not self._is_friction_open(assumed):
            return constant, {}, assumed
        others = {name: one for name, one in assumed.items() if name != "ball_friction"}
        falling = self._solve(step, fields, values, {}, families, others)
        alike = _laws_alike({"constant": constant, "falling": falling})
        if alike == ["falling"]:
            return falling, {}, others
        if alike == ["constant"]:
            return constant, {}, assumed
        moved = np.abs(falling.values - constant.values)
        names = [one.name for one in fields]
        return constant, dict(zip(names, map(float, moved), strict=True)), assumed

    def _by_law(
        self,
        laws: Sequence[LawEntry],
        fields: Sequence[Field],
        values: dict[str, float],
        assumed: Assumptions,
    ) -> dict[str, Solution]:
        """Return what each law of cushions makes of the contacts."""
        solutions = {}
        for done, law in enumerate(laws, start=1):
            self._steps_done = done
            held, own = {"cushion": law.name}, own_fields(law, fields)
            solutions[law.name] = self._solve(law.name, own, values, held, CUSHION, assumed)
        self._steps_done = len(laws) + 1
        return solutions

    def _assumptions(self, fields: Sequence[Field]) -> Assumptions:
        """Return what is assumed of each field that isn't fitted and that some events feel.

        Contacts with cushions feel the friction of the cloth and the height of the nose, hits that
        of the balls. An assumption that is off moves what is fitted, by more than the shots show.
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

    def _fit_of(
        self,
        fields: list[Field],
        solution: Solution,
        held: dict[str, Any],
        assumed: Assumptions,
        laws: dict[str, float],
        laws_alike: list[str],
        moves: dict[str, float],
    ) -> Fit:
        errors = {
            one.name: math.hypot(
                float(error) * self._widened(one, fields), moves.get(one.name, 0.0)
            )
            for one, error in zip(fields, solution.errors, strict=True)
        }
        scale = np.where(solution.errors > 0.0, solution.errors, 1.0)
        correlation = solution.covariance / np.outer(scale, scale)
        alike = [
            (fields[i].name, fields[j].name)
            for i, j in combinations(range(len(fields)), 2)
            if abs(correlation[i, j]) >= ALIKE
        ]
        ends = [
            one.name
            for one, value in zip(fields, solution.values, strict=True)
            if min(value - one.low, one.high - value) < one.step / 2.0
        ]
        return Fit(
            self._physics({**solution.assumed, **_by_name(fields, solution)}, held),
            errors,
            solution,
            self._families,
            self._counts,
            self._noise,
            laws,
            laws_alike,
            alike,
            self._not_told,
            {one.name: assumed[one.name] for one in self._assumed_in(assumed, ALL, held)},
            ends,
        )

    def _widened(self, field: Field, fields: Sequence[Field]) -> float:
        """Return by how much the error of a field is widened, since few shots tell it.

        So 95 of 100 true values lie within 1.96 stated errors, as with many (Student 1908).
        """
        (family,) = told_by(field)
        shots = {event.shot for event in self._families[family]}
        beside = sum(told_by(one) == {family} for one in fields)
        return float(stdtrit(max(len(shots) - beside, 1), 0.975)) / NORMAL

    def _told(self, names: Sequence[str]) -> list[Field]:
        """Return the fields that the events and the engine have something to say of."""
        told = []
        for name in names:
            one = FIELDS[name]
            why = ""
            if not told_by(one) <= set(self._families):
                why = self._too_few(told_by(one))
            elif name in NEEDS and not has_feature(self._engine.capabilities, NEEDS[name]):
                why = f"{self._engine.name} has no {NEEDS[name].value}"
            elif told_by(one) == CUSHION and not cushion_laws(self._engine):
                why = f"{self._engine.name} has no law of cushions that can be fitted"
            if why and self._asked:
                raise NotEnoughError(f"not enough to tell `{name}`: {why}")
            if why:
                self._not_told[name] = why
            else:
                told.append(one)
        return told

    def _too_few(self, families: frozenset[str]) -> str:
        parts = [f"{self._counts[name]} {_NAMES[name]}" for name in _NAMES if name in families]
        return f"{', '.join(parts)} were found clean, {LEAST_EVENTS} of a kind are needed"

    def _laws(self, fields: Sequence[Field]) -> list[LawEntry]:
        """Return the laws of cushions to try: none where no field of theirs is fitted."""
        own = {one.name for one in fields if one.felt_by == CUSHION}
        if not own:
            return []
        wanted = own & set(self._asked)
        laws = [
            law
            for law in cushion_laws(self._engine)
            if self._law in (None, law.name) and wanted <= {*law.uses}
        ]
        if not laws:
            asked = f'no law "{self._law}"' if self._law else "no law of cushions"
            uses = f" that uses {', '.join(sorted(wanted))}" if wanted else ""
            raise GhostballError(f"{self._engine.name} has {asked}{uses}")
        return laws

    def _begin(self, fields: Sequence[Field]) -> dict[str, float]:
        """Return where the search begins."""
        values = {}
        for one in fields:
            value = BEGIN.get(one.name, getattr(self._base, one.name))
            values[one.name] = float(min(max(value, one.low), one.high))
        return values

    def _solve(
        self,
        step: str,
        fields: Sequence[Field],
        values: dict[str, float],
        held: dict[str, Any],
        families: frozenset[str],
        assumed: Assumptions,
    ) -> Solution:
        """Return the best values of some fields by some families; the others stay."""
        self._step = step
        chosen = {name: ones for name, ones in self._families.items() if name in families}
        beside = self._assumed_in(assumed, families, held)
        sought = [*fields, *beside]
        names = [one.name for one in sought]

        def build(numbers: FloatArray) -> Physics:
            return self._physics({**values, **dict(zip(names, numbers, strict=True))}, held)

        problem = Problem(chosen, sought, build, self._predict, assumed)
        known = {name: self._known[name] for name in chosen if name in self._known}
        begin = values | {one.name: assumed[one.name].mean for one in beside}
        found = problem.solve(np.array([begin[name] for name in names]), known)
        count = len(fields)  # what is assumed has done its part in the errors of these
        return replace(
            found,
            values=found.values[:count],
            covariance=found.covariance[:count, :count],
            assumed=dict(zip(names[count:], map(float, found.values[count:]), strict=True)),
        )

    def _assumed_in(
        self, assumed: Assumptions, families: frozenset[str], held: dict[str, Any]
    ) -> list[Field]:
        """Return the fields with assumed values that affect events of these families."""
        law = held.get("cushion", self._base.cushion)
        uses = next(one.uses for one in CUSHION_LAWS if one.name == law)
        return [
            FIELDS[name]
            for name in assumed
            if FIELDS[name].felt_by & families & set(self._families)
            and (FIELDS[name].felt_by != CUSHION or name in uses)
        ]

    def _physics(self, values: dict[str, float], held: dict[str, Any]) -> Physics:
        law = held.get("cushion", self._base.cushion)
        uses = next(one.uses for one in CUSHION_LAWS if one.name == law)
        mine = {
            name: float(value)
            for name, value in values.items()
            if FIELDS[name].felt_by != CUSHION or name in uses
        }
        return Physics(preset=self._base.preset, **{**self._lacking, **held, **mine})

    def _predict(self, physics: Physics, event: Event, before: FloatArray) -> FloatArray:
        self._played += 1
        if self._progress is not None and self._played % _TELL == 0:
            text = f"{self._step}, {self._played} shots played"
            self._progress(self._steps_done, self._steps, text)
        result = self._play(event.scene(physics, before))
        return event.read(result.sample(event.times).positions[..., :2])


_TELL = 100
"""Shots after which progress is told."""
_NAMES = {
    "rolling": "windows of rolling",
    "cushion": "contacts with cushions",
    "hit": "hits of a ball at rest",
}


def _laws_alike(solutions: dict[str, Solution]) -> list[str]:
    """Return the laws that the contacts don't tell apart, the best one first.

    One is told from the best where it fits worse by more than twice what that varies from contact
    to contact (Vuong 1989).
    """
    misfits = {name: one.misfits for name, one in solutions.items()}
    order = sorted(misfits, key=lambda name: float(np.sum(misfits[name])))
    best = misfits[order[0]]
    alike = [order[0]]
    for name in order[1:]:
        worse = misfits[name] - best
        if np.sum(worse) <= _TOLD_APART * np.sqrt(len(worse)) * np.std(worse):
            alike.append(name)
    return alike


_TOLD_APART = 2.0


def _moves_by_law(
    laws: Sequence[LawEntry],
    fields: Sequence[Field],
    solutions: dict[str, Solution],
    chosen: str,
    alike: Sequence[str],
) -> dict[str, float]:
    """Return the largest change of each value under any other law that fits equally well."""
    values = {
        law.name: _by_name(own_fields(law, fields), solutions[law.name])
        for law in laws
        if law.name in alike
    }
    return {
        name: max(abs(other[name] - value) for other in values.values() if name in other)
        for name, value in values[chosen].items()
    }


def _by_name(fields: Sequence[Field], solution: Solution) -> dict[str, float]:
    return dict(zip([one.name for one in fields], map(float, solution.values), strict=True))
