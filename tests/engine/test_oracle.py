"""The oracle's root finder, what it refuses, and that it nudges every number of a scene.

Its motion and its laws are checked by `test_simulate_oracle.py`: the engine has the closed forms'
answers, and the oracle the engine's.
"""

from __future__ import annotations

import pytest
from mpmath import mp, mpf, workdps
from oracle import NUDGE, first_entry, solve
from shots import POOL_TABLE, ball, scene_of

from ghostball.engine import Table

TINY = mpf(10) ** -40


@pytest.fixture(autouse=True)
def _fifty_digits():
    with workdps(50):
        yield


class TestFirstEntry:
    @staticmethod
    def expanded(*roots, leading=1):
        """Polynomial with the given roots, coefficients from the constant up."""
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

    def test_two_roots_a_hair_apart_are_a_hit_and_a_hair_less_is_a_miss(self):
        hair = mpf(10) ** -20
        hit = first_entry([1 - hair, mpf(-2), mpf(1)], mpf(10))
        assert abs(hit - (1 - mp.sqrt(hair))) < TINY
        assert first_entry([1 + hair, mpf(-2), mpf(1)], mpf(10)) is None

    def test_a_vanishing_leading_coefficient_changes_nothing(self):
        noise = mpf(10) ** -49
        assert abs(first_entry([mpf(1), mpf(-1), noise, noise, noise], mpf(10)) - 1) < TINY


def test_a_nudge_moves_every_number_of_the_scene():
    # Each of these alone changes a time of the shot: had it no nudge, the time would not move.
    table = Table(length=2.0, width=1.0)
    balls = (ball((0.5, 0.4), (1.0, 0.1), angular_velocity=(30.0, -20.0, 10.0)), ball((1.2, 0.5)))
    physics = {"motion": "sliding", "ball_restitution": 0.9, "ball_friction": "alciatore"}
    scene = scene_of(*balls, table=table, cushion="han2005", cushion_restitution=0.8, **physics)
    run, nudged = solve(scene, max_events=8), solve(scene, max_events=8, nudge_seed=1)
    before, after = run.moments[0][1][0], nudged.moments[0][1][0]
    for name in ("radius", "mass", "rolling", "sliding", "spinning"):
        assert 0 < abs(getattr(after, name) / getattr(before, name) - 1) < 2 * NUDGE
    for name in ("position", "velocity", "spin"):
        moved = [
            abs(b - a) for a, b in zip(getattr(before, name), getattr(after, name), strict=True)
        ]
        assert all(0 < shift < 100 * NUDGE for shift in moved[:2])
    assert before.spin[2] != after.spin[2]
    assert [event.key for event in nudged.events] == [event.key for event in run.events]
    assert all(a.t != b.t for a, b in zip(run.events, nudged.events, strict=True))


@pytest.mark.parametrize(
    ("why", "physics"),
    [
        ("pressed", {"ball_restitution": 0.0}),
        ("pressed", {"cushion": "restitution", "cushion_restitution": 0.0}),
        ("mathavan2014", {"motion": "sliding", "ball_impact": "mathavan2014"}),
        ("mathavan2010", {"motion": "sliding", "cushion": "mathavan2010"}),
        ("air", {"air_drag": 0.004}),
    ],
)
def test_it_refuses_what_it_cannot_tell(why, physics):
    with pytest.raises(ValueError, match=why):
        solve(scene_of(ball((0.5, 0.5), (1, 0)), table=POOL_TABLE, **physics))


def test_it_stops_after_so_many_events():
    scene = scene_of(ball((0, 0), (1, 0)), ball((0.5, 0)))
    for limit in ({"max_ball_collisions": 1}, {"max_events": 1}):
        run = solve(scene, **limit)
        assert len(run.events) == 1
        assert not run.complete
    assert solve(scene).complete
