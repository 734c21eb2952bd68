"""Texts and numbers, the same in every report."""

from __future__ import annotations

import math
from typing import Final

from ghostball.reports import style
from ghostball.validation.measured.figures import FigureFamily
from ghostball.validation.results.store import CaseRecord, Results


def many(count: int, noun: str) -> str:
    """Return "1 scene", "2 scenes"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def reused_text(results: Results) -> str:
    """Return how many cases were reused, and when they were measured; "" if there are none."""
    dates = sorted(case.measured for case in results.cases if case.reused)
    if not dates:
        return ""
    when = f"on {dates[0]}" if dates[0] == dates[-1] else f"between {dates[0]} and {dates[-1]}"
    return (
        f"{len(dates)} of {many(len(results.cases), 'case')} reused from an earlier run ({when}) "
        "with the same inputs, code, versions and machine. Run times with a date are from that "
        "run, and medians of run times include them."
    )


def run_time_text(case: CaseRecord, *, dated: bool) -> str:
    """Return the run time of a case, or "–"; if `dated`, with the date of the measurement."""
    seconds = metric_of(case, "wall_time")
    date = f" ({case.measured[:10]})" if dated and case.measured and seconds is not None else ""
    return style.format_time(seconds) + date


def metric_of(case: CaseRecord | None, name: str) -> float | None:
    """Return a metric of a case, or None if it has no finite value."""
    value = None if case is None else case.metrics.get(name)
    return float(value) if value is not None and math.isfinite(value) else None


AGREEMENT_KEY: Final = (
    "Unit: standard errors of the measurement, which include the spread between tables if several "
    "were measured, and the uncertainty of measured inputs. ✓: no difference exceeds two standard "
    "errors."
)
"""Explanation of `agreement_cell`."""


def agreement_cell(family: FigureFamily) -> str:
    """Return the difference of an engine from measurements; a dash if it doesn't support them.

    It is the typical and the largest difference in standard errors, with a mark if no difference
    exceeds two standard errors; or, if the error of the measurements is unknown, the typical
    difference in their unit.
    """
    if family.lacks:
        return "–"
    if family.grades:
        return f"{family.typical:.1f} ({family.most:.1f})" + " ✓" * bool(family.is_within_known)
    return _difference_text(family.typical_difference, family.unit)


def _difference_text(value: float, unit: str) -> str:
    if unit == "1":
        return f"{100.0 * value:.1f} %"
    return f"{value:.1f}°" if unit == "degrees" else f"{value:.3f} {unit}"
