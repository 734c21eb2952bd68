"""Draw how often breaks make a ball or scratch: measured, and simulated in several ways."""

from __future__ import annotations

from typing import TYPE_CHECKING

from benchmarks.made_balls import CountedBreaks, MadeBallsMeasurement, counted_peers
from ghostball.reports import style
from ghostball.validation.measured.breaks import setups
from ghostball.validation.measured.facts import facts_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 7.2, 4.4

WAYS = {
    "compliant": "impacts that last",
    "sequential": "one impact after another",
    "simultaneous": "impacts at one instant",
}
"""The ways of Ghostball's engine to resolve impacts of several balls."""

PANELS = {"made": ("breaks that make a ball", 100.0), "scratch": ("scratches", 50.0)}
"""Title and largest value [%] of each panel."""


def draw_breaks(measured: MadeBallsMeasurement) -> Figure:
    """Draw the shares of 8-ball breaks with bars of two standard errors."""
    first = setups()[0].name
    cells = [(f"ghostball: {text}", measured.cell(first, way)) for way, text in WAYS.items()]
    cells += [
        (f"{style.engine_name(one.engine)}: {one.breaks} breaks", one)
        for one in counted_peers(measured)
    ]
    figure = style.new_figure(WIDTH, HEIGHT)
    panels = figure.subplots(1, 2, sharey=True, width_ratios=[3, 2])
    for axes, (outcome, (title, most)) in zip(panels, PANELS.items(), strict=True):
        row = next(one for one in facts_of(f"breaks-{outcome}").rows if one.what == first)
        share, error = 100.0 * row.value, 100.0 * (row.error or 0.0)
        axes.axvspan(share - 2.0 * error, share + 2.0 * error, color=style.GREY, alpha=0.22)
        axes.errorbar(share, 0, xerr=2.0 * error, fmt="D", color="black", capsize=4.0)
        for place, (_, one) in enumerate(cells, start=1):
            unknown = measured.uncertainty(first, outcome) if place == 1 else 0.0
            _draw(axes, place, one, outcome, unknown)
        axes.set(xlim=(0.0, most), title=title, xlabel="share of all breaks [%]")
        axes.grid(visible=True, axis="x")
    names = [f"measured: {row.of} breaks", *(name for name, _ in cells)]
    panels[0].set_yticks(range(len(names)), names)
    panels[0].set_ylim(len(names) - 0.5, -0.5)
    title = "8-ball breaks of professionals on a 7 ft table"
    style.set_title(figure, title)
    return figure


def _draw(axes: Axes, place: int, one: CountedBreaks, outcome: str, unknown: float) -> None:
    """Draw a share; `unknown`, the uncertainty of inputs, widens a second, thin bar."""
    share, error = one.share(outcome)
    look = style.engine_style(one.engine)
    filled = one.impacts in ("", "compliant")
    axes.errorbar(
        100.0 * share,
        place,
        xerr=200.0 * error,
        fmt=look.marker,
        color=look.colour,
        markerfacecolor=look.colour if filled else "white",
        elinewidth=3.0,
    )
    if unknown:
        both = (error**2 + unknown**2) ** 0.5
        axes.errorbar(
            100.0 * share, place, xerr=200.0 * both, fmt="", color=look.colour, capsize=4.0
        )
