"""Numbers by which an engine is tracked from run to run: its largest step, and what breaks need.

They read the `values` of findings, by the names that `reports.stress_figures` lists.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ghostball.validation.stress.findings import Finding, StressFolder

SPEED: Final = 2.0
DEPTH: Final = 0.1
"""The shot that tells the largest step of an engine in one number: [m/s], and in diameters."""

QUANTILES: Final = {"p50": 50.0, "p99": 99.0, "p99.9": 99.9, "max": 100.0}
"""Names of quantiles, and percentages."""

COUNTS: Final = {
    "events": "events",
    "contact_steps": "contact steps",
    "seconds": "time of the run [s]",
}
"""What is counted of each random break, and how tables and axes call it."""


@dataclass(frozen=True)
class LargestStep:
    """The largest step without a miss in one shot, of an engine that steps.

    Attributes
    ----------
    own : float [s]
        The engine's own step, at which it was asked.
    largest : float or None [s]
        The largest of the ladder at which, as at all shorter ones, nothing is missed; None where
        even the shortest misses.
    is_cliff : bool
        Whether a longer one of the ladder misses; else the largest is only the longest tried.
    """

    own: float
    largest: float | None
    is_cliff: bool


def cliffs(folder: StressFolder, label: str) -> list[Finding]:
    """Return the findings on an engine that say how large a step may be."""
    return [
        one
        for one in folder.findings
        if one.label == label and {"speed", "depth", "largest_step"} <= one.values.keys()
    ]


def has_cliff(one: Finding) -> bool:
    """Whether some step of the ladder misses."""
    return any(rung["missed"] for rung in ladder_of(one))


def ladder_of(one: Finding) -> list[dict[str, Any]]:
    """Return what a finding says of each step of a ladder; nothing where it has none."""
    ladder = one.values.get("ladder", [])
    return [rung for rung in ladder if isinstance(rung, dict)] if isinstance(ladder, list) else []


def largest_step(folder: StressFolder, label: str) -> LargestStep | None:
    """Return the tracked number of an engine; None where the run doesn't have it."""
    for one in cliffs(folder, label):
        values = one.values
        if (values["speed"], values["depth"]) == (SPEED, DEPTH):
            return LargestStep(values["step"], values["largest_step"], has_cliff(one))
    return None


def storm_counts(folder: StressFolder, label: str) -> dict[str, NDArray[np.float64]] | None:
    """Return a number for each break that an engine played, by name of `COUNTS`; None without any.

    Each (k,): counts, and the run's wall time [s].
    """
    found = [
        one.values
        for one in folder.findings
        if one.label == label and all(isinstance(one.values.get(name), list) for name in COUNTS)
    ]
    if not any(values["events"] for values in found):
        return None
    return {
        name: np.array([x for values in found for x in values[name]], dtype=np.float64)
        for name in COUNTS
    }


def storm_quantiles(folder: StressFolder, label: str) -> dict[str, dict[str, float]] | None:
    """Return the quantiles of what breaks need, by name of `COUNTS` and of `QUANTILES`."""
    counts = storm_counts(folder, label)
    if counts is None:
        return None
    return {
        name: dict(
            zip(QUANTILES, np.percentile(column, [*QUANTILES.values()]).tolist(), strict=True)
        )
        for name, column in counts.items()
    }


def tracked_numbers(folder: StressFolder) -> list[dict[str, Any]]:
    """Return the tracked numbers of each engine that has some, as plain values.

    Times are in seconds; breaks are counted.
    """
    rows = []
    for label in folder.run.labels:
        step, counts = largest_step(folder, label), storm_counts(folder, label)
        row: dict[str, Any] = {}
        if step is not None:
            row |= {
                "own_step": step.own,
                "largest_step_without_a_miss": step.largest,
                "larger_steps_miss": step.is_cliff,
            }
        if counts is not None:
            row |= {"breaks": len(counts["events"]), "needs": storm_quantiles(folder, label)}
        if row:
            rows.append({"engine": label, **row})
    return rows
