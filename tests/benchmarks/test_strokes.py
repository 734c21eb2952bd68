"""The benchmark of strokes compares the same shots, and prints the time of each way."""

from io import StringIO

import numpy as np
import pytest
from rich.console import Console

from benchmarks.strokes import WAYS, shots_in, strokes

pytestmark = pytest.mark.compiled  # hundreds of shots


def test_both_ways_are_the_same_shots_to_their_ends():
    one, other = (shots_in(way, 40)(10**6) for way in WAYS)
    assert one.complete.all()
    assert np.array_equal(one.rest_positions, other.rest_positions)
    assert np.array_equal(one.pocketed, other.pocketed)
    assert (one.pocketed >= 0).any()


def test_the_times_are_tabled():
    measured = strokes(repeats=2, count=40)
    assert [row.way for row in measured.rows] == list(WAYS)
    assert all(row.seconds > 0.0 and row.per_start > 0.0 for row in measured.rows)
    console = Console(width=100, record=True, file=StringIO())
    console.print(measured.table)
    assert f"strokes over velocities and spins: {measured.ratio:.2f}" in console.export_text()
