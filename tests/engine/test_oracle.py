"""The oracle is itself checked: its root finder, its bookkeeping, and rolling balls by hand.

Sliding and spin are in `test_oracle_motion`, the laws of impacts in `test_oracle_impacts`.
"""

from __future__ import annotations

import dataclasses
import random

import pytest
from mpmath import mp, mpf, workdps
from oracle import NUDGE, _laws_of, _nudged_laws, first_entry, solve
from shots import POOL_TABLE, R, ball, scene_of

from ghostball.engine import EventKind, Table

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
    assert run.velocities[0] == (0, 0, 0)
    assert run.rested


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
    assert mirrored.velocities[0] == (-1, 0.5, 0)
    law = {"cushion_restitution": 0.5, "cushion_tangential_restitution": 0.25}
    soft = solve(scene_of(start, cushion="restitution", **law, **fields))
    assert soft.velocities[0] == (-0.5, 0.125, 0)
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


def test_the_nudge_of_a_law_is_seen():
    laws = _laws_of(scene_of(ball((0, 0)), motion="sliding", ball_friction="alciatore"))
    nudged = _nudged_laws(laws, random.Random(1))
    for field in dataclasses.fields(laws):
        one, other = getattr(laws, field.name), getattr(nudged, field.name)
        if field.name == "friction":
            assert all(0 < abs(b / a - 1) < 2 * NUDGE for a, b in zip(one, other, strict=True))
        elif not isinstance(one, (bool, str)):
            assert 0 < abs(other / one - 1) < 2 * NUDGE


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


def test_the_state_at_an_instant():
    run = solve(scene_of(ball((0, 0), (1, 0)), ball((0.5, 0))))
    a, hit = deceleration(), run.events[0].t
    before, after = run.at(hit / 2), run.at(hit)
    assert abs(before[0].position[0] - (hit / 2 - a * (hit / 2) ** 2 / 2)) < TINY
    assert abs(before[0].velocity[0] - (1 - a * hit / 2)) < TINY
    assert abs(before[0].spin[1] - before[0].velocity[0] / mpf(R)) < 100 * TINY
    assert abs(after[0].velocity[0]) < TINY
    assert abs(after[1].velocity[0] - (1 - a * hit)) < TINY
    assert run.at(run.t_end)[1].position == run.positions[1]
