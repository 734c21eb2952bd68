"""How much a shot's end varies where its start does: for shots too chaotic to be compared singly.

Engines that agree on no single shot past its horizon may still agree on how such shots end. Each
scene is played with varied starts (`suite.varied`), as cases of the same run; here is their spread
on each engine, beside that on our engine. That compares codes, not a code with truth.
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
"""Standard errors between two means from which on they differ: one in 16 000 does by chance."""

QUANTITIES: Final[dict[str, Callable[[CaseRecord], float]]] = {
    "ball-ball collisions": lambda case: float(case.collision_counts["ball-ball"]),
    "ball-cushion collisions": lambda case: float(case.collision_counts["ball-cushion"]),
    "rest time [s]": lambda case: case.rest_time or 0.0,
}
"""What of the ends of varied starts is compared, with its unit."""


@dataclass(frozen=True)
class Spread:
    """One quantity over the varied starts of a scene on an engine.

    `mean`, `deviation`: the standard deviation is that of a single shot.
    `standard_errors`: standard errors between the mean and that on our engine, positive where it is
        larger; None of our engine, or where that has nothing to compare with.
    """

    mean: float
    deviation: float
    standard_errors: float | None = None

    @property
    def differs(self) -> bool:
        """Whether the mean differs from that on our engine by more than chance explains."""
        return self.standard_errors is not None and abs(self.standard_errors) > DIFFERS


@dataclass(frozen=True, eq=False)
class SceneSpread:
    """How varied starts of a scene end on an engine.

    `planned`, `ended`: how many there were, and how many of them came to their end.
    `broken`: how many that came to their end break a limit that any engine must keep.
    `reasons`: why the others did not come to their end, each once.
    `position_spread` [m]: how far a ball rests from where it does on average, root mean square over
        all balls.
    `quantities`: by the names of `QUANTITIES`; empty where fewer than two came to their end.
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
    """Yield how varied starts end, scene by scene and engine by engine; nothing without any."""
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
    """Return how many standard errors two means are apart; inf where neither varies."""
    difference = float(np.mean(one) - np.mean(other))
    error = math.hypot(*(float(np.std(x, ddof=1)) / math.sqrt(len(x)) for x in (one, other)))
    if error > 0.0:
        return difference / error
    return math.copysign(math.inf, difference) if difference else 0.0
