"""The oracle is itself checked, on what can be solved by hand and on its root finder."""

from __future__ import annotations

import pytest
from mpmath import mp, mpf, workdps
from oracle import first_entry, solve
from shots import R, ball, scene_of

from engine import EventKind, Table

TINY = mpf(10) ** -40


@pytest.fixture(autouse=True)
def _fifty_digits():
    with workdps(50):
        yield


def deceleration():
    return mpf(0.02) * mpf(9.81)


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


def test_a_ball_rolls_to_rest():
    run = solve(scene_of(ball((0, 0), (1, 0))))
    a = deceleration()
    assert [event.key for event in run.events] == [(EventKind.ROLL_TO_REST, 0, -1)]
    assert abs(run.t_end - 1 / a) < TINY
    assert abs(run.positions[0][0] - 1 / (2 * a)) < TINY
    assert run.velocities[0] == (0, 0)


def test_a_head_on_hit_hands_the_motion_over():
    run = solve(scene_of(ball((0, 0), (1, 0)), ball((0.5, 0))))
    a = deceleration()
    path = mpf(0.5) - 2 * mpf(R)
    first = run.events[0]
    assert first.key == (EventKind.BALL_BALL, 0, 1)
    assert abs(first.t - (1 - mp.sqrt(1 - 2 * a * path)) / a) < TINY
    # Together they roll as far as one would have alone.
    assert abs(run.positions[1][0] - (1 / (2 * a) + 2 * mpf(R))) < TINY
    assert abs(run.positions[0][0] - path) < TINY


def test_unequal_masses_and_restitution():
    scene = scene_of(
        ball((0, 0), (1, 0), mass=1.0),
        ball((1, 0), mass=3.0),
        rolling_friction=0.0,
        ball_restitution=0.5,
        t_max=2.0,
    )
    run = solve(scene)
    # m1 v1' + m2 v2' = 1, v2' - v1' = 1/2.
    assert abs(run.velocities[0][0] + mpf(1) / 8) < TINY
    assert abs(run.velocities[1][0] - mpf(3) / 8) < TINY
    assert run.t_end == 2


def test_a_half_ball_hit_leaves_at_30_and_60_degrees():
    # Line of centres at 30 degrees: sin = 1/2 exactly, whatever the distance.
    scene = scene_of(
        ball((0, 0), (1, 0), radius=0.25),
        ball((3, 0.25), radius=0.25),
        rolling_friction=0.0,
        t_max=5.0,
    )
    run = solve(scene)
    cue, struck = run.velocities
    assert abs(struck[1] / struck[0] - 1 / mp.sqrt(3)) < TINY
    assert abs(cue[1] / cue[0] + mp.sqrt(3)) < TINY
    assert abs(struck[0] ** 2 + struck[1] ** 2 - mpf(3) / 4) < TINY


def test_cushions_reverse_and_scale():
    table = Table(length=1.0, width=8.0, cushions=("right",))
    fields = {"rolling_friction": 0.0, "t_max": 2.0, "table": table}
    start = ball((0.25, 0.5), (1.0, 0.5), radius=0.25)
    mirrored = solve(scene_of(start, **fields))
    assert mirrored.events[0].key == (EventKind.BALL_CUSHION, 0, 1)
    assert abs(mirrored.events[0].t - mpf("0.5")) < TINY
    assert mirrored.velocities[0] == (-1, 0.5)
    law = {"cushion_restitution": 0.5, "cushion_tangential_restitution": 0.25}
    soft = solve(scene_of(start, cushion="restitution", **law, **fields))
    assert soft.velocities[0] == (-0.5, 0.125)
    assert abs(soft.positions[0][0] - 0) < TINY  # 1.5 s back at half the speed


def test_parallel_catch_up():
    scene = scene_of(ball((1, 1), (0, 1)), ball((1, 1.5), (0, 0.5)))
    first = solve(scene).events[0]
    assert first.kind is EventKind.BALL_BALL
    assert abs(first.t - (mpf(0.5) - 2 * mpf(R)) / mpf(0.5)) < TINY


def test_galperin_counts_pi():
    scene = scene_of(
        ball((0.5, 0), (0, 0), mass=1.0),
        ball((1.0, 0), (-1, 0), mass=100.0),
        table=Table(length=9.0, width=9.0, cushions=("left",)),
        rolling_friction=0.0,
        t_max=1000.0,
    )
    assert len(solve(scene).events) == 31


def test_a_nudge_is_amplified_as_by_hand():
    # One free ball to a cushion: dt = dx / v + x dv / v^2, of the order of 1 for numbers near 1.
    scene = scene_of(
        ball((0.5, 0.5), (1.0, 0.0)), table=Table(length=2, width=1), rolling_friction=0.0, t_max=2
    )
    shift = abs(solve(scene, nudge_seed=1).events[0].t - solve(scene).events[0].t)
    assert mpf(10) ** -27 < shift < mpf(10) ** -24


def test_it_refuses_balls_that_do_not_bounce():
    with pytest.raises(ValueError, match="pressed"):
        solve(scene_of(ball((0, 0), (1, 0)), ball_restitution=0.0))


def test_it_stops_after_so_many_ball_collisions():
    run = solve(scene_of(ball((0, 0), (1, 0)), ball((0.5, 0))), max_ball_collisions=1)
    assert len(run.events) == 1
