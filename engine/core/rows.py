"""A matrix of balls' numbers as rows with named fields: for kernels, compiled or interpreted."""

from __future__ import annotations

from typing import Any

import numba

from engine.core.kernel import kernel
from engine.core.state import BALL, BallRow, FloatArray


def _as_records(state: FloatArray) -> Any:
    """Return the rows of `Balls.state`, (n,) of `BallRow`, in the same memory."""
    return state.view(BALL)[:, 0]


def _as_objects(state: FloatArray) -> list[BallRow]:
    """Return the same for interpreted kernels: numpy's records have no fields as attributes."""
    return [BallRow(row) for row in state]


_config: Any = numba.config  # its attributes are made at run time
rows_of: Any = _as_objects if _config.DISABLE_JIT else kernel(inline=True)(_as_records)
