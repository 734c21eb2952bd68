"""Charts of each engine's error with shorter and shorter time steps, against run time or steps."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from ghostball.reports import style
from ghostball.validation.precision.points import (
    PrecisionMeasurement,
    PrecisionPoint,
    knee_of,
)
from ghostball.validation.results.measurement import MeasurementError

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, ROW_HEIGHT, REST_HEIGHT = 9.6, 3.0, 1.5
COLUMNS = 3

LEGEND_CHARACTERS, HANDLE_CHARACTERS = 160, 9
"""Characters that fit into a row of the legend, and the room for a line sample, in characters."""

FLOOR = 1e-17
"""Smaller errors, including 0, are drawn at this value [m]: a tenth of an ulp of a coordinate."""

ULP = 2.0**-52
"""Height of a line in each panel [m]: the rounding of a coordinate of 1 m."""

_NAME: Any = {
    "xycoords": ("axes fraction", "data"),
    "annotation_clip": True,
    "fontsize": 6.5,
    "color": style.GREY,
}


def draw_against_time(measured: PrecisionMeasurement) -> Figure:
    """Draw the largest rest error against the run time; `measured` must have a point.

    A marker is at the run time of the whole call. A short vertical line is at the time that the
    engine itself reports, a part of the call.
    """
    title = f"Largest rest error against run time ({measured.where})"
    return _draw(
        measured,
        lambda point: point.call_seconds,
        "run time of the whole call [s]",
        title,
        second=lambda point: point.seconds,
        second_name="run time inside the engine",
    )


NO_STEPS = (
    "the plot compares time steps, and none of these engines has one. Name an engine with a time "
    "step"
)


def draw_against_steps(measured: PrecisionMeasurement) -> Figure:
    """Draw the largest rest error against the number of time steps per simulated second.

    Only time-stepping engines are drawn. Unlike run times, this chart is the same on every machine.
    A ring marks the recommended step.
    """
    points = tuple(one for one in measured.points if one.step is not None)
    if not points:
        raise MeasurementError(NO_STEPS)
    figure = _draw(
        measured.model_copy(update={"points": points}),
        lambda point: 1.0 / (point.step or 1.0),
        "time steps per simulated second",
        "Largest rest error against the number of time steps; ring: recommended step",
    )
    for axes, scene in zip(figure.axes, dict.fromkeys(one.scene for one in points), strict=False):
        _ring_knees(axes, [one for one in points if one.scene == scene])
    return figure


_Cost = Callable[[PrecisionPoint], float]


def _draw(
    measured: PrecisionMeasurement,
    cost: _Cost,
    name: str,
    title: str,
    second: _Cost | None = None,
    second_name: str = "",
) -> Figure:
    """Draw a panel for each scene: errors against a cost, with marks at a second cost if given."""
    scenes = list(dict.fromkeys(point.scene for point in measured.points))
    columns = min(COLUMNS, len(scenes))
    rows = -(-len(scenes) // columns)
    figure = style.new_figure(WIDTH, REST_HEIGHT + rows * ROW_HEIGHT)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    found: dict[str, Artist] = {}
    for axes, scene in zip(grid, scenes, strict=False):
        points = [point for point in measured.points if point.scene == scene]
        _draw_panel(axes, points, cost)
        axes.set_title(scene, fontsize=9)
        for handle, engine in zip(*axes.get_legend_handles_labels(), strict=True):
            found.setdefault(engine, handle)
        if second is not None:
            for point in points:
                colour = style.engine_style(point.engine).colour
                at = second(point), max(point.error, FLOOR)
                axes.plot(*at, linestyle="", marker="|", markersize=6.0, color=colour, zorder=2)
    for axes in grid[len(scenes) :]:
        axes.set_axis_off()
    grid[0].set(xscale="log", yscale="log")
    bottom, top = grid[0].get_ylim()
    ticks = [10.0**k for k in range(-15, 4, 3) if bottom < 10.0**k < top]
    grid[0].set_yticks(ticks, [style.format_length(one) for one in ticks])
    grid[0].tick_params(axis="y", which="minor", left=False)
    least = min(point.error_low for point in measured.points)
    if least <= FLOOR:
        grid[0].set_ylim(bottom=0.5 * FLOOR)
        grid[0].annotate("0, or below 1e-17 m", (0.99, FLOOR), **_NAME, ha="right", va="bottom")
    for k, axes in enumerate(grid[: len(scenes)]):
        axes.set_ylabel("largest rest error [m]" if k % columns == 0 else "")
        beneath = k + columns >= len(scenes)
        axes.tick_params(labelbottom=beneath)
        axes.set_xlabel(name if beneath else "")
    names = [style.engine_name(engine) for engine in found]
    handles = [*found.values()]
    if second is not None:
        grey = grid[0].plot([], [], linestyle="", marker="|", markersize=6.0, color=style.GREY)
        handles, names = [*handles, *grey], [*names, second_name]
    figure.legend(
        handles,
        names,
        loc="outside lower center",
        ncols=max(LEGEND_CHARACTERS // (max(map(len, names)) + HANDLE_CHARACTERS), 1),
        fontsize=7.5,
    )
    style.set_title(figure, title)
    return figure


def _ring_knees(axes: Axes, points: Sequence[PrecisionPoint]) -> None:
    for engine in dict.fromkeys(point.engine for point in points):
        knee = knee_of([point for point in points if point.engine == engine])
        if knee is None or knee.step is None:
            continue
        at, colour = (1.0 / knee.step, max(knee.error, FLOOR)), style.engine_style(engine).colour
        axes.plot(*at, marker="o", markersize=9.0, color=colour, fillstyle="none", zorder=5)


def _draw_panel(axes: Axes, points: Sequence[PrecisionPoint], cost: _Cost) -> None:
    """Draw a line with error bars for each engine, over a faint line at `ULP`."""
    if min(point.error_low for point in points) < 1e3 * ULP:
        axes.axhline(ULP, color=style.FAINT, linewidth=0.8, zorder=1)
        axes.annotate("rounding of 1 m", (0.99, ULP), **_NAME, ha="right", va="bottom")
    axes.grid(visible=True)
    for engine in dict.fromkeys(point.engine for point in points):
        mine = [point for point in points if point.engine == engine]
        look = style.engine_style(engine)
        x = [cost(point) for point in mine]
        y = [max(point.error, FLOOR) for point in mine]
        low = [h - max(point.error_low, FLOOR) for h, point in zip(y, mine, strict=True)]
        high = [max(point.error_high, FLOOR) - h for h, point in zip(y, mine, strict=True)]
        axes.errorbar(
            x,
            y,
            yerr=[low, high],
            color=look.colour,
            linestyle=look.line,
            linewidth=1.0,
            elinewidth=0.8,
            marker=look.marker,
            markersize=7.0 if look.ours else 3.5,
            label=engine,
            zorder=3 if look.ours else 2,
        )
        wrong = [k for k, point in enumerate(mine) if not point.same_events]
        axes.plot(
            [x[k] for k in wrong],
            [y[k] for k in wrong],
            linestyle="",
            marker=look.marker,
            markersize=3.5,
            color=look.colour,
            markerfacecolor="white",
            zorder=4,
        )


def knee_text(points: Sequence[PrecisionPoint]) -> str:
    """Return the recommended step, "1 ms"; "< 1 ms" if it is the shortest measured step.

    Return "–" if no step is recommended.
    """
    knee = knee_of(points)
    if knee is None or knee.step is None:
        return "\u2013"
    return f"{'< ' if is_finest(knee, points) else ''}{style.format_time(knee.step)}"


def is_finest(point: PrecisionPoint, points: Iterable[PrecisionPoint]) -> bool:
    """Return True if a point has the shortest step among the points of its scene."""
    same = [one for one in points if one.scene == point.scene]
    return point.step == min(one.step for one in same if one.step is not None)


def least_error(points: Sequence[PrecisionPoint]) -> str:
    """Return the smallest error and its run time: "1 nm in 24 ms".

    The error of a step is the largest over the phases of the step. With the median, an engine could
    win with a step that is good in only half of the phases.
    """
    best = min(points, key=lambda point: point.error_high)
    return f"{style.format_length(best.error_high)} in {style.format_time(best.call_seconds)}"
