"""The board itself: measure each cell in a process of its own time limit, keep it, go on from it.

>>> from ghostball.validation.board.board import run_board
>>> board = run_board(["ghostball", "mujoco"], Path("out/board"))
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from pydantic import BaseModel, ConfigDict, ValidationError, field_validator

from ghostball.engine import EngineFailedError, GhostballError, UnsupportedSceneError
from ghostball.reference_adapters.registry import OURS, EngineUnavailableError, make_engine
from ghostball.validation.board.columns import COLUMNS, QUESTIONS, Cell
from ghostball.validation.board.shots import cut_to_rest, one_into_two, slide_to_rest
from ghostball.validation.parallel.compiling import compile_kernels
from ghostball.validation.parallel.pool import Progress, run_tasks
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.fields import EnvironmentValues
from ghostball.validation.results.files import BOARD, cannot_write, told, write_whole
from ghostball.validation.results.motions import save_motion
from ghostball.validation.results.records import Motion
from ghostball.validation.suite.unchanged import code_hash, is_ours

ROWS: Final = (
    "ghostball",
    "pymunk",
    "pymunk:config=default",
    "pybullet",
    "pybullet:config=default",
    "mujoco",
    "mujoco:config=default",
    "box2d",
    "box2d:bullet=no",
    "box2d:config=default",
    "box2d3",
    "box2d3:config=default",
    "rapier",
    "rapier:config=default",
    "dart",
    "dart:cloth=own",
    "dart:config=default",
    "physx",
    "physx:cloth=own",
    "physx:solver=tgs",
    "physx:config=default",
    "pooltool",
    "billiards",
    "paper-discrete",
    "paper-continuous",
)
"""Engines and configurations that the board has, unless others are asked for."""

CELL_LIMIT: Final = 120.0
"""Time after which a cell is given up [s]."""

Place = tuple[str, str]
"""A row and a column."""

Measured = tuple[Place, Cell, Motion | None]
"""What became of a cell, and the motion that shows it."""


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class StoredCell(_Record):
    """A cell as it is kept, with the hash of the code that measured it."""

    row: str
    column: str
    code: str
    cell: Cell

    @field_validator("column")
    @classmethod
    def _is_a_column(cls, value: str) -> str:
        if value not in COLUMNS:
            raise ValueError(f"must be one of {', '.join(COLUMNS)}")
        return value


class StoredBoard(_Record):
    """All cells that are kept, and where the last of them was measured."""

    environment: EnvironmentValues
    cells: tuple[StoredCell, ...]


@dataclass(frozen=True)
class Board:
    """Cells by row and column.

    Attributes
    ----------
    rows : tuple of str
        Engines with their settings.
    cells : mapping of (row, column) to Cell
    absent : mapping of str to str
        Rows that can't run here, and why.
    environment : dict
        Where, when and with which versions the last of them was measured.
    """

    rows: tuple[str, ...]
    cells: Mapping[Place, Cell]
    absent: Mapping[str, str]
    environment: Mapping[str, Any]

    def command(self, row: str, column: str) -> str:
        """Return the command that measures a cell again."""
        return f"ghostball leaderboard --only -e {row} --column {column} --rerun"


def run_board(
    rows: Sequence[str],
    folder: Path,
    *,
    columns: Iterable[str] = QUESTIONS,
    jobs: int = 1,
    rerun: bool = False,
    progress: Progress[str] | None = None,
    compiling: Progress[str] | None = None,
) -> Board:
    """Measure every cell that isn't there yet, and return the board with all that are.

    Parameters
    ----------
    rows : sequence of str
        Engines as for `--engine`, or `MODULE:CLASS`.
    folder : Path
        Where cells are kept, each as it is done. A later run takes over those that the same code
        measured; those of an engine that isn't ours, whose code nobody knows, and those that
        failed are measured anew.
    columns : iterable of str
    jobs : int
        Processes. Run times are best taken with 1.
    rerun : bool
        Whether to measure anew all that is asked for; what isn't stays as it is.
    progress : callable, optional
    compiling : callable, optional
        How far the compiling of our engine's kernels is, where they aren't.

    Raises
    ------
    GhostballError
        Where a column, an engine or a setting is unknown, or the folder can't be read or written.
    """
    rows, columns = tuple(dict.fromkeys(rows)), list(dict.fromkeys(columns))
    if unknown := [name for name in columns if name not in COLUMNS]:
        raise GhostballError(
            f"unknown column {unknown[0]!r}. Columns of the board: {', '.join(COLUMNS)}"
        )
    path, code = folder / BOARD, code_hash()
    stored = load(path)
    kept = {} if stored is None else {(one.row, one.column): one for one in stored.cells}
    absent: dict[str, str] = {}
    for row in rows:
        try:
            make_engine(row)
        except EngineUnavailableError as error:
            absent[row] = str(error)
    present = [row for row in rows if row not in absent]
    ours = {row for row in present if is_ours(row)}
    cells = {
        place: one.cell
        for place, one in kept.items()
        if one.row in ours and one.code == code != "" and one.cell.worth != "failed"
    }
    asked = [(row, column) for row in present for column in columns]
    tasks = [place for place in asked if rerun or place not in cells]
    planned = len(tasks)
    environment = describe_environment()
    prepare: Callable[[], object] | None = None
    if tasks:
        plays = any(make_engine(row).name == OURS for row, _ in tasks)
        shots = (one_into_two(), slide_to_rest(), cut_to_rest()) if plays else ()
        prepare = compile_kernels(shots, jobs, labels=present, compiling=compiling)
    with closing(run_tasks(tasks, jobs, measure, CELL_LIMIT, prepare)) as done:
        for number, one in enumerate(done, start=1):
            place, cell, motion = one.or_else(_died)
            row, column = place
            cells[place] = cell
            kept[place] = StoredCell(row=row, column=column, code=code, cell=cell)
            board = StoredBoard(environment=environment, cells=tuple(kept.values()))
            _save(folder, place, motion, board)
            if progress is not None:
                progress(number, planned, f"{column} of {row}")
    return Board(tuple(present), cells, absent, environment)


def measure(task: Place) -> Measured:
    """Measure a cell; whatever the engine does becomes part of it."""
    row, column = task
    try:
        cell = COLUMNS[column].measure(row)
        return task, cell, None if cell.worth == "none" else COLUMNS[column].motion(row)
    except UnsupportedSceneError as error:
        return task, Cell(None, "", "none", "; ".join(error.features)), None
    except EngineFailedError as error:
        return task, Cell(None, "failed", "failed", error.reason), None
    except Exception as error:
        logging.getLogger("ghostball").exception("column %s of %s", column, row)
        return task, Cell(None, "failed", "failed", f"{type(error).__name__}: {error}"), None


def _died(task: Place, reason: str) -> Measured:
    return task, Cell(None, "died", "failed", reason), None


def _save(folder: Path, place: Place, motion: Motion | None, board: StoredBoard) -> None:
    """Keep a board with a cell that is done, its motion first: it isn't measured again."""
    row, column = place
    path = folder / BOARD
    try:
        folder.mkdir(parents=True, exist_ok=True)
        save_motion(folder, motion, scene=column, side=row)
        # Whole or not at all: a run may be ended at any instant.
        write_whole(path, board.model_dump_json(indent=1) + "\n")
    except OSError as error:
        raise cannot_write(path, error) from None


def load(path: Path) -> StoredBoard | None:
    """Read a board that was kept; None where there is none.

    Raises
    ------
    GhostballError
        Where it is no board of this version.
    """
    try:
        return StoredBoard.model_validate_json(path.read_bytes())
    except FileNotFoundError:
        return None
    except (OSError, ValidationError) as error:
        why = told(error) if isinstance(error, ValidationError) else error
        raise GhostballError(
            f"{path} is no board that this version can go on from: {why}. Move it away, or choose "
            "another `--out`"
        ) from None


def load_board(path: Path) -> Board | None:
    """Return a board that was kept, with all its rows in the order of `ROWS`; None without one."""
    stored = load(path)
    if stored is None:
        return None
    found = dict.fromkeys(one.row for one in stored.cells)
    rows = [row for row in ROWS if row in found] + [row for row in found if row not in ROWS]
    cells = {(one.row, one.column): one.cell for one in stored.cells}
    return Board(tuple(rows), cells, {}, stored.environment)


def sorted_rows(board: Board, column: str) -> Board:
    """Return the board with its rows in order of a column, the least first, none last."""

    def size(row: str) -> tuple[bool, float]:
        cell = board.cells.get((row, column))
        value = None if cell is None else cell.value
        return value is None, abs(value or 0.0)

    return replace(board, rows=tuple(sorted(board.rows, key=size)))
