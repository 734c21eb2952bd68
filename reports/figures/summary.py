"""All scenes and engines at a glance: who passed, and how far each engine is from the truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import median
from typing import TYPE_CHECKING

from ghostball.reports import style
from ghostball.reports.figures.paths import WIDTH
from ghostball.reports.shots import NUMBERS_KEY, cell_text, rest_error
from ghostball.validation.checks.verdict import Verdict, verdict_of
from ghostball.validation.results.store import CLOSED_FORM, CaseRecord, Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Pale, so that black text on them is read easily; the symbol says the same.
CELL_COLOURS = {
    Verdict.PASS: "#CDEBE0",
    Verdict.LIMITS_HOLD: "#FBF3CF",
    Verdict.FAIL: "#F8D3BB",
    Verdict.REFERENCE: "#E3E3E3",
    Verdict.SHOWN: "#FFFFFF",
    Verdict.NOT_REPRESENTABLE: "#F4F4F4",
    Verdict.UNAVAILABLE: "#F4F4F4",
    Verdict.CRASHED: "#F8D3BB",
    Verdict.MISSING: "#FFFFFF",
}

EXACT = 1e-17
"""Where an error of exactly 0 is drawn [m]: left of every rounding error."""

COLUMN_WIDTH = 1.02
ROW_HEIGHT = 0.235


def draw_verdicts(results: Results) -> Figure:
    """Draw scenes against engines: verdict by colour and symbol, largest rest error as text."""
    scenes, labels = results.scene_names, results.labels
    figure = style.new_figure(2.2 + COLUMN_WIDTH * len(labels), 1.7 + ROW_HEIGHT * len(scenes))
    axes = figure.subplots()
    _draw_cells(axes, [[results.case(scene, label) for label in labels] for scene in scenes])
    axes.set_xlim(-0.5, len(labels) - 0.5)
    axes.set_ylim(len(scenes) - 0.5, -0.5)
    names = [_in_two_lines(style.engine_name(label)) for label in labels]
    axes.set_xticks(range(len(labels)), names)
    axes.set_yticks(range(len(scenes)), scenes)
    axes.xaxis.tick_top()
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    style.set_title(figure, "Verdict and largest rest error, by scene and engine")
    _add_key(figure, results)
    return figure


def _in_two_lines(name: str) -> str:
    return name.replace(", ", "\n").replace("paper-", "paper-\n")


def _draw_cells(axes: Axes, rows: Sequence[Sequence[CaseRecord | None]]) -> None:
    """Draw a square of unit size for each case, with its text; row 0 is at height 0.

    A square of its own for each case, and texts that the layout looks at though they lie within the
    axes, took half of the time of this figure.
    """
    from matplotlib.collections import PolyCollection  # noqa: PLC0415

    squares, colours = [], []
    for y, cases in enumerate(rows):
        for x, case in enumerate(cases):
            left, right, top, bottom = x - 0.5, x + 0.5, y - 0.5, y + 0.5
            squares.append([(left, top), (right, top), (right, bottom), (left, bottom)])
            colours.append(CELL_COLOURS[verdict_of(case)])
            text = axes.text(x, y, cell_text(case), ha="center", va="center", fontsize=8)
            text.set_in_layout(False)
    cells = PolyCollection(squares, facecolors=colours, edgecolors="white", linewidths=1.5)
    axes.add_collection(cells, autolim=False)


def _add_key(figure: Figure, results: Results) -> None:
    from matplotlib.patches import Patch  # noqa: PLC0415

    present = {verdict_of(results.case(s, e)) for s in results.scene_names for e in results.labels}
    handles = [
        Patch(
            facecolor=CELL_COLOURS[verdict],
            edgecolor=style.FAINT,
            label=verdict.legend,
        )
        for verdict in Verdict
        if verdict in present
    ]
    figure.legend(
        handles=handles,
        loc="outside lower center",
        ncols=-(-len(handles) // 2),
        title=NUMBERS_KEY,
        title_fontsize=8.5,
    )


def draw_accuracy(results: Results) -> Figure | None:
    """Draw one dot for each closed-form scene and engine on a logarithmic axis of rest errors.

    None where no such scene is stored.
    """
    errors = accuracy_errors(results)
    if not errors:
        return None
    figure = style.new_figure(WIDTH, 1.35 + 0.36 * len(errors))
    draw_accuracy_on(figure.subplots(), errors)
    return figure


def accuracy_errors(results: Results) -> dict[str, list[float]]:
    """Return the rest errors [m] of each engine in the closed-form scenes; none is left out empty.

    Only scenes whose truth doesn't come from our own engine count.
    """
    errors = {label: independent_errors(results, label) for label in results.labels}
    return {label: found for label, found in errors.items() if found}


def draw_accuracy_on(axes: Axes, errors: Mapping[str, Sequence[float]]) -> None:
    """Draw the rest errors of each engine, by label, on given axes."""
    axes.set_xscale("log")
    for row, (label, found) in enumerate(errors.items()):
        _draw_dots(axes, row, label, found)
    largest = max(max(found) for found in errors.values())
    axes.set_xlim(EXACT / 3.0, max(10.0, 3.0 * largest))
    axes.set_ylim(len(errors) - 0.4, -0.6)
    axes.set_yticks(range(len(errors)), [style.engine_name(label) for label in errors])
    axes.tick_params(axis="y", length=0)
    exponents = [-15, -12, -9, -6, -3, 0]
    names = ["1 fm", "1 pm", "1 nm", "1 µm", "1 mm", "1 m"]
    axes.set_xticks([EXACT, *(10.0**e for e in exponents)], ["0", *names])
    axes.minorticks_off()
    _write_right(axes, -0.75, "median (scenes)")
    axes.grid(True, axis="x")
    axes.set_xlabel("largest rest error of a scene (dot), median of the scenes (bar)")
    count = max(len(found) for found in errors.values())
    axes.set_title(f"How far from the exact solution the balls rest, {count} closed-form scenes")


def _draw_dots(axes: Axes, row: int, label: str, found: Sequence[float]) -> None:
    look = style.engine_style(label)
    for i, error in enumerate(sorted(found)):
        # Neighbours in size lie on different heights, so that equal errors don't hide each other.
        height = row + 0.13 * ((i % 3) - 1)
        axes.plot(
            max(error, EXACT),
            height,
            marker=look.marker,
            color=look.colour,
            markersize=5.5,
            alpha=0.75,
            markeredgecolor="white",
            markeredgewidth=0.5,
        )
    middle = max(median(found), EXACT)
    axes.plot([middle, middle], [row - 0.36, row + 0.36], color=look.colour, linewidth=2.4)
    text = f"{style.format_length(median(found))} ({len(found)})"
    _write_right(axes, row, text)


def _write_right(axes: Axes, row: float, text: str) -> None:
    """Write right of the axes, at the height of a row."""
    axes.annotate(
        text,
        (1.0, row),
        xycoords=axes.get_yaxis_transform(),
        xytext=(6, 0),
        textcoords="offset points",
        va="center",
        fontsize=8.5,
        annotation_clip=False,
    )


def independent_errors(results: Results, label: str) -> list[float]:
    """Return an engine's largest rest error in each scene of independent truth [m]."""
    found = []
    for case in results.cases:
        error = rest_error(case)
        if case.label == label and error is not None and case.truth == CLOSED_FORM:
            found.append(error)
    return found
