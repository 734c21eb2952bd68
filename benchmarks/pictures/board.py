"""The committed board of engines, which the documentation and the README show."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.measurements import stored_paths
from ghostball.reports.board import draw_board
from ghostball.validation.board.board import Board, load
from ghostball.validation.results.files import BOARD

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def committed_board() -> Board | None:
    """Return the committed board, of the first machine that has one; None without any."""
    paths = stored_paths(Path(BOARD).stem)
    return load(paths[0]) if paths else None


def draw_committed_board() -> Figure | None:
    """Draw the committed board; None without one."""
    board = committed_board()
    return None if board is None else draw_board(board)
