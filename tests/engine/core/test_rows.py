"""Tests that rows and their matrix share memory: writing one changes the other."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.engine.core.rows import BALL, STATE_COLUMNS, BallRow, column_of, dtype_of, rows_of


def test_a_row_reads_and_writes_the_numbers_of_the_matrix():
    matrix = np.arange(2.0 * STATE_COLUMNS).reshape(2, STATE_COLUMNS)
    rows = rows_of(matrix, BallRow)
    for field in BallRow.__annotations__:
        column = column_of(BallRow, field)
        assert getattr(rows[1], field) == STATE_COLUMNS + column
        setattr(rows[1], field, -1.0 - column)
        assert matrix[1, column] == -1.0 - column
    assert matrix[0].tolist() == list(range(STATE_COLUMNS))


def test_a_record_has_the_fields_of_the_row_in_its_order_and_room_behind():
    matrix = np.arange(2.0 * STATE_COLUMNS).reshape(2, STATE_COLUMNS)
    records = matrix.view(BALL)[:, 0]
    for field in BallRow.__annotations__:
        assert records[field].tolist() == matrix[:, column_of(BallRow, field)].tolist()
    assert BALL.itemsize == 8 * STATE_COLUMNS
    assert dtype_of(BallRow, STATE_COLUMNS + 8).itemsize == 8 * (STATE_COLUMNS + 8)


def test_what_is_no_field_has_no_column():
    with pytest.raises(ValueError, match="'height' is not in list"):
        column_of(BallRow, "height")
