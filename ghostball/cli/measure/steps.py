"""`ghostball engines --steps`: measure error against run time, and recommend a time step."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import typer
from rich.markup import escape
from rich.table import Table

from ghostball.cli.options import TextOrJson
from ghostball.cli.shared.config import load_config
from ghostball.cli.shared.progress import counting
from ghostball.cli.shared.single_shots import check_plot
from ghostball.cli.shared.tables import table_of
from ghostball.cli.shared.terminal import tables
from ghostball.reference_adapters import make_engine
from ghostball.reports import style
from ghostball.reports.precision import (
    NO_STEPS,
    draw_against_steps,
    is_finest,
    knee_text,
    least_error,
)
from ghostball.reports.style import format_length, format_time
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.precision.measure import (
    DEFAULT_SCENES,
    PRECISION_ENGINES,
    measure_precision,
)
from ghostball.validation.precision.points import (
    TARGETS,
    USELESS_ERROR,
    PrecisionMeasurement,
    PrecisionPoint,
    knee_of,
    seconds_to,
)
from ghostball.validation.results.measurement import MeasurementError, make_folder
from ghostball.validation.runs.time_steps import step_of
from ghostball.validation.scenes.library import select

LEGEND = (
    "Times are for the whole call of `simulate`: the shortest of all samples. A time is shown if "
    "all shorter steps are as accurate, at every phase of the step; not reached: no step in this "
    "run is that accurate. Least error: the error of the best step at its worst phase. Recommended "
    "step: the last one for which taking four times as many steps still halves the error at the "
    "worst phase; < before a step: it is the shortest one in this run, and shorter ones may be "
    "better."
)

NO_STEP = (
    "every step leads to wrong collisions, or to errors above "
    f"{format_length(USELESS_ERROR)} that shorter steps don't reduce"
)


def measure_steps(
    engines: Sequence[str] | None,
    scenes: Sequence[str] | None,
    repeats: int,
    out: Path | None,
    plot: Path | None,
    form: TextOrJson,
) -> ExitStatus:
    """Measure, print, write and draw the results, and return the exit status.

    The parameters are options of `ghostball engines`.

    Raises `MeasurementError` if a plot is asked for, but no named engine has a time step.
    """
    check_plot(plot)
    if out is not None:
        make_folder(out)
    named = tuple(engines or load_config().engines)
    # Checked before the run: a named engine that is unavailable raises an error here.
    stepless = [step_of(make_engine(spec)) is None for spec in named]
    if plot is not None and named and all(stepless):
        raise MeasurementError(NO_STEPS)
    with counting("measuring") as count:
        measured = measure_precision(
            select(scenes or DEFAULT_SCENES),
            named or PRECISION_ENGINES,
            rounds=repeats,
            progress=count,
        )
    if form is TextOrJson.JSON:
        typer.echo(measured.model_dump_json(by_alias=True, indent=1))
    console = tables(form)
    for table in _tables(measured):
        console.print(table)
    for line in (LEGEND, *_missing(measured)):
        console.print(line, markup=False, style="dim")
    for line in _recommended(measured.points):
        console.print(line, markup=False, soft_wrap=True)
    if out is not None:
        console.print(f"written: {measured.save(out)}", soft_wrap=True, markup=False)
    if plot is not None and measured.points:
        with style.drawing():
            style.save_one(draw_against_steps(measured), plot)
        console.print(f"drawn in {plot}", soft_wrap=True, markup=False)
    return ExitStatus.PASSED if measured.points else ExitStatus.NOT_JUDGED


def _recommended(points: Sequence[PrecisionPoint]) -> Iterator[str]:
    """Yield a line for each engine: its recommended time step, with its error and run time."""
    for engine in dict.fromkeys(one.engine for one in points if one.step is not None):
        mine = [one for one in points if one.engine == engine]
        scenes = list(dict.fromkeys(one.scene for one in mine))
        ladders = [[one for one in mine if one.scene == scene] for scene in scenes]
        knees = [knee for ladder in ladders if (knee := knee_of(ladder)) is not None]
        if not knees:
            yield f"{engine}: no recommended step: {NO_STEP}"
            continue
        steps = _range(sorted({one.step for one in knees if one.step is not None}))
        error = format_length(max(one.error_high for one in knees))
        most = format_time(max(one.call_seconds for one in knees))
        some = f", in {len(knees)} of {len(scenes)} scenes" if len(knees) < len(scenes) else ""
        finest = any(is_finest(knee, mine) for knee in knees)
        more = "; shorter ones, which were not run, may be better" * finest
        yield (
            f"{engine}: recommended step {steps}{some}: error at most {error}, {most} for a "
            f"shot{more}"
        )


def _range(steps: Sequence[float]) -> str:
    ends = dict.fromkeys(map(format_time, (steps[0], steps[-1])))
    return " to ".join(ends)


def _missing(measured: PrecisionMeasurement) -> Iterator[str]:
    yield from dict.fromkeys(f"{o.scene}, {o.engine}: left out: {o.why}" for o in measured.left_out)


def _tables(measured: PrecisionMeasurement) -> Iterator[Table]:
    """Yield a table for each scene: the run time that each engine needs for each accuracy."""
    reached = [f"to {format_length(target)}" for target in TARGETS]
    heads = ("engine", *reached, "least error (worst phase)", "recommended step")
    for scene in dict.fromkeys(point.scene for point in measured.points):
        points = [point for point in measured.points if point.scene == scene]
        rows = []
        for engine in dict.fromkeys(point.engine for point in points):
            mine = [point for point in points if point.engine == engine]
            failed = [o.step for o in measured.left_out if (o.scene, o.engine) == (scene, engine)]
            lost = [step for step in failed if step is not None]
            times = (seconds_to(target, mine, lost) for target in TARGETS)
            cells = ("not reached" if one is None else format_time(one) for one in times)
            rows.append((escape(engine), *cells, least_error(mine), knee_text(mine)))
        title = f"[bold]{escape(f'{scene} ({points[0].truth}): {points[0].title}')}[/]"
        table = table_of(heads, rows, right=heads[1:], title=title)
        table.title_justify = "left"
        yield table
