"""Draw measured rebounds and the best fit of each engine, from a committed measurement."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from benchmarks.rebounds import BestRebounds, ReboundsMeasurement
from ghostball.reports import style
from ghostball.validation.measured.facts import facts_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 8.8, 4.4


def best_of_each(measured: ReboundsMeasurement) -> list[BestRebounds]:
    """Return the best cushion law and coefficients of each engine."""
    engines = dict.fromkeys(one.engine for one in measured.best)
    return [
        min((one for one in measured.best if one.engine == engine), key=lambda one: one.typical)
        for engine in engines
    ]


def draw_rebounds(measured: ReboundsMeasurement) -> Figure:
    """Draw the measurements with bars of two standard errors, and the best fit of each engine."""
    rows = facts_of("cushion-carom").rows
    at = np.array([row.place for row in rows])
    value = np.array([row.value for row in rows])
    error = np.array([row.error or 0.0 for row in rows])
    figure = style.new_figure(WIDTH, HEIGHT)
    axes = figure.subplots()
    for one in best_of_each(measured):
        look = style.engine_style(one.engine)
        falls = "falls with speed" if one.falls else "is constant"
        axes.plot(
            at,
            value + np.array(one.errors_off[0]) * error,
            color=look.colour,
            marker=look.marker,
            markersize=4.0,
            linewidth=2.0 if look.ours else 1.3,
            label=f"{look.name}: restitution {falls}",
        )
    axes.errorbar(
        at,
        value,
        2.0 * error,
        fmt="o",
        color=style.GREY,
        markersize=7.0,
        elinewidth=3.0,
        label="measured, two standard errors",
        zorder=0,
    )
    axes.set(xlabel="approach speed [m/s]", ylabel="separation speed / approach speed [1]")
    axes.grid(visible=True)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    style.set_title(figure, "Rebounds on a three-cushion table, and the best fit of each engine")
    return figure
