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
    """

    scene: str
    label: str
    kind: AccuracyKind | None
    error: float | None = None
    seconds: float | None = None
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
        """Table with a row for each engine of this run: counts by class, median error and time."""
        return table_of(HEADS, self.rows(), title="The board")

    def rows(self) -> Iterator[Sequence[str]]:
        """Yield the cells of a row for each engine of this run; see `HEADS`."""
        for label in self.labels:
            if label in self.earlier:
                continue
            cases = self.of(label).values()
            counts = Counter(one.kind for one in cases)
            error, is_exact = median_error((one.error, one.kind) for one in cases if one.kind)
            times = [one.seconds for one in cases if one.kind and one.seconds is not None]
            yield (
                label,
                *(str(counts[kind]) for kind in (*CLASSES, None)),
                median_text(error, is_exact=is_exact),
                format_time(median(times) if times else None),
            )


HEADS: Final = (
    "engine",
    *(look.short for look in CLASSES.values()),
    "no class",
    "median error",
    "median time",
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
