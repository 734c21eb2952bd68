"""How far each engine's balls rest from the truth, on a logarithmic axis, with the limits."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ghostball.reports import style
from ghostball.reports.figures._rows import draw_row_notes, row_height, set_row_names
from ghostball.reports.figures.paths import WIDTH
from ghostball.reports.shots import CHAOTIC, Run, Shot
from ghostball.validation.checks.verdict import RestError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

EXACT = 1e-17
"""Where a bar for an error of exactly 0 would start [m]: below the rounding of any table."""

DRAWN = (RestError.JUDGED, RestError.UNJUDGED)
"""Errors that get a bar; any other number would only look like one."""


def draw_errors(shot: Shot) -> Figure | None:
    """Draw the largest and the RMS rest error of each engine as bar and dot.

    None where no engine has a rest error that means something, or one alone of several could run.
    """
    if shot.one_of_several or not any(run.standing in DRAWN for run in shot.runs):
        return None
    figure = style.new_figure(WIDTH, row_height(shot) + 1.25)
    axes = figure.subplots()
    left, right = _limits(shot)
    axes.set_xscale("log")
    axes.set_xlim(left, right)
    style.set_length_ticks(axes, left, min(right, 10.0 * _largest(shot)))
    for row, run in enumerate(shot.runs):
        _draw_row(axes, row, run, left, right)
    set_row_names(axes, shot)
    draw_row_notes(axes, shot)
    axes.set_xlabel(f"{shot.end} error (logarithmic)")
    axes.grid(True, axis="x")
    balls = "resting balls" if shot.end == "rest" else "balls at the end"
    axes.set_title(f"{shot.scene.name}: distance of the {balls} from the truth")
    _add_legend(figure, shot)
    return figure


def _draw_row(axes: Axes, row: int, run: Run, left: float, right: float) -> None:
    from matplotlib.patheffects import withStroke  # noqa: PLC0415

    limit = run.limit("rest_error_max")
    if run.standing in DRAWN:
        _draw_bar(axes, row, run, left)
    if limit is not None and limit > 0.0:
        (line,) = axes.plot(
            [limit, limit], [row - 0.42, row + 0.42], color=style.BLACK, linewidth=2.2
        )
        # Where a limit is not kept its line is within the bar, and ours is black.
        line.set_path_effects([withStroke(linewidth=4.4, foreground="white")])
    start = max(run.metric("rest_error_max") or 0.0, limit if limit and limit < right else 0.0)
    axes.annotate(
        _row_text(run),
        (max(start, left) if run.standing in DRAWN else left, row),
        xytext=(6, 0),
        textcoords="offset points",
        va="center",
        fontsize=8.5,
    )


def _draw_bar(axes: Axes, row: int, run: Run, left: float) -> None:
    largest, rms = run.metric("rest_error_max"), run.metric("rest_error_rms")
    if largest:
        axes.barh(row, largest - left, left=left, height=0.62, color=run.style.colour)
    if rms:
        axes.plot(rms, row, "o", color="white", markeredgecolor=style.BLACK, markersize=4.5)


def _row_text(run: Run) -> str:
    largest = run.metric("rest_error_max")
    shown = style.format_length(largest) if largest else "0, exactly"
    return {
        RestError.JUDGED: f"{shown}  {run.rest_verdict.legend}{_in_ulps(run)}",
        RestError.UNJUDGED: f"({shown})  not judged",
        RestError.CHAOTIC: f"{CHAOTIC}: no error",
        RestError.OWN: "compared with itself",
        RestError.NONE: "",
    }[run.standing]


def _in_ulps(run: Run) -> str:
    """Say against which limit an error stands that is judged in units of rounding alone.

    Such a limit has no place on an axis of lengths.
    """
    checks = run.case.checks if run.case is not None else ()
    for check in checks:
        if check.metric == "rest_error_ulps" and check.limit_kind == "at_most":
            if run.limit("rest_error_max") is not None or check.value is None:
                return ""
            sign = "≤" if check.passed else ">"
            return f": {check.value:.2g} {sign} {check.limit:g} ulps"
    return ""


def _lengths(shot: Shot) -> list[float]:
    """Return every error and limit that is drawn, without zeros [m]."""
    return [
        value
        for run in shot.runs
        if run.standing in DRAWN
        for value in (
            run.metric("rest_error_max"),
            run.metric("rest_error_rms"),
            run.limit("rest_error_max"),
        )
        if value is not None and value > 0.0
    ]


def _largest(shot: Shot) -> float:
    return max(_lengths(shot), default=1e-12)


def _limits(shot: Shot) -> tuple[float, float]:
    values = _lengths(shot)
    if not values:
        return EXACT, 1e-12
    decades = math.log10(max(values)), math.log10(min(values))
    left = max(EXACT, 10.0 ** (math.floor(decades[1]) - 1))
    # Room on the right for a value and a verdict.
    span = max(3.0, decades[0] - math.log10(left))
    return left, 10.0 ** (decades[0] + 0.33 * span)


def _add_legend(figure: Figure, shot: Shot) -> None:
    from matplotlib.lines import Line2D  # noqa: PLC0415
    from matplotlib.patches import Patch  # noqa: PLC0415

    handles = [
        Patch(color=style.GREY, label="largest of all balls"),
        Line2D(
            [],
            [],
            linestyle="none",
            marker="o",
            color="white",
            markeredgecolor=style.BLACK,
            markersize=4.5,
            label="root mean square",
        ),
        Line2D([], [], color=style.BLACK, linewidth=2.2, label="limit to pass (largest)"),
    ]
    title = f"truth: {shot.truth}" if shot.truth else None
    figure.legend(
        handles=handles, loc="outside lower center", ncols=3, title=title, title_fontsize=8.5
    )
