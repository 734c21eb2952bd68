"""The board of engines as it was stored: whose it is, and what stands in its cells."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Final

from ghostball.reports import style
from ghostball.validation.board.board import Board, load_board
from ghostball.validation.board.columns import COLUMNS, QUESTIONS, Worth
from ghostball.validation.results.files import BOARD

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WORTHS: Final[dict[Worth, tuple[str, str, str]]] = {
    "good": ("●", "right", "#BFE3D2"),
    "fair": ("◐", "right to what its step, or its precision, lets one expect", "#F6E8B0"),
    "bad": ("✗", "wrong", "#F3BFA5"),
    "design": ("◇", "by design: which law of simultaneous impacts it plays", "#C9E2F5"),
    "none": ("", "it lacks what the question is of", "#F2F2F2"),
    "failed": ("!", "not measured: it crashed, hung or raised", "#D9B8D0"),
}
"""Of each worth a sign, what it says, and the paper of its cells."""


def board_beside(results: Path) -> Board | None:
    """Return the board that lies in a results folder; None without one."""
    return load_board(results / "board" / BOARD)


def about(board: Board) -> str:
    """Return where and when a board was measured."""
    where = board.environment
    revision = (where.get("git") or {}).get("revision", "unknown")[:7]
    changed = " with changes" if (where.get("git") or {}).get("dirty") else ""
    return f"{where['cpu']}, {where['cores']} cores, {where['date'][:10]}, at {revision}{changed}"


def columns_of(board: Board, among: Iterable[str] = QUESTIONS) -> list[str]:
    """Return those of some columns of which a board has anything, in their order."""
    found = {column for _, column in board.cells}
    return [name for name in among if name in found]


def cell_text(board: Board, row: str, name: str) -> str:
    """Return a cell with its sign; "–" where there is no value, "" where it was not measured."""
    cell = board.cells.get((row, name))
    if cell is None:
        return ""
    return f"{WORTHS[cell.worth][0]} {cell.text}".strip() or "–"


def board_table(board: Board, among: Iterable[str] = QUESTIONS) -> str:
    """Return some columns of a board as a table in Markdown, with what its signs say."""
    names = columns_of(board, among)
    heads = ["engine", *(COLUMNS[name].title for name in names)]
    lines = [" | ".join(heads), " | ".join("---" for _ in heads)]
    for row in board.rows:
        lines.append(" | ".join([f"`{row}`", *(cell_text(board, row, name) for name in names)]))
    signs = "; ".join(f"{sign} {says}" for sign, says, _ in WORTHS.values() if sign)
    said = f"{signs}; – it lacks what the question is of. Measured on {about(board)}."
    return "\n".join([*lines, "", said])


def board_markdown(board: Board) -> str:
    """Return a board as a table in Markdown, and what its columns ask."""
    lines = [board_table(board), ""]
    for name in columns_of(board):
        column = COLUMNS[name]
        unit = f" [{column.unit}]" if column.unit else ""
        lines.append(f"- **{column.title}**{unit}: {column.asks}.")
    return "\n".join(lines)


def draw_board(board: Board, among: Iterable[str] = QUESTIONS) -> Figure:
    """Draw a board: a row for each engine and configuration, a column for each question."""
    from matplotlib.patches import Patch, Rectangle  # noqa: PLC0415

    names = columns_of(board, among)
    figure = style.new_figure(2.2 + 0.78 * len(names), 1.3 + 0.25 * len(board.rows))
    axes = figure.subplots()
    for y, row in enumerate(board.rows):
        for x, name in enumerate(names):
            cell = board.cells.get((row, name))
            if cell is None:
                continue
            paper = WORTHS[cell.worth][2]
            axes.add_patch(Rectangle((x, y), 1, 1, facecolor=paper, edgecolor="white"))
            text = cell_text(board, row, name)
            axes.text(x + 0.5, y + 0.5, text, ha="center", va="center", fontsize=6.8)
    axes.set(xlim=(0, len(names)), ylim=(len(board.rows), 0))
    axes.set_yticks([y + 0.5 for y in range(len(board.rows))], board.rows)
    units = {name: f"\n[{COLUMNS[name].unit}]" if COLUMNS[name].unit else "\n" for name in names}
    titles = [COLUMNS[name].title + units[name] for name in names]
    axes.set_xticks([x + 0.5 for x in range(len(names))], titles)
    axes.xaxis.tick_top()
    axes.tick_params(length=0, labelsize=7.5)
    for spine in axes.spines.values():
        spine.set_visible(False)
    shown = {cell.worth for (_, name), cell in board.cells.items() if name in names}
    legend = [
        Patch(facecolor=paper, label=f"{sign} {says}".strip())
        for worth, (sign, says, paper) in WORTHS.items()
        if worth in shown
    ]
    figure.legend(handles=legend, loc="outside lower center", ncols=3, fontsize=7.5)
    style.set_title(figure, f"Engines on the questions that tell them apart ({about(board)})")
    return figure
