"""Words and numbers as every report says them."""

from __future__ import annotations

from typing import Final

from ghostball.reports import style
from ghostball.validation.measured.family import Family
from ghostball.validation.results.records import number_with_unit
from ghostball.validation.results.store import CaseRecord, Results


def many(count: int, noun: str) -> str:
    """Return "1 scene", "2 scenes"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def reused_text(results: Results) -> str:
    """Say which cases an earlier run measured; "" where none is."""
    dates = sorted(case.measured for case in results.cases if case.reused)
    if not dates:
        return ""
    when = f"on {dates[0]}" if dates[0] == dates[-1] else f"between {dates[0]} and {dates[-1]}"
    it_was = "it was" if len(dates) == 1 else "they were"
    return (
        f"{len(dates)} of {many(len(results.cases), 'case')} reused from an earlier run, since "
        f"{it_was} unchanged in inputs, code, versions and machine: measured {when}. A run time "
        "with a date was taken then; medians of run times include such."
    )


def run_time_text(case: CaseRecord, *, dated: bool) -> str:
    """Return the run time of a case, if it has one, and if `dated` with the date of then."""
    text = style.format_time(metric_of(case, "wall_time"))
    if not (dated and case.measured) or metric_of(case, "wall_time") is None:
        return text
    return f"{text} ({case.measured[:10]})"


def metric_of(case: CaseRecord, name: str) -> float | None:
    """Return a metric of a case, or None where it has no value."""
    value = case.metrics.get(name)
    return None if value is None else float(value)


def quantity_text(value: float, unit: str) -> str:
    """Return a number as reports show it, a length or a time with the unit that suits it."""
    if unit == "m":
        return style.format_length(value)
    if unit == "class":
        return number_with_unit(value, unit)
    return style.format_time(value) if unit == "s" else number_text(value)


def number_text(value: float | None) -> str:
    """Return a pure number to three digits, a count in full, a dash for None."""
    if value is None:
        return "–"
    return str(value) if isinstance(value, int) else f"{value:.3g}"


LIKENESS_KEY: Final = (
    "The numbers are standard errors of the measurement, and of what tables differ by where several"
    " were measured: what is below 2 is within them."
)
"""How `likeness_cell` is read."""


def likeness_cell(family: Family) -> str:
    """Return how far an engine is off what was measured, a dash where it lacks it.

    By how many standard errors, typically and at most; where no error is known, how far typically,
    in the unit of the figures.
    """
    if family.lacks:
        return "–"
    if family.grades:
        return f"{family.typical:.1f} ({family.most:.1f})"
    return _difference_text(family.typical_difference, family.unit)


def _difference_text(value: float, unit: str) -> str:
    if unit == "1":
        return f"{100.0 * value:.1f} %"
    return f"{value:.1f}°" if unit == "degrees" else f"{value:.3f} {unit}"
