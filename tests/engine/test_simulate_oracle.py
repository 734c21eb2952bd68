"""The engine against the mpmath oracle on random shots, event by event."""

from __future__ import annotations

from functools import cache

import pytest
from comparison import check_against_oracle
from mpmath import mp, mpf, workdps
from oracle import DIGITS, solve
from shots import POOL_TABLE, R, ball, random_break, random_shot, scene_of

from engine import EventKind, Scene, Table, simulate

TABLES = (
    POOL_TABLE,
    None,
    Table(length=0.9, width=0.7),
    Table(length=1.2, width=1.0, cushions=("left", "bottom")),
)
LAWS = (
    {},
    {"ball_restitution": 0.95, "rolling_friction": 0.01},
    {
        "ball_restitution": 0.5,
        "cushion": "restitution",
        "cushion_restitution": 0.8,
        "cushion_tangential_restitution": 0.9,
    },
    {"rolling_friction": 0.0, "t_max": 2.0},
)


def shot(seed: int) -> Scene:
    """Every count of balls from 2 to 6, with every law, on every table, in turn."""
    return random_shot(seed, 2 + seed % 5, table=TABLES[seed // 20 % 4], **LAWS[seed // 5 % 4])


@pytest.mark.parametrize("seed", [*range(0, 20, 2), *range(41, 60, 3)])
def test_random_shots_agree_event_by_event(seed):
    check_against_oracle(shot(seed))


@pytest.mark.slow
@pytest.mark.parametrize("first", range(1000, 1010))
def test_many_random_shots_agree_event_by_event(first):
    agreements = [check_against_oracle(shot(seed)) for seed in range(first, 1200, 10)]
    # The comparison must not have been empty: chaos or a table too wide would make it so.
    assert sum(one.events for one in agreements) > 60
    assert sum(one.ball_collisions for one in agreements) > 5
    assert sum(one.reached_the_end for one in agreements) >= 10


@pytest.mark.parametrize("seed", [1, 2, 5])
def test_the_first_collisions_of_a_break_agree(seed):
    agreement = check_against_oracle(random_break(seed, n=7), max_ball_collisions=3)
    assert agreement.ball_collisions >= 1


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1, 12, 2))
def test_more_of_a_break_agrees(seed):
    agreement = check_against_oracle(random_break(seed, n=11, e=0.95), max_ball_collisions=12)
    assert agreement.ball_collisions >= 2


def slowing_pair(y: float) -> Scene:
    """Two balls that slow down along different lines: the true quartic decides whether they hit."""
    return scene_of(ball((0, 0), (1.3, 0.2)), ball((0.6, y), (0.5, -0.4)))


@cache
def graze():
    """Return the y at which `slowing_pair` just grazes, and how its gap grows with y."""
    low, high = mpf("0.4"), mpf("0.6")
    assert closest_gap(slowing_pair(float(low))) < 0 < closest_gap(slowing_pair(float(high)))
    for _ in range(50):
        middle = (low + high) / 2
        if closest_gap(slowing_pair(float(middle))) < 0:
            low = middle
        else:
            high = middle
    h = 2.0**-20
    y = float(low)
    return y, (closest_gap(slowing_pair(y + h)) - closest_gap(slowing_pair(y - h))) / (2 * h)


@pytest.mark.parametrize("exponent", range(1, 14))
@pytest.mark.parametrize("side", [-1, 1], ids=["hit", "miss"])
def test_a_near_graze_of_two_slowing_balls_is_told_from_a_miss(side, exponent):
    with workdps(DIGITS):
        wanted = side * mpf(10) ** -exponent * 2 * R
        y, slope = graze()
        scene = slowing_pair(float(y + wanted / slope))
        gap = closest_gap(scene)
        assert abs(gap - wanted) < abs(wanted) / 2  # the doubles still mean what is asked for
    result = simulate(scene, record="events")
    assert (result.collision_counts["ball-ball"] > 0) == (side < 0)
    if side < 0:
        assert result.events["kind"][0] == EventKind.BALL_BALL


def closest_gap(scene: Scene):
    """Least distance of two balls' surfaces [m] while both roll, were they to pass through."""
    a, b = scene.balls
    deceleration = mpf(scene.physics.rolling_friction) * mpf(scene.physics.gravity)

    def place(one, t):
        speed = mp.hypot(*map(mpf, one.velocity[:2]))
        rolled = t - deceleration * t**2 / (2 * speed)
        return [mpf(p) + mpf(v) * rolled for p, v in zip(one.position, one.velocity, strict=True)]

    def distance(t):
        pa, pb = place(a, t), place(b, t)
        return mp.hypot(pb[0] - pa[0], pb[1] - pa[1])

    low, high = mpf(0), mpf("1.2")
    for _ in range(80):  # ternary search: one minimum in this window; the gap is flat there
        one, two = low + (high - low) / 3, high - (high - low) / 3
        if distance(one) < distance(two):
            high = two
        else:
            low = one
    return distance((low + high) / 2) - mpf(a.radius) - mpf(b.radius)


def test_the_window_of_the_graze_holds_the_oracles_hit():
    # `closest_gap` looks at 0 to 1.2 s only: the hit that it decides about must lie inside.
    run = solve(slowing_pair(0.45), max_ball_collisions=1)
    assert run.events[-1].kind is EventKind.BALL_BALL
    assert 0.1 < run.t_end < 1.1
