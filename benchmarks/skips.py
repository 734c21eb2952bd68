"""The skips of our engine, off and on: what each saves, and that it changes no bit of the answer.

`ROUNDS` alone may round otherwise, and by how much is shown.

Those that can't be switched off (`engine.running.skips.BUILT_IN`) aren't measured, and it says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from statistics import median
from typing import Annotated, Literal, get_args

import numpy as np
import typer
from rich.console import Group, RenderableType

from benchmarks.frame import Repeats, benchmark, counted
from benchmarks.measurements import Shown, table_of
from benchmarks.scenes import run
from ghostball.engine.running.skips import BUILT_IN, Skip, explain_skips
from ghostball.model import Result, Scene
from ghostball.validation.results.measurement import Record
from ghostball.validation.runs.interleave import Sampler, Task, interleave
from ghostball.validation.scenes.gases import many_balls
from ghostball.validation.scenes.library import select

ROUNDING = 16.0
"""Roundings by which the first event that differs may do so, where another formula gives the same
root: those of the instant, and of the places over the fastest speed. What comes after depends on
what the scene makes of that."""

ROUNDS = frozenset({Skip.ADVANCEMENT})
"""Skips that are another formula for the same root, not work left out."""

COUNTERS = ("bounds", "advancement_steps", "cell_moves")
"""Work that skips save."""

NOT_MEASURED = "it can't be switched off, so that what it saves isn't measured"

Equality = Literal["same bits", "rounding", "differs"]
EQUALITIES: tuple[Equality, ...] = get_args(Equality)


class SkipRow(Record):
    """One skip in one scene, off and on.

    `seconds_on` and `seconds_off` are medians of the kernel's time [s], `work_on` and `work_off`
    counters, by name; `detail` says where the answers part.
    """

    scene: str
    skip: str
    seconds_on: float
    seconds_off: float
    work_on: dict[str, int]
    work_off: dict[str, int]
    equality: Equality
    detail: str = ""


class SkipsMeasurement(Shown):
    """What `python -m benchmarks skips` measured; `unused` has why a skip has no row, by scene."""

    kind: Literal["skips"] = "skips"
    rows: tuple[SkipRow, ...]
    unused: dict[str, dict[str, str]]

    @property
    def defects(self) -> tuple[SkipRow, ...]:
        """Skips that change an answer."""
        return tuple(row for row in self.rows if row.equality == "differs")

    @property
    def failure(self) -> str:
        """How many answers a skip changes."""
        count = len(self.defects)
        return f"Answers that a skip changes: {count}; see above" if count else ""

    @property
    def table(self) -> RenderableType:
        """A row for each skip over all scenes; then each answer that a skip changes."""
        heads = ("skip", "used in", *EQUALITIES, "off / on", "bounds, off / on", "it leaves out")
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
        return Group(table_of(heads, cells, left=("it leaves out",)), *parted)


Scenes = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="SCENE|TAG",
        help="As of `validate` (default: all that are shipped, and two of 256 balls).",
    ),
]


@benchmark
def skips(scenes: Scenes = None, repeats: Repeats = 5) -> SkipsMeasurement:
    """Run scenes with each skip off and on; exit with 1 where one changes an answer."""
    return measure_skips(select(scenes) if scenes else [*select(), *many_balls()], rounds=repeats)


def measure_skips(scenes: Sequence[Scene], *, rounds: int) -> SkipsMeasurement:
    """Run every scene with each skip off and on that it uses and that can be off, interleaved.

    And compare the answers.
    """
    rows: list[SkipRow] = []
    unused: dict[str, dict[str, str]] = {}
    for scene in counted(scenes, lambda scene: scene.name):
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
    """Measure one scene: with all its skips on, and with each of them off."""
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
            # Its answer is that of a run without a record: the log must not be in the way.
            answer = replace(run(scene), events=kept.events)
        equality, detail = compare_answers(kept, answer)
        if equality == "rounding" and skip not in ROUNDS:
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
    """Return the measurement of a scene without some skips, whose kernel is compiled beforehand.

    Each sample begins with a run that isn't timed. The run before it may have used the other
    kernel: then caches hold nothing of this one, and the first run is slower than the next.
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
    """Return whether two runs of a scene have the same answer, and where they part.

    `on`, `off`: of our engine, with events.

    Returns that, and a detail: "rounding" where the first event that differs does so by up to
    `ROUNDING` roundings, and in nothing but its instant.
    """
    if on.events is None or off.events is None:
        raise ValueError("both runs must have kept their events")
    if on.events.tobytes() == off.events.tobytes():
        same = all(
            np.array_equal(a, b, equal_nan=True)
            for a, b in zip(on.final_state, off.final_state, strict=True)
        )
        if same and on.status is off.status and on.rest_time == off.rest_time:
            return "same bits", ""
        return "differs", "the same events, but another state at the end"
    count = min(len(on.events), len(off.events))
    a, b = on.events[:count], off.events[:count]
    unlike = np.flatnonzero(a != b)
    if len(unlike) == 0:
        return "differs", f"{len(on.events)} events and {len(off.events)}"
    first = unlike[0]
    what = ["kind", "a", "b"]
    rounding = np.spacing(a["t"][first]) + _time_rounding(on.scene)
    roundings = abs(a["t"][first] - b["t"][first]) / rounding
    said = f"event {first + 1} of {len(on.events)}: {roundings:.2g} roundings"
    if a[what][first] != b[what][first]:
        return "differs", f"event {first + 1} of {len(on.events)}: another one"
    return ("rounding" if roundings <= ROUNDING else "differs"), said


def _time_rounding(scene: Scene) -> float:
    """Return how long the fastest ball takes over the rounding of the largest coordinate [s]."""
    speeds = np.linalg.norm(scene.velocities, axis=1)
    turning = scene.radii * np.linalg.norm(scene.angular_velocities, axis=1)
    fastest = float(max(speeds.max(), turning.max()))
    largest = float(np.spacing(np.abs(scene.positions).max() + scene.radii.max()))
    return largest / fastest if fastest > 0.0 else 0.0
