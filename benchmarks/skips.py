"""Measure what the engine's skips save, and check that no skip changes a bit of a result.

A skip is work that the engine leaves out where it can't affect the result. Each skip is switched
off and on. The skips in `ROUNDING_SKIPS` may change a result by rounding; the change is shown.
Skips that can't be switched off (`engine.running.skips.BUILT_IN`) aren't measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from statistics import median
from typing import Annotated, Literal, get_args

import numpy as np
import typer
from rich.console import Group, RenderableType

from benchmarks.commands import Repeats, benchmark, with_progress
from benchmarks.measurements import BenchmarkMeasurement, table_of
from benchmarks.scenes import run
from ghostball.engine.running.skips import BUILT_IN, Skip, explain_skips
from ghostball.model import Result, Scene
from ghostball.validation.results.measurement import Record
from ghostball.validation.runs.interleave import Sampler, Task, interleave
from ghostball.validation.scenes.gases import many_balls
from ghostball.validation.scenes.library import select

ROUNDING = 16.0
"""Largest time difference of the first different event, in roundings, for `ROUNDING_SKIPS`.

One rounding is the rounding of the time plus the rounding of a coordinate over the largest speed.
Later events are not compared, because the scene amplifies the first difference."""

ROUNDING_SKIPS = frozenset({Skip.ADVANCEMENT})
"""Skips that use another formula for the same root, so that rounding may differ."""

COUNTERS = ("bounds", "advancement_steps", "cell_moves")
"""Work counters that skips reduce."""

NOT_MEASURED = "not measured, because it can't be switched off"

Equality = Literal["same bits", "rounding", "differs"]
EQUALITIES: tuple[Equality, ...] = get_args(Equality)


class SkipRow(Record):
    """One skip in one scene, off and on.

    `seconds_on`, `seconds_off` [s]: median time of the kernel.
    `work_on`, `work_off`: work counters, by name.
    `equality`: how the two results compare.
    `detail`: the first difference between the results, or "".
    """

    scene: str
    skip: str
    seconds_on: float
    seconds_off: float
    work_on: dict[str, int]
    work_off: dict[str, int]
    equality: Equality
    detail: str = ""


class SkipsMeasurement(BenchmarkMeasurement):
    """Measurement of `python -m benchmarks skips`.

    `unused`: by scene and skip, why the skip has no row.
    """

    kind: Literal["skips"] = "skips"
    rows: tuple[SkipRow, ...]
    unused: dict[str, dict[str, str]]

    @property
    def defects(self) -> tuple[SkipRow, ...]:
        """Rows of the skips that change a result."""
        return tuple(row for row in self.rows if row.equality == "differs")

    @property
    def failure(self) -> str:
        """Message with the number of results that a skip changes, or ""."""
        count = len(self.defects)
        return f"Results that a skip changes: {count}; see above" if count else ""

    @property
    def table(self) -> RenderableType:
        """Table with a row for each skip over all scenes, and a line for each changed result."""
        heads = ("skip", "used in", *EQUALITIES, "off / on", "bounds, off / on", "skipped work")
        cells = []
        for skip in Skip:
            rows = [row for row in self.rows if row.skip == skip]
            used = "not measured" if skip in BUILT_IN else f"{len(rows)} of {len(self.unused)}"
            counts = [str(sum(row.equality == name for row in rows)) for name in EQUALITIES]
            ratio = bounds = ""
            if rows:
                ratio = f"{median(row.seconds_off / row.seconds_on for row in rows):.2f}"
                on = sum(row.work_on["bounds"] for row in rows)
                bounds = f"{sum(row.work_off['bounds'] for row in rows) / on:.2f}" if on else ""
            cells.append((skip, used, *counts, ratio, bounds, skip.leaves_out))
        parted = [
            f"{row.scene}, {row.skip}: {row.equality}: {row.detail}"
            for row in self.rows
            if row.equality != EQUALITIES[0]
        ]
        return Group(table_of(heads, cells, left=("skipped work",)), *parted)


Scenes = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="SCENE|TAG",
        help="Scenes, as for `validate` (default: all shipped scenes, and two with 256 balls).",
    ),
]


@benchmark
def skips(scenes: Scenes = None, repeats: Repeats = 5) -> SkipsMeasurement:
    """Run scenes with each skip off and on; exit status 1 if a skip changes a result."""
    return measure_skips(select(scenes) if scenes else [*select(), *many_balls()], rounds=repeats)


def measure_skips(scenes: Sequence[Scene], *, rounds: int) -> SkipsMeasurement:
    """Run every scene with each skip off and on, alternately, and compare the results.

    Only skips that the scene uses and that can be switched off are measured.
    """
    rows: list[SkipRow] = []
    unused: dict[str, dict[str, str]] = {}
    for scene in with_progress(scenes, lambda scene: scene.name):
        uses = explain_skips(scene)
        measured = [use.skip for use in uses if use.used and use.skip not in BUILT_IN]
        rows += _rows(scene, measured, rounds)
        unused[scene.name] = {
            use.skip: NOT_MEASURED if use.used else use.why
            for use in uses
            if use.skip not in measured
        }
    return SkipsMeasurement(rounds=rounds, rows=tuple(rows), unused=unused)


def _rows(scene: Scene, skips: Sequence[Skip], rounds: int) -> list[SkipRow]:
    """Return the rows of one scene: with all skips on, and with each skip off."""
    kept = run(scene, record="events")
    found = interleave([_task("", scene), *(_task(skip, scene, skip) for skip in skips)], rounds)
    seconds = {name: median(values["seconds"]) for name, values in found.items()}
    work = {
        name: {counter: int(values[counter][-1]) for counter in COUNTERS}
        for name, values in found.items()
    }
    rows = []
    for skip in skips:
        answer = run(scene, record="events", no_skip=(skip,))
        if skip == Skip.RECORDS:
            # This skip leaves out the log, so the result is compared with a run without a log.
            answer = replace(run(scene), events=kept.events)
        equality, detail = compare_answers(kept, answer)
        if equality == "rounding" and skip not in ROUNDING_SKIPS:
            equality = "differs"
        rows.append(
            SkipRow(
                scene=scene.name,
                skip=skip,
                seconds_on=seconds[""],
                seconds_off=seconds[skip],
                work_on=work[""],
                work_off=work[skip],
                equality=equality,
                detail=detail,
            )
        )
    return rows


def _task(name: str, scene: Scene, *off: Skip) -> Task:
    """Return the timing of a scene, with some skips off, as a task that compiles beforehand.

    Each sample starts with a run that isn't timed. The run before it may have used the other
    kernel: then no cache holds this kernel, and its first run is slower than the next.
    """

    def sample() -> dict[str, float]:
        run(scene, no_skip=off)
        result = run(scene, no_skip=off)
        return {"seconds": result.wall_time, **{name: result.work[name] for name in COUNTERS}}

    def prepare() -> Sampler:
        sample()
        return sample

    return Task(name, prepare)


def compare_answers(on: Result, off: Result) -> tuple[Equality, str]:
    """Return how two results of a scene compare, and their first difference as text.

    `on`, `off`: results of Ghostball's engine, with events.

    The comparison is "rounding" if the first different event differs only in its time, by at most
    `ROUNDING` roundings.

    Raises `ValueError` if a result has no events.
    """
    if on.events is None or off.events is None:
        raise ValueError("both runs must have recorded their events")
    if on.events.tobytes() == off.events.tobytes():
        same = all(
            np.array_equal(a, b, equal_nan=True)
            for a, b in zip(on.final_state, off.final_state, strict=True)
        )
        if same and on.status is off.status and on.rest_time == off.rest_time:
            return "same bits", ""
        return "differs", "the same events, but a different final state"
    count = min(len(on.events), len(off.events))
    a, b = on.events[:count], off.events[:count]
    unlike = np.flatnonzero(a != b)
    if len(unlike) == 0:
        return "differs", f"{len(on.events)} events with the skip, {len(off.events)} without it"
    first = unlike[0]
    what = ["kind", "a", "b"]
    rounding = np.spacing(a["t"][first]) + _time_rounding(on.scene)
    roundings = abs(a["t"][first] - b["t"][first]) / rounding
    said = f"event {first + 1} of {len(on.events)}: {roundings:.2g} roundings"
    if a[what][first] != b[what][first]:
        return "differs", f"event {first + 1} of {len(on.events)}: a different event"
    return ("rounding" if roundings <= ROUNDING else "differs"), said


def _time_rounding(scene: Scene) -> float:
    """Return the rounding of the largest coordinate divided by the largest speed [s]."""
    speeds = np.linalg.norm(scene.velocities, axis=1)
    turning = scene.radii * np.linalg.norm(scene.angular_velocities, axis=1)
    fastest = float(max(speeds.max(), turning.max()))
    largest = float(np.spacing(np.abs(scene.positions).max() + scene.radii.max()))
    return largest / fastest if fastest > 0.0 else 0.0
