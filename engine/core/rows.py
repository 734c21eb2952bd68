"""A matrix of balls' numbers as rows with named fields: for kernels, compiled or interpreted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba.extending import overload

from engine.core.state import BALL, BallRow, FloatArray


def rows_of(state: FloatArray) -> Any:
    """Return the rows of a matrix (n, STATE_COLUMNS), (n,) of `BallRow`, in the same memory.

    What interpreted kernels do: numpy's own records have no fields as attributes.
    """
    return [BallRow(row) for row in state]


@overload(rows_of, inline="always")
def _rows_of(state: Any) -> Callable[[Any], Any]:  # noqa: ARG001 - a type, which is known
    """Return what compiled kernels do; written into the caller, which may return no array."""
    return lambda state: state.view(BALL)[:, 0]
