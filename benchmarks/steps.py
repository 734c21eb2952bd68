"""What an engine's own step buys: each column of the board over a ladder of steps.

Cost is counted, in steps in a second of play: so the picture is the same on every machine.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from functools import cache
from itertools import product
from typing import Final, Literal

from rich.console import RenderableType

from benchmarks.measurements import Shown, table_of
from ghostball.model import Scene
from ghostball.reference_adapters import EngineUnavailableError, make_engine, parse_spec
from ghostball.reference_adapters.registry import spec_of
from ghostball.reports.board import value_text
from ghostball.validation.board.asking import MOST, asked, board_scene
from ghostball.validation.board.board import ROWS
from ghostball.validation.board.cell import Cell, angle_of, cell_of
from ghostball.validation.board.column import ACCURACY, LIKENESS, QUESTIONS, Column, scene_path
from ghostball.validation.checks.criteria import criteria_beside
from ghostball.validation.parallel.pool import Progress, run_tasks
from ghostball.validation.precision.ladder import part_of_step
from ghostball.validation.precision.phases import begun_earlier
from ghostball.validation.precision.points import knee_step
from ghostball.validation.results.measurement import Record
from ghostball.validation.results.records import ACCURACY_KINDS, CLOSED_FORM, CaseRecord
from ghostball.validation.runs.steps import step_setting
from ghostball.validation.suite.case import run_case, truth_or_failure
from ghostball.validation.suite.judge import Case, TruthFailure
from ghostball.validation.truth.scene_truth import Truth

STEPS: Final = tuple(60 * 2**level for level in range(7))
"""Steps in a second of play: from a frame of a game on, each twice the one before."""

MOST_STEPS: Final = 40_000
"""A shot that would take more steps is left out: 20 s of a gas at 3840 steps/s."""

PHASES: Final = 4
"""Where in a step a shot begins, where its truth is a closed form: the worst of so many counts."""

TIME_LIMIT: Final = 300.0
"""Time after which a cell is given up [s]."""

COLUMNS: Final = {
    name: one.model_copy(update={"scenes": one.scenes[:1]}) if name == "cut" else one
    for name, one in QUESTIONS.items()
    if one.metric not in (LIKENESS, "wall_time")
}
"""Those that a step can decide; the phases of *cut* are of 1 ms, here they are of each step."""

WRONG: Final = ("another shot", "broken", "failed", "none")
"""Kinds of a cell that has no error."""


class StepPoint(Record):
    """A column's number of an engine with one step.

    `steps` [1/s]: in a second of play.
    `error`: in the column's unit: how far off, what share of the energy, the fastest that comes out
        inelastic, by how many degrees the widest pocketed shot is short; None where it has none.
    `kind`, `note`: of the cell.
    """

    column: str
    engine: str
    label: str
    steps: int
    kind: str
    error: float | None
    note: str = ""


class StepsMeasurement(Shown):
    """What `python -m benchmarks steps` measured; `absent`: engines that aren't here, and why."""

    kind: Literal["steps"] = "steps"
    points: tuple[StepPoint, ...]
    absent: dict[str, str]

    def of(self, column: str) -> dict[str, list[StepPoint]]:
        """Return the points of a column by their engine, the coarsest step first."""
        found: dict[str, list[StepPoint]] = {}
        for one in sorted(self.points, key=lambda point: point.steps):
            if one.column == column:
                found.setdefault(one.engine, []).append(one)
        return {row: found[row] for row in ROWS if row in found}

    @property
    def table(self) -> RenderableType:
        """The knee of each engine in each column."""
        rows = {row: [row] for row in dict.fromkeys(one.engine for one in self.points)}
        for name, column in COLUMNS.items():
            found = self.of(name)
            for row, cells in rows.items():
                point = knee(column, found.get(row, ()))
                cells.append("–" if point is None else f"1/{point.steps} s")
        return table_of(("engine", *COLUMNS), rows.values(), title="Which step is worth it")


def knee(column: Column, points: Sequence[StepPoint]) -> StepPoint | None:
    """Return the point of the step that is worth it; None where no step makes it right.

    A step that is good by luck doesn't count: its error is the largest of it and all finer ones.
    What is right by the column's threshold can't be mended: all such errors are the same.

    `points`: of one engine, the coarsest step first.
    """
    errors: dict[float, float] = {}
    largest = column.good or 0.0
    for one in reversed(points):
        if one.error is None:
            break
        largest = max(largest, one.error)
        errors[1.0 / one.steps] = largest
    step = knee_step(errors)
    worth = next((one for one in points if step is not None and 1.0 / one.steps == step), None)
    return None if worth is None or worth.kind == "bad" else worth


def error_text(column: Column, point: StepPoint) -> str:
    """Return what an error is called: as in the board's cells."""
    if point.kind in WRONG or point.error is None:
        words = {"another shot": "other shot", "none": "lacks it"}
        return words.get(point.kind, point.kind)
    if column.pick == "widest":
        return f"{point.error:.3g}° short" if point.error else "all"
    cell = Cell.model_validate(
        {"row": point.engine, "column": column.id, "kind": point.kind, "value": point.error}
    )
    return value_text(column.model_copy(update={"laws": {}}), cell)


def measure_steps(
    rows: Sequence[str] = (), jobs: int = 1, *, progress: Progress[str] | None = None
) -> StepsMeasurement:
    """Measure every column over the ladder of every engine of the board that has a step."""
    present, absent = [], {}
    for row in rows or [row for row in ROWS if ":" not in row]:
        try:
            if step_setting(make_engine(row)) is not None:
                present.append(row)
        except EngineUnavailableError as error:
            absent[row] = str(error)
    tasks = list(product(COLUMNS, present, STEPS))
    points = []
    with closing(run_tasks(tasks, jobs, _point, TIME_LIMIT)) as answers:
        for count, done in enumerate(answers, start=1):
            found = done.or_else(_crashed)
            points += [] if found is None else [found]
            if progress is not None:
                progress(count, len(tasks), " ".join(map(str, done.task)))
    order = {task: k for k, task in enumerate(tasks)}
    points.sort(key=lambda one: order[one.column, one.engine, one.steps])
    return StepsMeasurement(rounds=PHASES, points=tuple(points), absent=absent)


def stepped(row: str, steps: int) -> str:
    """Return an engine of the board with another step, and no limit in its way."""
    engine = make_engine(row)
    fields = type(engine.settings).model_fields
    name, said = parse_spec(row)
    given = {step_setting(engine): 1.0 / steps} | {k: v for k, v in MOST.items() if k in fields}
    return spec_of(name, said | {str(key): value for key, value in given.items()})


def _point(task: tuple[str, str, int]) -> StepPoint | None:
    """Return what a column says of an engine with a step; None where that takes too many."""
    name, row, steps = task
    column = COLUMNS[name]
    label = stepped(row, steps)
    played = asked(column, label)
    truths = [_truth(file, scene) for file, scene, _ in played]
    durations = (_duration(one[1], truth) for one, truth in zip(played, truths, strict=True))
    if any(duration * steps > MOST_STEPS for duration in durations):
        return None
    cells = [cell_of(column, row, cases) for cases in _phases(column, steps, played, truths)]
    worst = max(cells, key=_badness)
    return StepPoint(
        column=name,
        engine=row,
        label=label,
        steps=steps,
        kind=worst.kind,
        error=_error(column, worst),
        note=worst.note if worst.kind in WRONG else "",
    )


def _phases(
    column: Column,
    steps: int,
    played: Sequence[tuple[str, Scene, str]],
    truths: Sequence[Truth | TruthFailure],
) -> Iterator[list[CaseRecord]]:
    known = [one.kind == CLOSED_FORM for one in truths if isinstance(one, Truth)]
    phases = PHASES if column.metric == ACCURACY and column.pick == "worst" and all(known) else 1
    for turn in range(phases if played else 1):
        cases = []
        for (_, scene, label), truth in zip(played, truths, strict=True):
            start = begun_earlier(scene, part_of_step(turn) / steps) or scene
            metrics = (column.metric,) if column.metric != ACCURACY else ("accuracy",)
            record, _ = run_case(Case(start, label, truth, metrics=metrics))
            cases.append(replace(record, definition=scene.model_dump(mode="json", by_alias=True)))
        yield cases


@cache
def _truth_of(file: str, text: str) -> Truth | TruthFailure:
    scene = Scene.model_validate_json(text)
    return truth_or_failure(scene, criteria_beside(scene_path(file)))


def _truth(file: str, scene: Scene) -> Truth | TruthFailure:
    return _truth_of(file, scene.model_dump_json(by_alias=True))


def _duration(scene: Scene, truth: Truth | TruthFailure) -> float:
    rest = truth.rest_time if isinstance(truth, Truth) else None
    return rest or scene.t_max or 0.0


def _badness(cell: Cell) -> tuple[int, float]:
    kinds = (*ACCURACY_KINDS, "failed")
    return kinds.index(cell.kind) if cell.kind in kinds else 0, cell.value or 0.0


def _error(column: Column, cell: Cell) -> float | None:
    if cell.kind in WRONG:
        return None
    if column.pick == "widest":
        return round(angle_of(board_scene(column.scenes[-1])) - (cell.value or 0.0), 3)
    return cell.value


def _crashed(task: tuple[str, str, int], why: str) -> StepPoint:
    name, row, steps = task
    return StepPoint(
        column=name, engine=row, label=row, steps=steps, kind="failed", error=None, note=why
    )
