"""Replays of the board: of each column the motions behind its cells, as its folder keeps them.

They lie beside the committed board, as the replays of a report have them. The site of the
documentation makes a page of each (`docs.replay_pages`).
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

from benchmarks.measurements import STORE
from ghostball.reports.board import cell_text
from ghostball.reports.page.replay_data import scene_data
from ghostball.reports.shots import Run, Shot
from ghostball.validation.board.board import Board
from ghostball.validation.board.column import Column
from ghostball.validation.results.files import cannot_write, write_whole
from ghostball.validation.results.measurement import Record
from ghostball.validation.results.store import Results

FOLDER: Final = "replays"
"""Of the committed measurements of a machine."""

REFERENCE: Final = "ghostball"
"""The row that is shown beside each other one, where it played the same shot."""


class ColumnReplays(Record):
    """What is replayed of a column.

    `shots`: of each scene that answers it, what its replay shows (`scene_data`).
    `shot_of`: which of them is behind a row's cell.
    `labels`: the engine and its settings in that run.
    """

    column: str
    shots: tuple[dict[str, Any], ...]
    shot_of: dict[str, int]
    labels: dict[str, str]


def replays_of(column: Column, ran: Board, committed: Board, results: Results) -> ColumnReplays:
    """Return what is replayed of a column: of the cells that are as they are committed.

    `ran`: the board of the results.
    """
    scenes: dict[str, list[str]] = {}
    labels = {}
    for row in committed.rows:
        cell = ran.cell(row, column.id)
        same = cell_text(ran, row, column) == cell_text(committed, row, column)
        if cell is not None and cell.scene and same and results.case(cell.scene, cell.label):
            scenes.setdefault(cell.scene, []).append(row)
            labels[row] = cell.label
    shots: list[dict[str, Any]] = []
    shot_of: dict[str, int] = {}
    for scene, rows in scenes.items():
        reference = ran.cell(REFERENCE, column.id)
        of = {REFERENCE: reference.label} if reference is not None else {}
        runs = []
        for row, label in (of | {row: labels[row] for row in rows}).items():
            case = results.case(scene, label)
            motion = None if case is None else results.motion(case)
            if case is not None and motion is not None:
                runs.append((row, Run(row, case, motion), case.load_scene()))
        moved = [row for row, _, _ in runs if row in rows]
        if moved:
            shot_of |= dict.fromkeys(moved, len(shots))
            shots.append(scene_data(Shot(runs[0][2], tuple(run for _, run, _ in runs))))
    return ColumnReplays(column=column.id, shots=tuple(shots), shot_of=shot_of, labels=labels)


def write_replays(ran: Board, committed: Board, results: Results, out: Path) -> list[Path]:
    """Write the replays of each column that has one; return the files."""
    written = []
    for column in (one for one in ran.columns if one.replay):
        found = replays_of(column, ran, committed, results)
        if found.shot_of:
            path = out / f"{column.id}.json"
            text = json.dumps(found.model_dump(mode="json"), separators=(",", ":"))
            try:
                out.mkdir(parents=True, exist_ok=True)
                write_whole(path, text + "\n")
            except OSError as error:
                raise cannot_write(path, error) from None
            written.append(path)
    return written


def committed_replays() -> dict[str, ColumnReplays]:
    """Return the committed replays by their column."""
    paths = sorted(STORE.glob(f"*/{FOLDER}/*.json"))
    return {path.stem: ColumnReplays.model_validate_json(path.read_bytes()) for path in paths}
