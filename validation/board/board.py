"""The board: its columns' scenes run by the suite, its cells made of what that stored.

A column beside what is right is what the suite keeps of real tables.

>>> from ghostball.validation.board.board import run_board
>>> board, outcome = run_board(["ghostball", "mujoco"], Path("out/board"))
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Final, Literal, Self

from pydantic import BaseModel, ValidationError, model_validator

from ghostball.model import GhostballError, Scene
from ghostball.model.text_files import read_text
from ghostball.reference_adapters.registry import EngineUnavailableError, make_engine
from ghostball.validation.board.asking import asked
from ghostball.validation.board.cell import Cell, cell_of, cell_of_likeness, law_of
from ghostball.validation.board.column import (
    COLUMNS,
    LIKENESS,
    QUESTIONS,
    Column,
    scene_path,
)
from ghostball.validation.checks.criteria import Criteria, criteria_beside
from ghostball.validation.measured.likeness import Likeness
from ghostball.validation.parallel.pool import Progress
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.fields import EnvironmentValues
from ghostball.validation.results.files import (
    BOARD,
    cannot_write,
    describe_validation_error,
    write_whole,
)
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.results.store import Pair, Results, has_results
from ghostball.validation.suite.real_tables import measure_likenesses
from ghostball.validation.suite.suite import Outcome, run_suite

ROWS: Final = (
    "ghostball",
    "pymunk",
    "pymunk:config=naive",
    "pybullet",
    "pybullet:config=naive",
    "mujoco",
    "mujoco:config=naive",
    "box2d",
    "box2d:bullet=no",
    "box2d:config=naive",
    "box2d3",
    "box2d3:config=naive",
    "rapier",
    "rapier:config=naive",
    "dart",
    "dart:cloth=own",
    "dart:config=naive",
    "physx",
    "physx:cloth=own",
    "physx:solver=tgs",
    "physx:config=naive",
    "pooltool",
    "billiards",
    "planck",
    "planck:bullet=no",
    "planck:config=naive",
    "matter-js",
    "matter-js:config=naive",
    "cannon-es",
    "cannon-es:config=naive",
    "paper-discrete",
    "paper-continuous",
)
"""Engines and configurations that the board has, unless others are asked for."""

CASE_LIMIT: Final = 120.0
"""Time after which a shot of the board is given up [s], by default."""

CellKey = tuple[str, str]
"""A row and a column's id."""


class Board(BaseModel, frozen=True, extra="forbid", allow_inf_nan=False):
    """The board as it is kept and shown.

    `environment`: where, when and with which versions the last of its cells was measured.
    `earlier`: those of cells that say so, for they were measured elsewhere or by other code.
    `absent`: rows that can't run here, and why.
    """

    version: Literal[3] = 3
    environment: EnvironmentValues
    earlier: tuple[EnvironmentValues, ...] = ()
    columns: tuple[Column, ...]
    cells: tuple[Cell, ...]
    absent: Mapping[str, str] = {}

    @model_validator(mode="after")
    def _each_somewhere(self) -> Self:
        for one in self.cells:
            if one.earlier is not None and one.earlier >= len(self.earlier):
                raise ValueError(
                    f"cell {one.row!r}, {one.column!r}: `earlier` must be below "
                    f"{len(self.earlier)}, the number of earlier environments, got {one.earlier}"
                )
        return self

    def environment_of(self, cell: Cell) -> EnvironmentValues:
        """Return where, when and with which versions a cell was measured."""
        return self.environment if cell.earlier is None else self.earlier[cell.earlier]

    @property
    def rows(self) -> tuple[str, ...]:
        """Engines with their settings, those that are shipped first."""
        found = dict.fromkeys(one.row for one in self.cells)
        return (*(row for row in ROWS if row in found), *(row for row in found if row not in ROWS))

    def cell(self, row: str, column: str) -> Cell | None:
        """Return a cell; None where it wasn't measured."""
        return next((one for one in self.cells if (one.row, one.column) == (row, column)), None)

    def sorted_rows(self, column: str) -> tuple[str, ...]:
        """Return the rows in order of a column, the least first, none last."""

        def size(row: str) -> tuple[bool, float]:
            cell = self.cell(row, column)
            size = None if cell is None else cell.size
            return size is None, size or 0.0

        return tuple(sorted(self.rows, key=size))


def command(cell: Cell) -> str:
    """Return the command that measures a cell again."""
    return f"ghostball leaderboard --only -e {cell.row} --column {cell.column} --rerun"


@dataclass(frozen=True)
class _Plan:
    """What cells are made of: the cases of each, and what the suite runs.

    `rows`: those that can run here.
    `beside`: the columns that are about real tables.
    """

    absent: Mapping[str, str]
    rows: tuple[str, ...]
    beside: tuple[Column, ...]
    pairs_of: Mapping[CellKey, tuple[Pair, ...]]
    scenes: Mapping[str, Scene]
    criteria: Mapping[str, Criteria]

    @property
    def pairs(self) -> frozenset[Pair]:
        return frozenset(pair for pairs in self.pairs_of.values() for pair in pairs)


def run_board(
    rows: Sequence[str],
    folder: Path,
    *,
    columns: Iterable[Column] = tuple(QUESTIONS.values()),
    jobs: int = 1,
    rerun: bool = False,
    time_limit: float = CASE_LIMIT,
    progress: Progress[CaseRecord] | None = None,
    compiling: Progress[str] | None = None,
    beside: Progress[Likeness] | None = None,
) -> tuple[Board, Outcome | None]:
    """Run what the cells of these columns are made of, and return the board with all that are.

    `rows`: engines as for `--engine`, or `MODULE:NAME`.
    `folder`: a results folder of the suite, which keeps each case as it is done. A later run reuses
        those that are unchanged; see `validation.suite.unchanged`. `board.json` beside them is what
        they come to.
    `jobs`: processes. Run times are best taken with 1.
    `rerun`: whether to run anew all that is asked for; what isn't stays as it is.
    `time_limit` [s]: time after which a shot is given up.
    `compiling`: how far the compiling of our engine's kernels is, where they aren't.
    `beside`: called as each engine was put beside real tables.

    Returns the board, and the outcome of the suite's run, which an interrupt of anything after it
    interrupts; None where no engine could be asked anything that is right or wrong.

    Raises `GhostballError` where an engine or a setting is unknown, or the folder can't be read or
    written.
    """
    columns = tuple(columns)
    plan = _plan(rows, columns)
    stored = load(folder / BOARD)
    outcome = None
    if plan.pairs:
        outcome = run_suite(
            list(plan.scenes.values()),
            list(dict.fromkeys(label for _, label in sorted(plan.pairs))),
            folder,
            jobs=jobs,
            progress=progress,
            compiling=compiling,
            criteria=plan.criteria,
            reuse=not rerun,
            time_limit=time_limit,
            only=plan.pairs,
        )
    cells = _of_cases(folder, plan, {one.id: one for one in columns})
    if (tables := plan.beside) and not (outcome is not None and outcome.interrupted):
        ran = measure_likenesses(plan.rows, folder, time_limit, reuse=not rerun, progress=beside)
        if ran.interrupted:
            outcome = replace(outcome or Outcome(folder), interrupted=True)
        for column, found in product(tables, ran.records.values()):
            cells[found.label, column.id] = cell_of_likeness(column, found)
    new = Board(
        environment=describe_environment(),
        columns=tuple(one for one in columns if any(one.id == name for _, name in cells)),
        cells=tuple(cells.values()),
        absent=plan.absent,
    )
    board = _continued(stored, new)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(folder / BOARD, board.model_dump_json(indent=1, exclude_defaults=True) + "\n")
    except OSError as error:
        raise cannot_write(folder / BOARD, error) from None
    return board, outcome


def _plan(rows: Sequence[str], columns: Sequence[Column]) -> _Plan:
    absent: dict[str, str] = {}
    for row in rows:
        try:
            make_engine(row)
        except EngineUnavailableError as error:
            absent[row] = str(error)
    present = tuple(row for row in dict.fromkeys(rows) if row not in absent)
    pairs_of: dict[CellKey, tuple[Pair, ...]] = {}
    scenes: dict[str, Scene] = {}
    criteria: dict[str, Criteria] = {}
    beside = tuple(one for one in columns if one.metric == LIKENESS) if present else ()
    for row, column in product(present, [one for one in columns if one not in beside]):
        shots = asked(column, row)
        pairs_of[row, column.id] = tuple((scene.name, label) for _, scene, label in shots)
        for name, scene, _ in shots:
            scenes[scene.name] = scene
            if scene.name not in criteria:
                criteria[scene.name] = criteria_beside(scene_path(name))
    return _Plan(absent, present, beside, pairs_of, scenes, criteria)


def _continued(stored: Board | None, board: Board) -> Board:
    """Return a board with the cells of an earlier one that it lacks, and where those are from."""
    if stored is None:
        return board
    earlier: list[EnvironmentValues] = []
    new = {(one.row, one.column): one for one in board.cells}
    cells = {}
    for one in stored.cells:
        where, number = stored.environment_of(one), None
        if (one.row, one.column) not in new and _code_of(where) != _code_of(board.environment):
            earlier += [] if where in earlier else [where]
            number = earlier.index(where)
        cells[one.row, one.column] = one.model_copy(update={"earlier": number})
    cells |= new
    known = {one.id: one for one in (*COLUMNS.values(), *stored.columns, *board.columns)}
    columns = tuple(one for name, one in known.items() if any(name == c for _, c in cells))
    changes = {"cells": tuple(cells.values()), "columns": columns, "earlier": tuple(earlier)}
    return board.model_copy(update=changes)


def _code_of(environment: EnvironmentValues) -> EnvironmentValues:
    return {key: one for key, one in environment.items() if key not in ("date", "command")}


def _of_cases(folder: Path, plan: _Plan, columns: Mapping[str, Column]) -> dict[CellKey, Cell]:
    """Return the cells all of whose cases are stored, of the scenes as they are now."""
    results = Results.open(folder) if has_results(folder) else None
    stored = {} if results is None else {(one.scene, one.label): one for one in results.cases}
    cells = {}
    for (row, name), pairs in plan.pairs_of.items():
        cases = [stored.get(pair) for pair in pairs]
        found = [one for one in cases if one is not None and _is_of(one, plan.scenes[one.scene])]
        if len(found) < len(cases):
            continue
        column = columns[name]
        cell = cell_of(column, row, found)
        if column.laws and cell.scene and results is not None:
            motion = results.motion(stored[cell.scene, cell.label])
            if motion is not None:
                cell = cell.model_copy(update={"note": law_of(column, motion)})
        cells[row, name] = cell
    return cells


def _is_of(case: CaseRecord, scene: Scene) -> bool:
    return case.definition == scene.model_dump(mode="json", by_alias=True)


def load(path: Path) -> Board | None:
    """Read a board that was kept; None where there is none.

    Raises `GhostballError` where it is no board of this version.
    """
    try:
        return Board.model_validate_json(read_text(path))
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError, ValidationError) as error:
        why = describe_validation_error(error) if isinstance(error, ValidationError) else error
        raise GhostballError(
            f"{path} is no board that this version can continue: {why}. Move it away, or choose "
            "another `--out`"
        ) from None
