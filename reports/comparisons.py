"""The three comparisons of each run in words, as the terminal and the page show them."""

from __future__ import annotations

from ghostball.reports import style
from ghostball.reports.shots import standing_text
from ghostball.reports.words import number_text
from ghostball.validation.results.comparisons import comparisons_of
from ghostball.validation.results.store import CaseRecord

HEADS = (
    "largest rest error",
    "of ball",
    "ball-ball / reference",
    "ball-cushion / reference",
    "largest energy difference",
    "at",
)
"""Headings of `comparison_cells`."""

KEY = (
    "Rest positions: the largest rest error of a ball; in brackets if no limit judges it. "
    "Collisions: number in the run / number in the reference. Energy: the largest deviation from "
    "the reference energy, divided by the initial energy, and its time."
)
"""What the columns mean."""


def comparison_cells(case: CaseRecord) -> tuple[str, ...] | None:
    """Return the cells of one run, as `HEADS` says, or None where it didn't run."""
    found = comparisons_of(case)
    if found is None:
        return None
    rest = standing_text(case, style.format_length(found.rest_error))
    counts = []
    for count, true in found.counts.values():
        differs = "" if true is None or count == true else " ≠"
        counts.append(f"{count} / {'–' if true is None else true}{differs}")
    when = found.energy_time
    return (
        "the reference" if case.is_own_measure else rest or "–",
        found.rest_ball or "–",
        *counts,
        number_text(found.energy_difference),
        "–" if when is None else f"{when:.4g} s",
    )
