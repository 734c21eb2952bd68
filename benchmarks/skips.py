"""The skips of our engine, off and on: what each saves, and that it changes no bit of the answer.

`ROUNDS` alone may round otherwise, and by how much is shown.

Those that can't be switched off (`engine.running.skips.BUILT_IN`) aren't measured, and it says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from statistics import median
from typing import Literal

import numpy as np
from rich.console import Group, RenderableType

from benchmarks.measurements import Shown, table_of
from benchmarks.timing import run
from ghostball.engine.running.skips import BUILT_IN, Skip, explain_skips
from ghostball.model import Result, Scene
from ghostball.reports.style import format_time
from ghostball.validation.parallel.pool import Progress
from ghostball.validation.results.measurement import Record

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
    def table(self) -> RenderableType:
        """Each scene's skips, off and on; then, for each skip, what it came to."""
        heads = ("scene", "skip", "on", "off", "off / on", *COUNTERS, "answer")
        cells = (
            (
                row.scene,
                row.skip,
                format_time(row.seconds_on),
                format_time(row.seconds_off),
                f"{row.seconds_off / row.seconds_on:.2f}",
                *(f"{row.work_on[name]} → {row.work_off[name]}" for name in COUNTERS),
                ": ".join(filter(None, (row.equality, row.detail))),
            )
            for row in self.rows
        )
        return Group(table_of(heads, cells, left=("skip", "answer")), self._summary)

    @property
    def _summary(self) -> RenderableType:
        verdicts = ("same bits", "rounding", "differs")
        heads = ("skip", "used in", *verdicts, "off / on", "bounds, off / on", "it leaves out")
        cells = []
        for skip in Skip:
            rows = [row for row in self.rows if row.skip == skip]
            used = f"{len(rows)} of {len(self.unused)}"
            counts = [str(sum(row.equality == name for row in rows)) for name in verdicts]
            ratio = bounds = ""
            if rows:
                ratio = f"{median(row.seconds_off / row.seconds_on for row in rows):.2f}"
                on = sum(row.work_on["bounds"] for row in rows)
                bounds = f"{sum(row.work_off['bounds'] for row in rows) / on:.2f}" if on else ""
            if skip in BUILT_IN:
                used = "not measured"
            cells.append((skip, used, *counts, ratio, bounds, skip.leaves_out))
        return table_of(heads, cells, left=("it leaves out",))


def measure_skips(
    scenes: Sequence[Scene], *, rounds: int, progress: Progress[str] | None = None
) -> SkipsMeasurement:
    """Run every scene with each skip off and on that it uses and that can be off, interleaved.

    And compare the answers.
    """
    rows: list[SkipRow] = []
    unused: dict[str, dict[str, str]] = {}
    for done, scene in enumerate(scenes, 1):
        uses = explain_skips(scene)
        measured = [use.skip for use in uses if use.used and use.skip not in BUILT_IN]
        rows += _rows(scene, measured, rounds)
        unused[scene.name] = {
            use.skip: NOT_MEASURED if use.used else use.why
            for use in uses
            if use.skip not in measured
        }
        if progress is not None:
            progress(done, len(scenes), scene.name)
    return SkipsMeasurement(rounds=rounds, rows=tuple(rows), unused=unused)


def _rows(scene: Scene, skips: Sequence[Skip], rounds: int) -> list[SkipRow]:
    """Measure one scene: with all its skips on, and with each of them off."""
    kept = run(scene, record="events")
    answers = {skip: run(scene, record="events", no_skip=(skip,)) for skip in skips}
    if Skip.RECORDS in answers:
        # Its answer is that of a run nobody asked a record of: the log must not be in the way.
        answers[Skip.RECORDS] = replace(run(scene), events=kept.events)
    seconds: dict[Skip | None, list[float]] = {key: [] for key in (None, *skips)}
    work: dict[Skip | None, dict[str, int]] = {}
    for _ in range(rounds):
        for skip, taken in seconds.items():
            result = run(scene, no_skip=() if skip is None else (skip,))
            taken.append(result.wall_time)
            work[skip] = {name: result.work[name] for name in COUNTERS}
    rows = []
    for skip, off in answers.items():
        equality, detail = compare_answers(kept, off)
        if equality == "rounding" and skip not in ROUNDS:
            equality = "differs"
        rows.append(
            SkipRow(
                scene=scene.name,
                skip=skip,
                seconds_on=median(seconds[None]),
                seconds_off=median(seconds[skip]),
                work_on=work[None],
                work_off=work[skip],
                equality=equality,
                detail=detail,
            )
        )
    return rows


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
