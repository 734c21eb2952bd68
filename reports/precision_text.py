"""Errors against time in words, the same in a terminal, a report and a figure."""

from __future__ import annotations

from collections.abc import Sequence

from ghostball.reports import style
from ghostball.validation.bench import PrecisionMeasurement
from ghostball.validation.bench.precision import (
    NO_STEP,
    PrecisionCurve,
    PrecisionPoint,
    Reach,
    best_of,
)

LEGEND = (
    "Times are of the simulation alone, the least of all samples. A time counts where all finer "
    "steps are as near, from every phase of the step. ~ is extrapolated by the order; never: "
    "neither a step that was run nor the order reaches it. "
    "The least error is that of the worst phase of the best step."
)

LEAST_ERROR = "least error (worst phase)"
"""Heads the column that `best_text` fills."""


def reach_heading(target: float) -> str:
    """Return the heading of a column: "to 1 mm"."""
    return f"to {style.format_length(target)}"


def reach_text(reach: Reach) -> str:
    """Return a time, marked where it is extrapolated, or "never"."""
    if reach.how == "never":
        return "never"
    mark = "~ " if reach.how == "extrapolated" else ""
    return mark + duration_text(reach.seconds or 0.0)


def duration_text(seconds: float) -> str:
    """Return a duration, which may be of minutes, hours, days or years, to three digits."""
    for unit, length in (("years", 31_557_600.0), ("days", 86_400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * length:
            return f"{float(f'{seconds / length:.3g}'):,.10g} {unit}"
    return style.format_time(seconds)


def order_text(curve: PrecisionCurve) -> str:
    """Return the order, or a dash."""
    return "–" if curve.order is None else f"{curve.order:.2f}"


def best_text(points: Sequence[PrecisionPoint]) -> str:
    """Return the least error of an engine and the time it took: "1.37 nm in 24 ms"."""
    best = best_of(points)
    return f"{style.format_length(best.error_high)} in {style.format_time(best.seconds)}"


def legend_text(engine: str, curves: Sequence[PrecisionCurve]) -> str:
    """Return an engine's name with the range of its orders, or that it has none."""
    orders = [curve.order for curve in curves if curve.order is not None]
    name = style.engine_name(engine)
    if not orders:
        exact = all(curve.order_note == NO_STEP for curve in curves)
        return f"{name}: {NO_STEP if exact else 'no order'}"
    low, high = (f"{value:.2g}" for value in (min(orders), max(orders)))
    said = f"{name}: order {low}" if low == high else f"{name}: order {low} to {high}"
    beside = any(curve.limit_beside > 0.0 for curve in curves)
    return said + (", beside the truth" if beside else "")


def works_of(measured: PrecisionMeasurement) -> str:
    """Return what work is counted in: "steps; of engines without a step: events"."""
    stepping, exact = (
        sorted({p.work_name or "nothing" for p in measured.points if p.exact == wanted})
        for wanted in (False, True)
    )
    said = ", ".join(stepping)
    if not exact or exact == stepping:
        return said
    return f"{said}; of engines without a step: {', '.join(exact)}"
