"""Tests that every shot ends or reacts to Ctrl-C: no loop of the kernels is endless."""

from __future__ import annotations

import math

import pytest
from interrupts import ctrl_c
from shots import POOL_TABLE, R, ball, scene_of

from ghostball.engine import simulate
from ghostball.model import Scene, Status, Table

K = 0.0041


def along_a_cushion(**physics) -> Scene:
    return scene_of(ball((0.5, R), (1.0, 0.0)), table=POOL_TABLE, air_drag=K, **physics)


def displacement_in_air(speed: float) -> float:
    """Return how far a ball with the paper's physics rolls in air: v dv/dx = -(mu g + k v^2)."""
    return math.log1p(K * speed * speed / (0.02 * 9.81)) / (2.0 * K)


def test_a_cushion_that_a_ball_touches_doesnt_change_its_roll_in_air():
    """A bound once included the jerk along the cushion, and the kernel never returned."""
    result = simulate(along_a_cushion(), max_work=10**5)
    far = 0.5 + displacement_in_air(1.0)
    mirrored = 2.0 * (POOL_TABLE.length - R) - far
    assert result.status is Status.REST
    assert result.rest_positions[0] == pytest.approx([mirrored, R, R], abs=1e-13)
    assert result.collision_counts["ball-cushion"] == 1


@pytest.mark.parametrize("preset", ["pool", "pool-coulomb"])
@pytest.mark.parametrize("width", [1.27, 2.0 * R], ids=["table", "channel"])
@pytest.mark.parametrize("spin", [None, (0.0, 0.0, 0.0), (5.0, -3.0, 20.0)])
def test_a_ball_that_slides_along_a_cushion_in_air_ends(preset, width, spin):
    scene = scene_of(
        ball((0.5, R), (1.0, 0.0), **({} if spin is None else {"angular_velocity": spin})),
        table=Table(length=2.54, width=width), preset=preset, air_drag=K,
    )  # fmt: skip
    assert simulate(scene, max_work=10**7).status is Status.REST


@pytest.mark.compiled
def test_two_balls_frozen_into_a_corner_in_air_end():
    scene = scene_of(
        ball(
            (0.2080354702103901, 0.10498377100129791),
            (-4.834549850558149, -3.020199430107958),
            angular_velocity=(18.92442777002959, -37.9390405146109, -22.997302566648262),
        ),
        ball((R, R)), ball((3.0 * R, R)),
        table=POOL_TABLE, preset="pool-coulomb", air_drag=K, ball_restitution=0.0,
    )  # fmt: skip
    assert simulate(scene, max_work=10**7).status is Status.REST


@pytest.mark.compiled
def test_a_ball_that_bounces_without_room_and_without_loss_stands_still():
    """The distance of two noses is the diameter of the ball, so all impacts have the same time."""
    scene = scene_of(
        ball((0.5, R), (1.0, 0.1)), table=Table(length=2.54, width=2.0 * R), cushion="mirror"
    )
    result = simulate(scene)
    assert result.status is Status.ENDLESS
    assert "the clock stands still" in result.reason
    named = '`ball_restitution` is 1 and `cushion` is "mirror"'
    assert f"Give them room, or make impacts lose energy: now {named}" in result.reason
    lossy = scene_of(
        ball((0.5, R), (1.0, 0.1)), table=Table(length=2.54, width=2.0 * R),
        cushion="restitution", cushion_restitution=0.85,
    )  # fmt: skip
    assert simulate(lossy, max_work=10**6).status is Status.REST


@pytest.mark.compiled
def test_elastic_balls_that_fill_a_row_between_two_posts_end_the_run_early():
    """The impulse travels through the row every 1e-15 s, so the clock hardly advances."""
    posts = [{"centre": (0.6, 0.5 + side * (3.0 * R + 0.02)), "radius": 0.02} for side in (-1, 1)]
    row = [ball((0.6, 0.5 + k * 2.0 * R)) for k in (-1, 0, 1)]

    def struck(**physics) -> Scene:
        table = Table(length=2.0, width=1.0, posts=posts)
        return scene_of(ball((0.3, 0.503), (1.5, 0.0)), *row, table=table, preset="pool", **physics)

    elastic = simulate(struck(ball_restitution=1.0, cushion="mirror"), max_work=3 * 10**6)
    assert elastic.status is Status.ENDLESS
    assert simulate(struck(), max_work=3 * 10**6).status is Status.REST


@pytest.mark.compiled
def test_a_shot_without_end_is_ended_by_ctrl_c():
    scene = scene_of(
        ball((0.5, 0.5), (1.0, 0.3)), table=POOL_TABLE, rolling_friction=0.0, t_max=1e50
    )
    simulate(scene, max_events=2)
    with pytest.raises(KeyboardInterrupt), ctrl_c():
        simulate(scene, max_events=2**62, max_work=2**62)
