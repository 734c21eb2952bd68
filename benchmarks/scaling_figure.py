"""Time per event against the number of balls and their packing, from a stored measurement."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from benchmarks.measurements import committed
from benchmarks.records import Physics, Point, ScalingMeasurement
from ghostball.reports import style

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 8.8, 4.6
NAMES: dict[Physics, str] = {"gas": "elastic gas", "cloth": "pool's physics"}


def draw_committed_scaling() -> Figure | None:
    """Draw the committed measurement; None without one."""
    measured = committed(ScalingMeasurement)
    return None if measured is None else draw_measured(measured)


def draw_measured(measured: ScalingMeasurement) -> Figure | None:
    """Draw time per event against number of balls, and against packing; None without points."""
    if not measured.by_balls and not measured.by_packing:
        return None
    figure = style.new_figure(WIDTH, HEIGHT)
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=[1.35, 1.0])
    _draw(left, measured.by_balls, "balls")
    _draw(right, measured.by_packing, "packing")
    left.set(xscale="log", yscale="log", xlabel="balls", ylabel="time per event [s]")
    left.set_title(f"against the number of balls, packing {measured.fixed_packing:g}", fontsize=9)
    right.set(xlabel="part of the area that balls cover [1]")
    right.set_title(f"against packing, {measured.fixed_balls} balls", fontsize=9)
    for axes in (left, right):
        axes.grid(visible=True)
    found: dict[str, Artist] = {}
    for axes in (left, right):
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    figure.legend([*found.values()], [*found], loc="outside lower center", ncols=3)
    environment = measured.environment
    wrong = "; interrupted" * measured.interrupted
    wrong += "; a trial at tiny sizes: its times mean nothing" * measured.quick
    when = str(environment["date"])[:10]
    style.set_title(figure, f"Time per event ({environment['cpu']}, {when}{wrong})")
    return figure


def _draw(axes: Axes, points: Sequence[Point], along: str) -> None:
    """Draw a line for each engine and physics: ours above, open markers where balls are slowed."""
    curves = dict.fromkeys((point.engine, point.physics) for point in points)
    for engine, physics in curves:
        look = style.engine_style(engine)
        mine = [point for point in points if (point.engine, point.physics) == (engine, physics)]
        mine.sort(key=lambda point: float(getattr(point, along)))
        axes.plot(
            [getattr(point, along) for point in mine],
            [point.per_event for point in mine],
            color=look.colour,
            linestyle="-" if physics == "gas" else (0.0, (4.0, 2.0)),
            linewidth=2.0 if look.ours else 1.3,
            marker=look.marker,
            markersize=4.5,
            markerfacecolor=look.colour if physics == "gas" else "white",
            zorder=3 if look.ours else 2,
            label=f"{look.name}, {NAMES[physics]}",
        )
