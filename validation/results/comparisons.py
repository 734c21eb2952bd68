"""Compare a run with the reference: rest positions, collisions and energy.

`comparisons_of` makes the three comparisons of a case. The terminal, the page, JSON and CSV show
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
    """The three comparisons of a case; None for a value that wasn't or can't be measured.

    `rest_error` [m]: largest distance of a ball from its reference rest position.
    `rest_ball`: the id of that ball.
    `counts`: by kind of collision, such as "ball-ball": number in the run and in the reference.
    `energy_difference`: largest deviation from the reference energy, over the initial energy.
    `energy_time` [s]: time of this deviation; None also if the energy never deviates.
    """

    rest_error: float | None
    rest_ball: str | None
    counts: Mapping[str, tuple[int, int | None]]
    energy_difference: float | None
    energy_time: float | None


def comparisons_of(case: CaseRecord) -> Comparisons | None:
    """Return the three comparisons of a case, or None if the case didn't run.

    If Ghostball's engine is the only reference, its own case has no values.
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
    """Return the three comparisons as a row of plain values; {} if the case didn't run."""
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
