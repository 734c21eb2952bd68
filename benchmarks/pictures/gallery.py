"""Write the pictures of the README and the documentation from results and measurements."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

from benchmarks.made_balls import MadeBallsMeasurement
from benchmarks.measurements import measured
from benchmarks.pictures.breaks import draw_breaks
from benchmarks.pictures.chaos import draw_chaos
from benchmarks.pictures.paper import PAPER_FIGURES
from benchmarks.pictures.physics import PHYSICS_FIGURES
from benchmarks.pictures.racks import draw_racks
from benchmarks.pictures.rebounds import draw_rebounds
from benchmarks.pictures.sections import SECTION_FIGURES
from benchmarks.pictures.shots import our_shot
from benchmarks.racks import RacksMeasurement
from benchmarks.rebounds import ReboundsMeasurement
from ghostball.model import GhostballError
from ghostball.reports import style
from ghostball.reports.accuracy import median_error, median_text
from ghostball.reports.figures._table import aspect_of, view_of
from ghostball.reports.figures.paths import WIDTH, draw_panel
from ghostball.reports.precision import draw_against_steps, draw_against_time
from ghostball.reports.words import metric_of
from ghostball.validation.precision.points import PrecisionMeasurement
from ghostball.validation.results.records import AccuracyKind
from ghostball.validation.results.store import CLOSED_FORM, Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HERO_SCENES = ("pocket-break-9", "break-16", "break-7")
"""Scenes for the README's first picture, the hero; the first stored scene is drawn."""

HERO_ENGINES = ("ghostball", "pymunk:contact_steps=exact", "pymunk", "pybullet")
"""Engines of the hero's panels, in rows of two."""

HERO_COLUMNS = 2

ErrorOfClass = tuple[float, AccuracyKind]
"""A rest position error [m], and the accuracy class of its case."""

EXACT = 1e-17
"""Position of an error of exactly 0 on the axis [m], left of every rounding error."""


def draw_hero(results: Results) -> Figure:
    """Draw one break on several engines, and below it the errors of all engines."""
    stored = [name for name in HERO_SCENES if name in results.scene_names]
    shot, _ = our_shot(results, (stored or HERO_SCENES)[0])
    errors = {label: closed_form_errors(results, label) for label in results.labels}
    errors = {label: found for label, found in errors.items() if found}
    runs = [run for label in HERO_ENGINES for run in shot.drawn if run.label == label]
    rows = -(-len(runs) // HERO_COLUMNS)
    view = view_of(shot.scene)
    panels = rows * ((WIDTH / HERO_COLUMNS) * aspect_of(view) + 0.25) + 0.3
    dots = 1.2 + 0.27 * len(errors)
    figure = style.new_figure(WIDTH, panels + dots)
    parts: Any = figure.subfigures(2, 1, height_ratios=[panels, dots])
    upper, lower = parts
    grid = upper.subplots(rows, HERO_COLUMNS, squeeze=False).ravel()
    for axes, run in zip(grid, runs, strict=False):
        draw_panel(axes, shot, run, view)
    for axes in grid[len(runs) :]:
        axes.set_axis_off()
    style.set_title(
        upper,
        f"One break of {len(shot.scene.balls)} balls: where they stop (discs), where they should "
        "stop (rings); thick: sliding",
    )
    draw_accuracy_on(lower.subplots(), errors)
    return figure


def draw_accuracy_on(axes: Axes, errors: Mapping[str, Sequence[ErrorOfClass]]) -> None:
    """Draw the rest position errors of each engine, by label, on axes."""
    axes.set_xscale("log")
    for row, (label, found) in enumerate(errors.items()):
        _draw_dots(axes, row, label, [error for error, _ in found])
        middle, is_exact = median_error(found)
        _write_right(axes, row, f"{median_text(middle, is_exact=is_exact)} ({len(found)})")
    largest = max(error for found in errors.values() for error, _ in found)
    axes.set_xlim(EXACT / 3.0, max(10.0, 3.0 * largest))
    axes.set_ylim(len(errors) - 0.4, -0.6)
    axes.set_yticks(range(len(errors)), [style.engine_name(label) for label in errors])
    axes.tick_params(axis="y", length=0)
    exponents = [-15, -12, -9, -6, -3, 0]
    names = ["rounding\n(1 fm)", "1 pm", "1 nm", "1 µm", "1 mm", "1 m"]
    axes.set_xticks([EXACT, *(10.0**e for e in exponents)], ["0", *names])
    axes.minorticks_off()
    _write_right(axes, -0.75, "median (number of scenes)")
    axes.grid(True, axis="x")
    axes.set_xlabel("largest rest position error in a scene (dot), median of the scenes (bar)")
    count = max(len(found) for found in errors.values())
    axes.set_title(f"Rest position errors in {count} scenes with a closed form")


def _draw_dots(axes: Axes, row: int, label: str, found: Sequence[float]) -> None:
    look = style.engine_style(label)
    for i, error in enumerate(sorted(found)):
        # Successive errors are at different heights, so that equal errors are visible.
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


def _write_right(axes: Axes, row: float, text: str) -> None:
    """Write a text to the right of the axes, at the height of a row."""
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


def closed_form_errors(results: Results, label: str) -> list[ErrorOfClass]:
    """Return an engine's largest rest position error in each scene with a closed form [m].

    Each error comes with the accuracy class of its case.
    """
    found = []
    for case in results.cases:
        error, accuracy = metric_of(case, "rest_error_max"), case.accuracy
        if case.label != label or case.truth != CLOSED_FORM or error is None:
            continue
        assert accuracy is not None  # each run with a reference has a class
        found.append((error, accuracy.kind))
    return found


GALLERY: Mapping[str, Callable[[Results], Figure]] = {
    "hero": draw_hero,
    "chaos": draw_chaos,
    **PHYSICS_FIGURES,
    **PAPER_FIGURES,
}


def draw_committed() -> Iterator[tuple[str, Figure, str]]:
    """Yield name, picture and revision of each committed measurement that is drawn."""
    precision = measured(PrecisionMeasurement)
    racks, rebounds = measured(RacksMeasurement), measured(ReboundsMeasurement)
    breaks = measured(MadeBallsMeasurement)
    for name, figure, of in (
        ("precision", draw_against_time(precision), precision),
        ("steps", draw_against_steps(precision), precision),
        ("racks", draw_racks(racks), racks),
        ("rebounds", draw_rebounds(rebounds), rebounds),
        ("breaks", draw_breaks(breaks), breaks),
    ):
        yield name, figure, revision_of(of.environment)


def revision_of(environment: Mapping[str, Any]) -> str:
    """Return the revision in an environment, and whether there were uncommitted changes."""
    git = environment.get("git") or {"revision": "unknown", "dirty": False}
    return f"{git['revision']}{', with changes' if git['dirty'] else ''}"


def write_gallery(
    results_dir: str | Path, gallery_dir: str | Path, *, sections_dir: str | Path | None = None
) -> list[Path]:
    """Write the pictures of the README and the documentation as PNG; return the written files.

    `results_dir`: results of the full suite.
    `sections_dir`: results for the pictures of the paper's section 6, which may have engines that
        the suite doesn't run; None leaves these pictures out.

    The description in each PNG file names the revision that computed the data.

    Raises `GhostballError` if results are missing, or if the folder can't be written.
    """
    results = Results.open(results_dir)
    folder = Path(gallery_dir)
    with style.drawing():
        at = revision_of(results.environment)
        figures = [(name, draw(results), at) for name, draw in GALLERY.items()]
        if sections_dir is not None:
            sections = Results.open(sections_dir)
            at = revision_of(sections.environment)
            figures += [(name, draw(sections), at) for name, draw in SECTION_FIGURES.items()]
        figures += draw_committed()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            saved = [
                style.save_figure(figure, folder / name, revision, endings=["png"])
                for name, figure, revision in figures
            ]
        except OSError as error:
            raise GhostballError(
                f"{folder}: can't write the gallery: {error.strerror or error}. Choose another "
                "folder"
            ) from error
    return [path for paths in saved for path in paths]
