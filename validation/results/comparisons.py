"""What a run is compared by: where balls rest, which collisions there are, how energy decays.

`comparisons_of` makes the three comparisons of a case; the terminal, the page, JSON and CSV show
them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ghostball.model import COLLISION_KINDS
from ghostball.validation.results.records import CaseRecord


@dataclass(frozen=True)
class Comparisons:
    """The three comparisons of a case; None is what wasn't measured, or can't be.

    `rest_error` [m]: largest distance of a ball from where it should end.
    `rest_ball`: the id of that ball.
    `counts`: collisions by kind, such as "ball-ball": how many there are, and how many in truth.
    `energy_difference`: largest difference from the true energy, over the initial energy.
    `energy_time` [s]: when that is; None also where the energy is the true one all the time.
    """

    rest_error: float | None
    rest_ball: str | None
    counts: Mapping[str, tuple[int, int | None]]
    energy_difference: float | None
    energy_time: float | None


def comparisons_of(case: CaseRecord) -> Comparisons | None:
    """Return the three comparisons of a case, or None where it didn't run.

    Where our engine is all there is to compare with, nothing is said of our engine.
    """
    if case.outcome != "ran":
        return None
    own = case.is_own_measure
    measured: Mapping[str, int | float | None] = {} if own else case.metrics
    true = None if own else case.truth_counts
    counts = {
        kind.label: (
            case.collision_counts.get(kind.label, 0),
            None if true is None else true.get(kind.label, 0),
        )
        for kind in COLLISION_KINDS
    }
    error, ball = measured.get("rest_error_max"), None
    if error is not None and case.ball_errors is not None:
        ball = str(case.definition["balls"][int(np.argmax(case.ball_errors))]["id"])
    return Comparisons(
        rest_error=error,
        rest_ball=ball,
        counts=counts,
        energy_difference=measured.get("energy_difference_max"),
        energy_time=measured.get("energy_difference_time"),
    )


def comparison_row(case: CaseRecord) -> dict[str, Any]:
    """Return the three comparisons of a case that ran as a row of plain values, {} of another."""
    found = comparisons_of(case)
    if found is None:
        return {}
    counts: dict[str, int | None] = {}
    for kind, (count, true) in found.counts.items():
        name = kind.replace("-", "_")
        counts |= {f"{name}_count": count, f"{name}_count_true": true}
    return {
        "scene": case.scene,
        "label": case.label,
        "rest_error": found.rest_error,
        "rest_ball": found.rest_ball,
        **counts,
        "energy_difference": found.energy_difference,
        "energy_difference_time": found.energy_time,
    }
