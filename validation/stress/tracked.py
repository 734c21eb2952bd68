"""Numbers by which an engine is tracked from run to run: its largest step, and what breaks need.

They read the `values` of findings: `speed`, `depth`, `step` and `largest_step`, with a `ladder` of
`dt` and `missed`; and of each break `events`, `contact_steps` and `seconds`, as lists.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from ghostball.validation.stress.findings import StressFolder

SPEED: Final = 2.0
DEPTH: Final = 0.1
"""The shot that tells the largest step of an engine in one number: [m/s], and in diameters."""

QUANTILES: Final = {"p50": 50.0, "p99": 99.0, "p99.9": 99.9, "max": 100.0}
"""Names of quantiles, and percentages."""

COUNTS: Final = {
    "events": "events",
    "contact_steps": "contact steps",
    "seconds": "time of the run",
}
"""What is counted of each random break, and how tables call it."""


def tracked_numbers(folder: StressFolder) -> list[dict[str, Any]]:
    """Return the tracked numbers of each engine that has some, as plain values.

    Times are in seconds; breaks are counted.
    """
    rows = ({"engine": one} | _step(folder, one) | _needs(folder, one) for one in folder.run.labels)
    return [row for row in rows if len(row) > 1]


def _step(folder: StressFolder, label: str) -> dict[str, Any]:
    """Return the largest step of the ladder without a miss, and whether a larger one misses."""
    for one in folder.findings:
        values = one.values
        if one.label == label and (values.get("speed"), values.get("depth")) == (SPEED, DEPTH):
            return {
                "own_step": values["step"],
                "largest_step_without_a_miss": values["largest_step"],
                "larger_steps_miss": any(rung["missed"] for rung in values["ladder"]),
            }
    return {}


def _needs(folder: StressFolder, label: str) -> dict[str, Any]:
    """Return how many breaks an engine played, and quantiles of what they need."""
    found = [
        one.values
        for one in folder.findings
        if one.label == label and all(isinstance(one.values.get(name), list) for name in COUNTS)
    ]
    counts = {name: [x for values in found for x in values[name]] for name in COUNTS}
    if not counts["events"]:
        return {}
    needs = {
        name: dict(
            zip(QUANTILES, np.percentile(column, [*QUANTILES.values()]).tolist(), strict=True)
        )
        for name, column in counts.items()
    }
    return {"breaks": len(counts["events"]), "needs": needs}
