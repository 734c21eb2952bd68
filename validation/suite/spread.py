"""The spread of final states for perturbed initial states, for shots too chaotic to compare singly.

Engines that disagree on each single shot after its horizon may still agree on the distribution of
final states. Each scene is run with perturbed initial states (`suite.ensemble`) as cases of the
same run. This module computes the spread on each engine, and compares it with that on Ghostball's
engine. This compares two codes; it doesn't compare a code with a reference result.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.checks.verdict import is_unfinished
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.results.store import Results

DIFFERS: Final = 4.0
"""Difference of two means, in standard errors, that counts as significant: 1 in 16 000 by chance.
"""

QUANTITIES: Final[dict[str, Callable[[CaseRecord], float]]] = {
    "ball-ball collisions": lambda case: float(case.collision_counts["ball-ball"]),
    "ball-cushion collisions": lambda case: float(case.collision_counts["ball-cushion"]),
    "rest time [s]": lambda case: case.rest_time or 0.0,
}
"""Quantities of the final state that are compared, with their units."""


@dataclass(frozen=True)
class Spread:
    """One quantity over the perturbed runs of a scene on an engine.

    `mean`, `deviation`: mean, and standard deviation of a single run.
    `standard_errors`: difference between the mean and that on Ghostball's engine, in standard
        errors; positive if the mean is larger. None for Ghostball's engine, or without values to
        compare with.
    """

    mean: float
    deviation: float
    standard_errors: float | None = None

    @property
    def differs(self) -> bool:
        """True if chance doesn't explain the difference from the mean on Ghostball's engine."""
        return self.standard_errors is not None and abs(self.standard_errors) > DIFFERS


@dataclass(frozen=True, eq=False)
class SceneSpread:
    """Spread of the results of one scene on one engine, from perturbed initial states.

    `planned`, `ended`: number of runs planned, and finished.
    `broken`: number of finished runs that fail a common limit.
    `reasons`: why the remaining runs did not finish, without duplicates.
    `position_spread` [m]: distance of a ball from its mean rest position, rms over all balls.
    `quantities`: by the names of `QUANTITIES`; empty if fewer than two runs finished.
    """

    scene: str
    label: str
    planned: int
    ended: int
    broken: int
    reasons: tuple[str, ...]
    position_spread: float | None
    quantities: dict[str, Spread]


def spreads_of(results: Results) -> Iterator[SceneSpread]:
    """Yield the spread of each scene with perturbed initial states, on each engine."""
    cases: dict[tuple[str, str], list[CaseRecord]] = {}
    for case in results.varied:
        cases.setdefault((case.varied_from, case.label), []).append(case)
    for scene in results.scene_names:
        ours = _values(cases.get((scene, OURS), []))
        for label in results.labels:
            if (scene, label) in cases:
                yield _spread(scene, label, cases[scene, label], {} if label == OURS else ours)


def _ended(cases: list[CaseRecord]) -> list[CaseRecord]:
    return [case for case in cases if case.outcome == "ran" and not is_unfinished(case)]


def _values(cases: list[CaseRecord]) -> dict[str, FloatArray]:
    ended = _ended(cases)
    return {name: np.array([of(case) for case in ended]) for name, of in QUANTITIES.items()}


def _spread(
    scene: str, label: str, cases: list[CaseRecord], ours: dict[str, FloatArray]
) -> SceneSpread:
    ended, values = _ended(cases), _values(cases)
    position_spread, quantities = None, {}
    if len(ended) >= 2:
        rest = np.array([case.rest_positions for case in ended])
        position_spread = float(np.sqrt(np.mean(np.sum((rest - rest.mean(axis=0)) ** 2, axis=2))))
        quantities = {
            name: Spread(
                float(np.mean(found)),
                float(np.std(found, ddof=1)),
                _standard_errors_between(found, ours[name])
                if name in ours and len(ours[name]) >= 2
                else None,
            )
            for name, found in values.items()
        }
    return SceneSpread(
        scene,
        label,
        len(cases),
        len(ended),
        sum(case.passed is False for case in ended),
        tuple(dict.fromkeys(case.reason for case in cases if case not in ended)),
        position_spread,
        quantities,
    )


def _standard_errors_between(one: FloatArray, other: FloatArray) -> float:
    """Return the difference of two means in standard errors; inf if neither sample varies."""
    difference = float(np.mean(one) - np.mean(other))
    error = math.hypot(*(float(np.std(x, ddof=1)) / math.sqrt(len(x)) for x in (one, other)))
    if error > 0.0:
        return difference / error
    return math.copysign(math.inf, difference) if difference else 0.0
