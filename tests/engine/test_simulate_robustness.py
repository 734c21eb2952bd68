"""Where engines break: grazes, ties of motion, contact, extreme numbers, crowded breaks."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from invariants import EPS, collisions, energies, instants, overlaps
from shots import POOL_TABLE, R, ball, random_break, scene_of
from whole_kernels import checks_bounds

from ghostball.engine import (
    Ball,
    EventKind,
    GhostballError,
    Physics,
    Result,
    Scene,
    Status,
    Table,
    simulate,
)

HIT = EventKind.BALL_BALL
ENOUGH_EVENTS = 20_000
"""Some twenty times what any of these breaks needs: more is a storm of contacts."""


class TestGrazing:
    """A ball passes a resting one at a given depth: below the sum of the radii is a hit."""

    @pytest.mark.parametrize("exponent", range(1, 14))
    @pytest.mark.parametrize("side", [-1, 1], ids=["hit", "miss"])
    @pytest.mark.parametrize("distance", [0.06, 0.5, 3.0])
    def test_along_an_axis_the_offset_decides_exactly(self, exponent, side, distance):
        offset = 2 * R * (1 + side * 10.0**-exponent)
        for velocity, place in (
            ((1.5, 0.0), (distance, offset)),
            ((0.0, 1.5), (-offset, distance)),
            ((-1.5, 0.0), (-distance, -offset)),
            ((0.0, -1.5), (offset, -distance)),
        ):
            result = simulate(scene_of(ball((0, 0), velocity), ball(place)), record="events")
            assert len(collisions(result)) == (1 if side < 0 else 0)

    @pytest.mark.parametrize("exponent", range(1, 13))
    @pytest.mark.parametrize("side", [-1, 1], ids=["hit", "miss"])
    @pytest.mark.parametrize("angle", [0.3, 1.2, 2.5, 4.0, 5.5])
    @pytest.mark.parametrize("friction", [0.0, 0.02])
    def test_along_any_line_the_doubles_decide(self, exponent, side, angle, friction):
        velocity = (1.5 * math.cos(angle), 1.5 * math.sin(angle))
        offset = 2 * R * (1 + side * 10.0**-exponent)
        place = (
            0.7 * math.cos(angle) - offset * math.sin(angle),
            0.7 * math.sin(angle) + offset * math.cos(angle),
        )
        # What the rounded numbers mean, in exact arithmetic: (r x v)^2 against D^2 v^2.
        (x, y), (vx, vy) = (map(Fraction, pair) for pair in (place, velocity))
        hits = (x * vy - y * vx) ** 2 < (2 * Fraction(R)) ** 2 * (vx**2 + vy**2)
        assert hits == (side < 0)
        scene = scene_of(ball((0, 0), velocity), ball(place), rolling_friction=friction, t_max=20.0)
        assert len(collisions(simulate(scene, record="events"))) == (1 if hits else 0)

    @pytest.mark.parametrize("exponent", range(1, 14))
    def test_a_grazing_hit_moves_the_other_ball_by_its_sliver(self, exponent):
        # The struck ball gets v sin(phi) with cos(phi) = offset / 2 R.
        offset = 2 * R * (1 - 10.0**-exponent)
        scene = scene_of(ball((0, 0), (1, 0)), ball((0.1, offset)), rolling_friction=0.0, t_max=1.0)
        struck = simulate(scene).final_state.velocities[0, 1]
        cos = Fraction(offset) / (2 * Fraction(R))
        speed = math.sqrt(1 - cos**2)
        # sin^2 is known to some ulp of 1, so sin to eps / sin.
        assert math.hypot(*struck) == pytest.approx(speed, abs=16 * EPS / speed)
        assert struck[0] >= 0.0
        assert struck[1] > 0.0


class TestTiesOfMotion:
    @pytest.mark.parametrize("friction", [0.0, 0.02])
    def test_a_swarm_with_one_velocity_never_collides(self, friction):
        balls = [ball((0.06 * i, 0.06 * j), (0.7, -0.3)) for i in range(3) for j in range(3)]
        scene = scene_of(*balls, rolling_friction=friction, t_max=5.0)
        result = simulate(scene, record="events")
        assert collisions(result) == []

    @pytest.mark.parametrize("offset", [0.0, 0.01, 0.05])
    def test_equal_speeds_head_on_meet_in_the_middle(self, offset):
        scene = scene_of(ball((0, 0), (1, 0)), ball((1, offset), (-1, 0)))
        result = simulate(scene, record="trajectory")
        assert collisions(result) == [(HIT, 0, 1)]
        centres = result.sample(result.events["t"][0]).positions[0]
        assert np.mean(centres[:, 0]) == pytest.approx(0.5, abs=4 * EPS)

    @pytest.mark.parametrize("direction", [(1, 0), (0, 1), (0.6, 0.8), (-0.8, 0.6), (0.3, -0.7)])
    @pytest.mark.parametrize("gap", [1e-9, 1e-3, 0.3])
    def test_catching_up_along_any_line(self, direction, gap):
        # No relative acceleration, but for rounding: dt = gap / dv.
        ux, uy = direction / np.hypot(*direction)
        apart = 2 * R + gap
        scene = scene_of(
            ball((0, 0), (ux, uy)),
            ball((apart * ux, apart * uy), (0.5 * ux, 0.5 * uy)),
        )
        result = simulate(scene, record="events")
        assert collisions(result) == [(HIT, 0, 1)]
        assert result.events["t"][0] == pytest.approx(2 * gap, rel=1e-13, abs=8 * EPS * 0.06)

    def test_a_slower_ball_behind_never_catches_up(self):
        scene = scene_of(ball((0, 0), (0.5, 0)), ball((2 * R + 1e-12, 0), (0.5000001, 0)))
        assert collisions(simulate(scene, record="events")) == []

    def test_two_balls_that_stop_at_one_instant(self):
        scene = scene_of(ball((0, 0), (1, 0)), ball((0, 1), (0, 1)))
        result = simulate(scene, record="events")
        assert result.events["t"][0] == result.events["t"][1] == result.rest_time


class TestTouchingAtTheStart:
    NORMALS = ((1.0, 0.0), (0.0, -1.0), (0.6, 0.8), (-0.28, 0.96))

    @staticmethod
    def pair(normal, velocity_a, velocity_b, **physics) -> Scene:
        place = (2 * R * normal[0], 2 * R * normal[1])
        return scene_of(ball((0, 0), velocity_a), ball(place, velocity_b), **physics)

    @pytest.mark.parametrize("normal", NORMALS)
    @pytest.mark.parametrize("speed", [1e-9, 1e-3, 1.0, 1e3])
    def test_receding(self, normal, speed):
        away = (-speed * normal[0], -speed * normal[1])
        assert collisions(simulate(self.pair(normal, away, (0, 0)), record="events")) == []

    @pytest.mark.parametrize("normal", NORMALS)
    def test_at_rest(self, normal):
        result = simulate(self.pair(normal, (0, 0), (0, 0)), record="events")
        assert (result.status, len(result.events)) == (Status.REST, 0)

    @pytest.mark.parametrize("normal", NORMALS)
    @pytest.mark.parametrize("speed", [1e-6, 1e-3, 1.0, 1e3])  # slower, a rounded gap is too far
    @pytest.mark.parametrize("e", [1.0, 0.5])
    def test_approaching(self, normal, speed, e):
        towards = (speed * normal[0], speed * normal[1])
        scene = self.pair(normal, towards, (0, 0), ball_restitution=e)
        result = simulate(scene, record="events")
        assert collisions(result) == [(HIT, 0, 1)]
        # "At once": the doubles may leave a gap of a rounding error of the positions.
        assert result.events["t"][0] * speed <= 2 * EPS * R

    @pytest.mark.parametrize("normal", NORMALS)
    @pytest.mark.parametrize("speed", [0.01, 1.0])
    def test_sliding_past_each_other(self, normal, speed):
        # Tangential to the contact: they part at once, quadratically, and never meet again.
        along = (-speed * normal[1], speed * normal[0])
        result = simulate(self.pair(normal, along, (0, 0)), record="trajectory")
        assert result.status is Status.REST
        assert overlaps(result.scene, result.sample(instants(result)).positions).max() <= 1e-15
        moved = np.linalg.norm(result.rest_positions[1] - result.scene.positions[1])
        assert moved <= 1e-12


class TestExtremeNumbers:
    @pytest.mark.parametrize("speed", [1e-9, 1e-6, 1e-3, 1.0, 1e2, 1e4])
    @pytest.mark.parametrize("radius", [1e-3, R, 1.0, 1e3])
    def test_a_full_hit_at_any_scale(self, speed, radius):
        # Close enough that the slow ones arrive: half of what the ball could roll.
        gap = 0.5 * speed**2 / (2 * 0.02 * 9.81)
        gap = max(gap, 64 * EPS * radius)
        scene = scene_of(
            ball((0, 0), (speed, 0), radius=radius), ball((2 * radius + gap, 0), radius=radius)
        )
        gap = scene.positions[1, 0] - 2 * radius  # as the doubles have it
        result = simulate(scene, record="events")
        assert result.status is Status.REST
        reaches = gap < speed**2 / (2 * 0.02 * 9.81)
        assert collisions(result) == ([(HIT, 0, 1)] if reaches else [])
        roll = speed**2 / (2 * 0.02 * 9.81)
        total = result.rest_positions[:, 0].sum() - scene.positions[:, 0].sum()
        assert total == pytest.approx(roll, rel=1e-12, abs=64 * EPS * radius)

    @pytest.mark.parametrize("ratio", [1e-12, 1e-6, 1e-3, 1e3, 1e6, 1e12])
    def test_any_ratio_of_masses(self, ratio):
        scene = scene_of(
            ball((0.2, 0.5), (1, 0), mass=ratio),
            ball((0.7, 0.5)),
            ball((1.2, 0.51), mass=1 / ratio),
            table=Table(length=1.5, width=1.0, cushions=("left", "right")),
            rolling_friction=0.05,
        )
        result = simulate(scene, record="trajectory", max_events=ENOUGH_EVENTS)
        assert_sound(result)

    def test_a_marble_between_giants(self):
        scene = scene_of(
            ball((0, 0), (0.1, 0), radius=1e3, mass=1e4),
            ball((1001.0, 0), (0, 0), radius=1e-3, mass=1.0),
            ball((2002.0, 0), (-0.1, 0), radius=1e3, mass=1e4),
            rolling_friction=0.0,
            t_max=30.0,
            impacts="sequential",
        )
        result = simulate(scene, record="trajectory", max_events=ENOUGH_EVENTS)
        assert_sound(result, permitted=1e-12 * 1e3)
        assert 100 < result.collision_counts["ball-ball"] < 1000  # some pi sqrt(M / 2m)

    @pytest.mark.parametrize("speed", [1e-9, 1e4])
    def test_a_break_at_any_speed(self, speed):
        scene = scene_of(
            ball((0.5, 0.635), (speed, 0)),
            *(ball((0.5 + 2.1 * R * (k + 1), 0.635 + 0.001 * k)) for k in range(4)),
            table=POOL_TABLE,
            rolling_friction=max(0.02, speed**2 / 50.0),  # a few lengths of table at most
        )
        assert_sound(simulate(scene, record="trajectory", max_events=ENOUGH_EVENTS))

    @pytest.mark.parametrize("position", [1e6, -1e9])
    def test_far_from_the_origin_the_balls_still_meet(self, position):
        scene = scene_of(ball((position, 0), (1, 0)), ball((position + 0.5, 0)))
        result = simulate(scene, record="events")
        assert collisions(result) == [(HIT, 0, 1)]
        ulp = EPS * abs(position)
        assert result.rest_positions[0, 0] == pytest.approx(position + 0.5 - 2 * R, abs=4 * ulp)


def assert_sound(result: Result, permitted: float = 1e-12) -> None:
    """Assert that a run ended by itself, without overlap, with energy that never rose."""
    assert result.status.complete, f"{result.status}: {result.reason}"
    times = instants(result, between=3)
    depth = overlaps(result.scene, result.sample(times).positions)
    worst = np.unravel_index(np.argmax(depth), depth.shape)
    assert depth[worst] <= permitted, f"overlap of {depth[worst]} m at t = {times[worst[0]]} s"
    energy = energies(result, times)
    rise = np.diff(energy)
    assert rise.max(initial=0.0) <= 16 * EPS * energy[0], (
        f"energy rises by {rise.max() / energy[0]} of the first at t = {times[rise.argmax()]} s"
    )


RESTITUTIONS = (1.0, 0.95, 0.5, 0.0)


@pytest.mark.parametrize("e", RESTITUTIONS)
def test_a_small_break(e):
    for seed in range(4):
        assert_sound(
            simulate(random_break(seed, n=5, e=e), record="trajectory", max_events=ENOUGH_EVENTS)
        )


# More of the same: where bounds are checked they run with the fast tests.
MORE = () if checks_bounds() else pytest.mark.slow


@pytest.mark.compiled
@pytest.mark.parametrize("e", RESTITUTIONS)
@pytest.mark.parametrize(
    "first", [0, 10, *(pytest.param(seed, marks=MORE) for seed in (20, 30, 40))]
)
def test_random_breaks_of_sixteen_end_at_rest_without_overlap(first, e):
    # With e = 0 and with a touching rack (every fourth seed) contact lasts: engines get stuck.
    for seed in range(first, first + 10):
        scene = random_break(seed, e=e)
        assert_sound(simulate(scene, record="trajectory", max_events=ENOUGH_EVENTS))


@pytest.mark.compiled
@pytest.mark.parametrize("cushion_restitution", [0.8, 0.0])
@pytest.mark.parametrize("e", RESTITUTIONS)
def test_random_breaks_with_lossy_cushions(e, cushion_restitution):
    law = {"cushion": "restitution", "cushion_restitution": cushion_restitution}
    for seed in range(100, 110):
        scene = random_break(seed, e=e, **law)
        assert_sound(simulate(scene, record="trajectory", max_events=ENOUGH_EVENTS))


@pytest.mark.slow
@pytest.mark.compiled
@pytest.mark.parametrize("e", RESTITUTIONS)
def test_many_breaks_are_never_stuck(e):
    # One that is perfectly plastic takes thirty times as long. The first 50 end above.
    stuck = [
        seed
        for seed in range(50, 500 if e > 0.0 else 150)
        if not simulate(random_break(seed, e=e), max_events=ENOUGH_EVENTS).status.complete
    ]
    assert stuck == []


@pytest.mark.compiled
@pytest.mark.parametrize("e", [1.0, 0.9])
def test_an_elastic_gas_without_friction_runs_on(e):
    balls = [
        ball((0.15 + 0.3 * i, 0.15 + 0.3 * j), (0.1 * (i - 1) + 0.05, 0.1 * (j + 1)))
        for i in range(4)
        for j in range(2)
    ]
    scene = scene_of(
        *balls,
        table=Table(length=1.2, width=0.6),
        rolling_friction=0.0,
        ball_restitution=e,
        t_max=60.0,
    )
    assert_sound(simulate(scene, record="trajectory", max_events=10 * ENOUGH_EVENTS))


def test_of_two_impacts_at_one_instant_the_faster_comes_first_in_any_order():
    """Judging only one pair of each ball's row would depend on the order of the balls."""
    slant = math.radians(70)
    balls = [
        Ball(id="m", position=(0.0, 0.0), velocity=(1.0, 0.5)),
        Ball(id="x", position=(2 * 0.028575, 0.0)),
        Ball(id="y", position=(2 * 0.028575 * math.cos(slant), 2 * 0.028575 * math.sin(slant))),
    ]
    ends = []
    for order in itertools.permutations(range(3)):
        one_by_one = Physics(impacts="sequential")
        scene = Scene(name="tie", balls=[balls[k] for k in order], physics=one_by_one)
        result = simulate(scene, record="events")
        assert {order[k] for k in result.events[0][["a", "b"]].tolist()} == {0, 1}
        ends.append(result.rest_positions[np.argsort(order)])
    assert all(np.array_equal(end, ends[0]) for end in ends)


def test_max_events_may_be_just_what_the_run_needs():
    scene = Scene(name="one", balls=[Ball(id="a", position=(0, 0), velocity=(1, 0))])
    assert simulate(scene, max_events=1).status is Status.REST


@pytest.mark.parametrize("wrong", [0, -1, 2.5, float("inf"), True, "a", None])
def test_max_events_must_be_a_whole_number(wrong):
    scene = Scene(name="one", balls=[Ball(id="a", position=(0, 0), velocity=(1, 0))])
    with pytest.raises(GhostballError, match="max_events"):
        simulate(scene, max_events=wrong)


def test_a_full_hit_along_an_axis_stops_the_cue_ball_exactly():
    rng = np.random.default_rng(5)
    for _ in range(100):
        x, v = rng.uniform(0.1, 0.9), rng.uniform(0.3, 3.0)
        cue = Ball(id="cue", position=(x, 0.5), velocity=(v, 0.0))
        scene = Scene(name="full", balls=[cue, Ball(id="object", position=(1.1, 0.5))])
        result = simulate(scene, record="events")
        kinds = result.events["kind"].tolist()
        assert kinds in ([EventKind.BALL_BALL, EventKind.ROLL_TO_REST], [EventKind.ROLL_TO_REST])
