"""Sequences of collisions that agree, differ, end early and tie."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.engine import EventKind
from ghostball.validation.grading.sequences import matching_collisions

BB, BC = int(EventKind.BALL_BALL), int(EventKind.BALL_CUSHION)

A, B, C, D = (BB, 0, 1), (BB, 1, 2), (BC, 0, 3), (BC, 2, 0)


@pytest.mark.parametrize(
    ("ours", "our_times", "true", "times", "matched"),
    [
        ([A, B, C], [1, 2, 3], [A, B, C], [1, 2, 3], 3),
        ([A, B], [1, 2], [A, B, C], [1, 2, 3], 2),  # one missing
        ([A, B, C], [1, 2, 3], [A, B], [1, 2], 2),  # one too many
        ([A, C, B], [1, 2, 3], [A, B, C], [1, 2, 3], 1),  # order counts
        ([], [], [A], [1], 0),
        ([A, C, B], [1, 2, 3], [A, B, C], [1, 2, 2], 3),  # tied in truth: no order
        ([A, C, B], [1, 2, 2], [A, B, C], [1, 2, 3], 3),  # one time for both: no order claimed
        ([A, C, B], [1, 2, 3], [A, B, C], [1, 2, 2 * (1 + 1e-13)], 3),  # apart by rounding only
        ([A, C, B], [1, 2, 3], [A, B, C], [1, 2, 2 * (1 + 1e-11)], 1),  # a true order
        ([A, C, B], [1, 2, 3], [A, B, C], [], 1),  # a closed form's order is strict
        ([C, A, B, D], [1, 1, 2, 3], [A, B, C, D], [1, 2, 2, 3], 4),  # ties overlap in a chain
        ([A, A, D], [1, 1, 2], [A, B, D], [1, 1, 2], 1),  # each true collision serves once
        ([A, D, B], [1, 1, 2], [A, B, D], [1, 1, 2], 1),  # a tie does not reach beyond itself
        ([B], [1], [A, B], [1, 1], 1),  # the log ends inside the tie
    ],
)
def test_matching_collisions(
    ours: list[tuple[int, int, int]],
    our_times: list[float],
    true: list[tuple[int, int, int]],
    times: list[float],
    matched: int,
) -> None:
    found = matching_collisions(
        ours, np.array(our_times, dtype=float), true, np.array(times, dtype=float)
    )
    assert found == matched
