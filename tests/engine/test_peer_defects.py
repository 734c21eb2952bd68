"""Where other engines were measured to fail: here each of those shots has its true answer.

pooltool 0.6.0, FastFiz, tailuge/billiards, python-billiards 0.5.0, poolvr.py.
"""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from invariants import EPS, collisions, energies, instants, overlaps
from mpmath import mp, mpf, workdps
from sampling import (
    once_rolling,
    state_at,
    state_before,
    times_of,
)
from shots import POOL_TABLE, R, ball, rack, scene_of

from ghostball.engine import EventKind, Result, Status, simulate

HIT, CUSHION = EventKind.BALL_BALL, EventKind.BALL_CUSHION
ROOT3 = math.sqrt(3)
POOL = {"preset": "pool"}
ENOUGH = 20_000
"""Events and contact steps: more is a storm of contacts."""

MOTIONS = pytest.mark.parametrize("motion", ["rolling", "sliding"])
CUSHION_LAWS = {
    "mirror": {"cushion": "mirror"},
    "restitution": {"cushion": "restitution", "cushion_restitution": 0.8},
    "frictional": {"cushion": "frictional", "cushion_restitution": 0.85},
    "han2005": {"cushion": "han2005", "cushion_restitution": 0.85},
    "mathavan2010": {"cushion": "mathavan2010", "cushion_restitution": 0.98},
}


class TestPhantomCollisions:
    """pooltool: balls with the same acceleration collide at t = 0, at any distance.

    FastFiz misses the collision altogether.
    """

    @pytest.mark.parametrize("angle", np.linspace(0.0, 360.0, 33)[:-1].tolist())
    def test_catching_up_in_any_direction_sliding_or_rolling(self, angle):
        x, y = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        for spin in ({}, {"angular_velocity": (0.0, 0.0, 0.0)}):
            scene = scene_of(
                ball((0.0, 0.0), (4 * x, 4 * y), **spin),
                ball((0.3 * x, 0.3 * y), (3 * x, 3 * y), **spin),
                motion="sliding",
            )
            # Both slow alike until one rolls; that takes longer than to meet.
            t = times_of(simulate(scene, record="events"), HIT)[0]
            assert t == pytest.approx(0.3 - 2 * R, rel=1e-13)


class TestEscapes:
    """pooltool: a ball that touches a cushion and moves into it leaves the table."""

    @pytest.mark.parametrize("law", CUSHION_LAWS.values(), ids=CUSHION_LAWS.keys())
    @pytest.mark.parametrize("spin", [None, (0.0, 0.0, 0.0), (-30.0, 40.0, 50.0)])
    @pytest.mark.parametrize(
        ("place", "velocity", "cushion"),
        [
            ((R, 0.5), (-1.0, 0.25), 0),
            ((2.54 - R, 0.5), (1.0, 0.25), 1),
            ((0.5, R), (0.25, -1.0), 2),
            ((0.5, 1.27 - R), (0.25, 1.0), 3),
        ],
    )
    def test_touching_a_cushion_and_moving_into_it(self, law, spin, place, velocity, cushion):
        fields = {} if spin is None else {"angular_velocity": spin}
        scene = scene_of(ball(place, velocity, **fields), table=POOL_TABLE, motion="sliding", **law)
        result = simulate(scene, record="events")
        assert result.status is Status.REST
        assert collisions(result)[0] == (CUSHION, 0, cushion)
        assert result.events["t"][0] <= EPS  # a double 2.54 - R may leave a gap of a rounding
        positions = result.sample(instants(result, 50)).positions
        assert overlaps(scene, positions).max() <= 4 * EPS * 2.54

    @pytest.mark.parametrize("law", CUSHION_LAWS.values(), ids=CUSHION_LAWS.keys())
    def test_touching_a_cushion_and_curving_into_it(self, law):
        # Moving along it, with a spin that pulls the sliding ball towards it.
        scene = scene_of(
            ball((0.5, R), (1.0, 0.0), angular_velocity=(60.0, 0.0, 0.0)),
            table=POOL_TABLE,
            motion="sliding",
            **law,
        )
        result = simulate(scene, record="events", max_events=ENOUGH)
        assert result.status is Status.REST
        positions = result.sample(instants(result, 50)).positions
        assert overlaps(scene, positions).max() <= 1e-12


class TestFrozenBalls:
    def test_a_symmetric_hit_on_two_touching_balls(self):
        # pooltool: 1.65 and 0.83 m/s.
        scene = scene_of(
            ball((-0.2, 0.0), (2.0, 0.0)),
            ball((ROOT3 * R, R)),
            ball((ROOT3 * R, -R)),
            motion="sliding",
        )
        result = simulate(scene, record="events")
        first, second = times_of(result, HIT)[:2]
        assert first == second
        v = state_before(result, first).velocities[0, 0]
        struck = state_at(result, first).velocities[1:, :2]
        assert struck[0].tolist() == [struck[1, 0], -struck[1, 1]]
        assert np.hypot(*struck[0]) == pytest.approx(2 * ROOT3 / 5 * v, rel=1e-13)

    @pytest.mark.compiled
    @pytest.mark.parametrize(
        ("offset", "e", "n"),
        [
            (0.0, 1.0, 8),
            (0.0, 0.95, 8),
            (0.0, 0.5, 8),
            (0.001, 0.95, 8),
            (0.001, 0.5, 8),
        ],
    )
    def test_a_frozen_line(self, offset, e, n):
        # pooltool, with eight: 11 219 events in 17 s, and balls pass through each other.
        line = [ball((0.5 + 2 * R * k, 0.0)) for k in range(n)]
        scene = scene_of(
            ball((0.0, offset), (2.0, 0.0)),
            *line,
            motion="sliding",
            ball_restitution=e,
            ball_friction="alciatore",
        )
        result = simulate(scene, record="events", max_events=ENOUGH)
        assert result.status is Status.REST
        assert result.work["events"] < 1000
        positions = result.sample(instants(result, 20)).positions
        assert overlaps(scene, positions).max() <= 1e-12
        assert np.all(np.diff(positions[:, 1:, 0], axis=1) > 0.0)  # none passes its neighbour
        assert_energy_never_rises(result)

    def test_zero_gap_racks(self):
        # FastFiz throws an exception on 2 % of them.
        for seed in range(40):
            chance = random.Random(seed)
            n = chance.choice([3, 6, 9, 10, 15])
            place = (chance.uniform(1.5, 1.9), chance.uniform(0.5, 0.77))
            v, aim = chance.uniform(2.0, 9.0), chance.uniform(-0.03, 0.03)
            scene = scene_of(
                ball((0.5, place[1]), (v * math.cos(aim), v * math.sin(aim))),
                *rack(n, place, 0.0),
                table=POOL_TABLE,
                **POOL,
            )
            assert simulate(scene, max_events=ENOUGH).status is Status.REST


class TestOverlap:
    """python-billiards: balls that overlap by more than 1e-10 pass through each other."""

    @MOTIONS
    @pytest.mark.parametrize("angle", np.linspace(0.0, 360.0, 17)[:-1].tolist())
    def test_an_overlap_by_rounding_collides_at_once(self, motion, angle):
        x, y = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        for ulps in (0, 1, 2, 4):
            apart = 2 * R * (1 - ulps * EPS)
            scene = scene_of(ball((0, 0), (x, y)), ball((apart * x, apart * y)), motion=motion)
            result = simulate(scene, record="events")
            assert collisions(result) == [(HIT, 0, 1)]
            assert times_of(result, HIT)[0] <= EPS
            end = state_at(result, times_of(result, HIT)[0])
            assert np.max(np.abs(end.velocities[0])) <= 8 * EPS


def test_no_time_step_moves_the_path():
    """tailuge/billiards, in steps of 1/512 s: 3.8 mm off at 1 s, 28 mm at rest."""
    velocity, spin = (1.3, 0.4), (35.0, -20.0, 15.0)
    scene = scene_of(
        ball((0.0, 0.0), velocity, angular_velocity=spin), motion="sliding", rolling_friction=0.01
    )
    result = simulate(scene, record="events")
    with workdps(40):
        g, radius = mpf(9.81), mpf(R)
        slide, roll = mpf(0.2) * g, mpf(0.01) * g
        v = [mpf(c) for c in velocity]
        slip = [v[0] - radius * mpf(spin[1]), v[1] + radius * mpf(spin[0])]
        size = mp.hypot(*slip)
        t1 = 2 * size / (7 * slide)
        place = [v[k] * t1 - slide * slip[k] / size * t1**2 / 2 for k in (0, 1)]
        v = [v[k] - 2 * slip[k] / 7 for k in (0, 1)]
        fast = mp.hypot(*v)
        assert once_rolling(result, 0)[0] == pytest.approx(float(t1), rel=8 * EPS)
        for t in (mpf(1), t1 + fast / roll):
            s = t - t1
            exact = [float(place[k] + v[k] * s - roll * v[k] / fast * s**2 / 2) for k in (0, 1)]
            found = result.sample([float(t)]).positions[0, 0, :2]
            assert found == pytest.approx(exact, abs=32 * EPS * 10)
        assert result.rest_positions[0, :2] == pytest.approx(exact, abs=32 * EPS * 10)


def assert_energy_never_rises(result: Result) -> None:
    energy = energies(result, instants(result, 5))
    assert np.diff(energy).max() <= 16 * EPS * energy[0]
