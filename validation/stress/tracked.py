"""The number by which an engine is tracked from run to run: its largest step without a miss.

It is read from the `values` of findings: `speed`, `depth`, `step` and `largest_step`, with a
`ladder` of `dt` and `missed`.
"""

from __future__ import annotations

from typing import Any

from ghostball.validation.stress.families.tunnelling import DEPTH, SPEED
from ghostball.validation.stress.findings import StressFolder


def tracked_numbers(folder: StressFolder) -> list[dict[str, Any]]:
    """Return the largest step [s] of each engine that has a ladder of them, as plain values.

    And whether a larger one misses.
    """
    return [
        {
            "engine": one.label,
            "own_step": one.values["step"],
            "largest_step_without_a_miss": one.values["largest_step"],
            "larger_steps_miss": any(rung["missed"] for rung in one.values["ladder"]),
        }
        for one in folder.findings
        if "ladder" in one.values
        and (one.values.get("speed"), one.values.get("depth")) == (SPEED, DEPTH)
    ]
