"""The committed board: error and run time of each engine in each scene with the tag `board`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import median
from typing import Annotated, Final, Literal

import typer
from pydantic import Field
from rich.console import RenderableType

from benchmarks.commands import benchmark, with_progress
from benchmarks.measurements import BenchmarkMeasurement, committed, table_of
from ghostball.reports.accuracy import CLASSES, median_error, median_text
from ghostball.reports.style import format_length, format_time
from ghostball.validation.results.measurement import MeasurementError, Record
from ghostball.validation.results.records import AccuracyKind
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import BOARD, select


class BoardCase(Record):
    """Result of one scene on one engine.

    `label`: the engine with its settings.
    `kind`: accuracy class; None if there is none, for the reason in `note`.
    `error` [m]: rest position error, or None.
    `seconds` [s]: run time; None if it was not measured.
    `engine_seconds` [s]: the part of it in the engine's own steps; None if it was not measured.
    """

    scene: str
    label: str
    kind: AccuracyKind | None
    error: float | None = None
    seconds: float | None = None
    engine_seconds: float | None = None
    note: str = ""

    @property
    def text(self) -> str:
        """Text with the error, or the accuracy class, and the run time."""
        if self.kind is None:
            return "–"
        shown = CLASSES[self.kind].short
        if self.kind != "exact" and self.error is not None:
            shown = format_length(self.error)
        return shown if self.seconds is None else f"{shown}, {format_time(self.seconds)}"


class BoardMeasurement(BenchmarkMeasurement):
    """Results of a run of `ghostball validate board`, and earlier results of other engines.

    `earlier`: machine and date of the results that are not from this run, by label.
    """

    kind: Literal["board"] = "board"
    cases: tuple[BoardCase, ...]
    earlier: dict[str, str] = Field(default_factory=dict)

    @property
    def labels(self) -> tuple[str, ...]:
        """Engines with their settings."""
        return tuple(dict.fromkeys(one.label for one in self.cases))

    def of(self, label: str) -> dict[str, BoardCase]:
        """Return the cases of an engine, by scene."""
        return {one.scene: one for one in self.cases if one.label == label}

    @property
    def table(self) -> RenderableType:
        """Table with a row for each engine of this run: counts by class, median error and times."""
        rows = ((" and ".join(labels), *cells) for labels, cells in self.rows())
        return table_of(HEADS, rows, title="The board")

    def rows(self) -> Iterator[tuple[Sequence[str], Sequence[str]]]:
        """Yield the engines of this run, and the cells of their row; see `HEADS`.

        Engines with the same counts and the same median error share a row, which has the times of
        each of them, in the order of their names.
        """
        rows: dict[tuple[str, ...], list[str]] = {}
        for label in self.labels:
            if label not in self.earlier:
                rows.setdefault(self._counts_and_error(label), []).append(label)
        for numbers, labels in rows.items():
            graded = [[one for one in self.of(label).values() if one.kind] for label in labels]
            whole = [_median_time([one.seconds for one in cases]) for cases in graded]
            inside = [_median_time([one.engine_seconds for one in cases]) for cases in graded]
            yield labels, (*numbers, ", ".join(whole), ", ".join(inside))

    def _counts_and_error(self, label: str) -> tuple[str, ...]:
        cases = self.of(label).values()
        counts = Counter(one.kind for one in cases)
        error, is_exact = median_error((one.error, one.kind) for one in cases if one.kind)
        found = (str(counts[kind]) for kind in (*CLASSES, None))
        return (*found, median_text(error, is_exact=is_exact))


def _median_time(times: Sequence[float | None]) -> str:
    known = [one for one in times if one is not None]
    return format_time(median(known) if known else None)


HEADS: Final = (
    "engine",
    *(look.short for look in CLASSES.values()),
    "no class",
    "median error",
    "median time",
    "in the engine's own steps",
)


@benchmark
def board(
    results: Annotated[
        Path, typer.Argument(metavar="DIR", help="Results of `ghostball validate board`.")
    ],
) -> BoardMeasurement:
    """Collect error and run time of each engine on the board, for the documentation."""
    return board_of(Results.open(results))


def board_of(results: Results) -> BoardMeasurement:
    """Return the board from a results folder, and committed results of all other engines.

    Raises `MeasurementError` if a scene of the board is missing.
    """
    scenes = [scene.name for scene in select([BOARD])]
    if missing := [name for name in scenes if name not in results.scene_names]:
        raise MeasurementError(
            f"{results.path}: it must hold every scene of the board, but has no {missing[0]!r}. "
            "Run `ghostball validate board` into it"
        )
    cases = []
    for label in with_progress(results.labels, str):
        for scene in scenes:
            case = results.case(scene, label)
            if case is not None:
                found = case.accuracy
                cases.append(
                    BoardCase(
                        scene=scene,
                        label=label,
                        kind=None if found is None else found.kind,
                        error=None if found is None else found.error,
                        seconds=case.wall_time,
                        engine_seconds=case.engine_time,
                        note=case.reason,
                    )
                )
    stored = committed(BoardMeasurement)
    earlier: dict[str, str] = {}
    if stored is not None:
        kept = [one for one in stored.cases if one.label not in results.labels]
        earlier = {one.label: stored.earlier.get(one.label, stored.where) for one in kept}
        cases += kept
    environment = {key: one for key, one in results.environment.items() if key in ENVIRONMENT}
    return BoardMeasurement(environment=environment, cases=tuple(cases), earlier=earlier)


ENVIRONMENT: Final = ("cpu", "cores", "os", "python", "versions", "git", "date")
"""Keys of the environment of the run that are stored."""
