"""The oracle's root finder, and scenes that the oracle rejects.

`test_api.py` tests the motion and the laws of the oracle: proofs contain its results.
"""

from __future__ import annotations

import pytest
from mpmath import mp, mpf, workdps
from oracle import first_entry, solve
from shots import POOL_TABLE, ball, scene_of

TINY = mpf(10) ** -40


@pytest.fixture(autouse=True)
def _fifty_digits():
    with workdps(50):
        yield


class TestFirstEntry:
    @staticmethod
    def expanded(*roots, leading=1):
        """Return the polynomial with the given roots; coefficients, the constant first."""
        coefficients = [mpf(leading)]
        for root in roots:
            shifted = [mpf(0), *coefficients]
            for k, c in enumerate(coefficients):
                shifted[k] -= root * c
            coefficients = shifted
        return coefficients

    def test_the_first_of_four_roots_where_the_gap_starts_positive(self):
        assert abs(first_entry(self.expanded(1, 2, 3, 4), mpf(10)) - 1) < TINY

    def test_the_first_entering_root_where_the_balls_overlap_and_leave(self):
        # Negative up to 1, positive from 1 to 2: the entry is at 2.
        assert abs(first_entry(self.expanded(1, 2, 3, leading=1), mpf(10)) - 2) < TINY

    def test_a_root_at_the_start_that_leaves_is_no_entry(self):
        assert abs(first_entry(self.expanded(0, 3, leading=-1), mpf(10)) - 3) < TINY

    def test_touching_and_approaching_is_now(self):
        assert first_entry([mpf(0), mpf(-1), mpf(5)], mpf(10)) == 0
        assert first_entry([mpf("-1e-17"), mpf(-1), mpf(5)], mpf(10)) == 0

    def test_touching_and_receding_or_still_is_not_now(self):
        assert first_entry([mpf(0), mpf(1), mpf(5)], mpf(10)) is None
        assert first_entry([mpf(0), mpf(0), mpf(0)], mpf(10)) is None

    def test_beyond_the_horizon(self):
        assert first_entry(self.expanded(1, 2), mpf("0.99")) is None
        assert first_entry(self.expanded(1, 2), mpf("1.01")) is not None

    def test_two_roots_a_hair_apart_are_a_collision_and_a_hair_less_is_a_miss(self):
        hair = mpf(10) ** -20
        root = first_entry([1 - hair, mpf(-2), mpf(1)], mpf(10))
        assert abs(root - (1 - mp.sqrt(hair))) < TINY
        assert first_entry([1 + hair, mpf(-2), mpf(1)], mpf(10)) is None

    def test_a_vanishing_leading_coefficient_changes_nothing(self):
        noise = mpf(10) ** -49
        assert abs(first_entry([mpf(1), mpf(-1), noise, noise, noise], mpf(10)) - 1) < TINY


@pytest.mark.parametrize(
    ("why", "physics"),
    [
        ("in contact", {"ball_restitution": 0.0}),
        ("in contact", {"cushion": "restitution", "cushion_restitution": 0.0}),
        ("mathavan2014", {"motion": "sliding", "ball_impact": "mathavan2014"}),
        ("mathavan2010", {"motion": "sliding", "cushion": "mathavan2010"}),
        ("air", {"air_drag": 0.004}),
    ],
)
def test_it_refuses_what_it_cannot_tell(why, physics):
    with pytest.raises(ValueError, match=why):
        solve(scene_of(ball((0.5, 0.5), (1, 0)), table=POOL_TABLE, **physics))
