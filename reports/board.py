"""The board of engines as it was stored: whose it is, and what stands in its cells."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Final

from ghostball.reports import style
from ghostball.reports.accuracy import CLASSES
from ghostball.validation.board.board import Board, load
from ghostball.validation.board.cell import Cell, Shade
from ghostball.validation.board.column import COLUMNS, LIKENESS, Column
from ghostball.validation.board.history import Move
from ghostball.validation.results.fields import Environment, EnvironmentValues
from ghostball.validation.results.files import BOARD
from ghostball.validation.results.records import AccuracyKind

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class CellLook:
    """How a cell is shown: a sign, what it says, its class on the page, its colours elsewhere."""

    sign: str
    says: str
    slug: str
    terminal: str
    paper: str


_PAPERS: Final = ("#BFE5CD", "#C4EBEC", "#CFE0FB", "#F9ECB4", "#FBD9B1", "#F6C3BD", "#E3C6EE")
"""Of the classes of accuracy, as on the page."""

LOOKS: Final[dict[AccuracyKind | Shade, CellLook]] = {
    **{
        kind: CellLook("", f"{kind}: {look.meaning}", f"acc-{look.slug}", look.terminal, paper)
        for (kind, look), paper in zip(CLASSES.items(), _PAPERS, strict=True)
    },
    "good": CellLook("●", "right, or cheap, by the column's threshold", "pass", "green", "#E3F4E8"),
    "fair": CellLook("◐", "less so", "holds", "yellow", "#FBF1D7"),
    "bad": CellLook("✗", "wrong, or not reached", "fail", "red", "#FDE8E6"),
    "beside": CellLook("", "neither right nor wrong: how far off", "ref", "default", "#EEF0F8"),
    "partly": CellLook("", "the same in part: it lacks the rest", "ref", "dim", "#F8F8FC"),
    "none": CellLook("–", "it lacks what the question is of", "ref", "dim", "#F2F2F2"),
    "failed": CellLook(
        "!", "not measured: it crashed, hung or raised", "acc-crashed", "bold red", "#D9B8D0"
    ),
}
"""Of each class and shade."""


def board_beside(results: Path) -> Board | None:
    """Return the board that lies in a results folder; None without one."""
    return load(results / "board" / BOARD)


def about(board: Board, columns: Collection[Column] | None = None) -> str:
    """Return where and when a board was measured: most of it, then other cells.

    These by their engines, where all that these show is from there, else by their columns.
    """
    where: dict[str, list[tuple[str, str]]] = {}
    for column in board.columns if columns is None else columns:
        for cell in board.cells:
            if cell.column == column.id:
                of = cell.row.partition(":")[0], column.title
                where.setdefault(measured(board.environment_of(cell)), []).append(of)
    if not where:
        return measured(board.environment)
    most, *others = sorted(where, key=lambda one: -len(where[one]))
    said = [most]
    for one in others:
        engines = dict.fromkeys(engine for engine, _ in where[one])
        elsewhere = {engine for place in where.keys() - {one} for engine, _ in where[place]}
        titles = dict.fromkeys(title for _, title in where[one])
        said.append(f"{', '.join(titles if elsewhere & engines.keys() else engines)}: {one}")
    return "; ".join(said)


def measured(environment: EnvironmentValues) -> str:
    """Return where and when something was measured, by which revision."""
    where = Environment.model_validate(environment)
    revision = "unknown" if where.git is None else where.git.revision[:7]
    changed = " with changes" if where.git is not None and where.git.dirty else ""
    return f"{where.cpu}, {where.cores} cores, {where.date[:10]}, at {revision}{changed}"


def columns_of(board: Board, *, reported: bool) -> list[Column]:
    """Return the columns of a board: the faults that people reported, or all others."""
    return [one for one in board.columns if (one.thread is not None) is reported]


def value_text(column: Column, cell: Cell) -> str:
    """Return what a cell says, without its sign; "" where it has no value."""
    if cell.kind == "failed":
        return "failed"
    if cell.kind in ("another shot", "broken"):
        return CLASSES[cell.kind].short
    if cell.value is None:
        return "not reached" if cell.kind == "bad" else ""
    if column.metric == LIKENESS:
        return f"{cell.value:.1f}" + " in part" * (cell.kind == "partly")
    if column.laws and cell.kind != "bad":
        return cell.note.partition(":")[0]
    if column.unit in ("m", "s"):
        return "exact" if cell.kind == "exact" else style.format_quantity(cell.value, column.unit)
    if column.pick == "widest":
        return f"{cell.value:g}°"
    if column.pick == "fastest":
        return f"{cell.value:g}" if cell.value else "none"
    return f"{cell.value:.1e}" if cell.value > _KEPT else "kept"


_KEPT: Final = 1e-9
"""Share of its energy that roundings may make of a shot's that keeps it."""


def cell_text(board: Board, row: str, column: Column) -> str:
    """Return a cell with its sign; "–" where there is no value, "" where it was not measured."""
    cell = board.cell(row, column.id)
    if cell is None:
        return ""
    return f"{LOOKS[cell.kind].sign} {value_text(column, cell)}".strip()


def move_text(move: Move) -> str:
    """Say which cell of the board moved, from what to what, and since when."""
    column = COLUMNS[move.column]
    ends = []
    for said in (move.before, move.now):
        cell = Cell.model_validate({"row": move.row, "column": move.column, **said.model_dump()})
        word = value_text(column, cell) or "no value"
        ends.append(f"{LOOKS[cell.kind].sign} {word}".strip())
    return f"moved: {move.row}, {column.id}: {' to '.join(ends)}, since {move.since.when}"


def looks_of(board: Board, columns: Collection[Column]) -> list[CellLook]:
    """Return the looks that cells of these columns have, in order of `LOOKS`."""
    ids = {column.id for column in columns}
    shown = {cell.kind for cell in board.cells if cell.column in ids}
    return [look for kind, look in LOOKS.items() if kind in shown]


def draw_board(board: Board, columns: Collection[Column] | None = None) -> Figure:
    """Draw a board: a row for each engine and configuration, a column for each question."""
    from matplotlib.patches import Patch, Rectangle  # noqa: PLC0415

    columns = columns_of(board, reported=False) if columns is None else columns
    figure = style.new_figure(2.2 + 0.78 * len(columns), 1.3 + 0.25 * len(board.rows))
    axes = figure.subplots()
    for y, row in enumerate(board.rows):
        for x, column in enumerate(columns):
            cell = board.cell(row, column.id)
            if cell is None:
                continue
            paper = LOOKS[cell.kind].paper
            axes.add_patch(Rectangle((x, y), 1, 1, facecolor=paper, edgecolor="white"))
            text = cell_text(board, row, column)
            axes.text(x + 0.5, y + 0.5, text, ha="center", va="center", fontsize=6.8)
    axes.set(xlim=(0, len(columns)), ylim=(len(board.rows), 0))
    axes.set_yticks([y + 0.5 for y in range(len(board.rows))], board.rows)
    titles = [f"{fill(one.title, 15)}\n{fill(unit_of(one).strip(), 12)}".strip() for one in columns]
    axes.set_xticks([x + 0.5 for x in range(len(columns))], titles)
    axes.xaxis.tick_top()
    axes.tick_params(length=0, labelsize=7.5)
    for spine in axes.spines.values():
        spine.set_visible(False)
    legend = [
        Patch(facecolor=look.paper, label=f"{look.sign} {look.says}".strip())
        for look in looks_of(board, columns)
    ]
    figure.legend(handles=legend, loc="outside lower center", ncols=2, fontsize=7.5)
    title = f"Engines on the questions that distinguish them ({about(board, columns)})"
    parts = title.replace("; ", ";\n").split("\n")
    style.set_title(figure, "\n".join(fill(part, 9 * len(columns)) for part in parts))
    return figure


def unit_of(column: Column) -> str:
    """Return the unit of a column's heading; lengths and times say theirs in the cells."""
    return "" if column.unit in ("m", "s") else f" [{column.unit}]" * bool(column.unit)
