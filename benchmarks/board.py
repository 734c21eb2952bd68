"""The committed board: how right and how fast each engine is in each scene with the tag `board`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import median
from typing import Annotated, Final, Literal

import typer
from pydantic import Field
from rich.console import RenderableType

from benchmarks.frame import benchmark, counted
from benchmarks.measurements import Shown, committed, table_of
from ghostball.reports.accuracy import CLASSES
from ghostball.reports.style import format_length, format_time
from ghostball.validation.results.measurement import MeasurementError, Record
from ghostball.validation.results.records import AccuracyKind
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import BOARD, select


class BoardCase(Record):
    """One scene on one engine with its settings.

    `kind`, `error` [m]: the accuracy class and the rest error. Each is None if the case has none;
        `note` then says why.
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
        """The error, or the class, and the run time."""
        if self.kind is None:
            return "–"
        shown = CLASSES[self.kind].short
        if self.kind != "exact" and self.error is not None:
            shown = format_length(self.error)
        return shown if self.seconds is None else f"{shown}, {format_time(self.seconds)}"


class BoardMeasurement(Shown):
    """What a run of `ghostball validate board` found, and earlier ones of other engines.

    `earlier`: where and when the cases of a label were measured, if not by this run.
    """

    kind: Literal["board"] = "board"
    cases: tuple[BoardCase, ...]
    earlier: dict[str, str] = Field(default_factory=dict)

    @property
    def labels(self) -> tuple[str, ...]:
        """Engines with their settings."""
        return tuple(dict.fromkeys(one.label for one in self.cases))

    def of(self, label: str) -> dict[str, BoardCase]:
        """Return the cases of an engine by their scenes."""
        return {one.scene: one for one in self.cases if one.label == label}

    @property
    def table(self) -> RenderableType:
        """Each engine that this run measured: its scenes by class, typical error and time."""
        return table_of(HEADS, self.rows(), title="The board")

    def rows(self) -> Iterator[Sequence[str]]:
        """Yield what `HEADS` name of each engine that this run measured."""
        for label in self.labels:
            if label in self.earlier:
                continue
            cases = self.of(label).values()
            counts = Counter(one.kind for one in cases)
            errors = [one.error for one in cases if one.kind and one.error is not None]
            times = [one.seconds for one in cases if one.kind and one.seconds is not None]
            yield (
                label,
                *(str(counts[kind]) for kind in (*CLASSES, None)),
                format_length(median(errors) if errors else None),
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
    """Gather how right and how fast each engine is on the board, for the documentation."""
    return board_of(Results.open(results))


def board_of(results: Results) -> BoardMeasurement:
    """Return what a results folder holds of the board, and what is committed of other engines.

    Raises `MeasurementError` if a scene of the board is missing.
    """
    scenes = [scene.name for scene in select([BOARD])]
    if missing := [name for name in scenes if name not in results.scene_names]:
        raise MeasurementError(
            f"{results.path}: it must hold every scene of the board, but has no {missing[0]!r}. "
            "Run `ghostball validate board` into it"
        )
    cases = []
    for label in counted(results.labels, str):
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
"""What is kept of where and with what the run was made."""
