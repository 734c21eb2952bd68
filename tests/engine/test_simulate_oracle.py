"""The engine against the mpmath oracle on random shots, event by event."""

from __future__ import annotations

import dataclasses
from functools import cache

import pytest
from comparison import check_against_oracle, compare
from mpmath import workdps
from oracle import DIGITS, OracleRun, solve
from shots import (
    POOL_TABLE,
    ball,
    random_break,
    random_cloth_shot,
    random_shot,
    scene_of,
)

from ghostball.engine import Physics, Scene, Table, simulate

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


# Every count of balls and every law, on two tables.
FAST = (2, 6, 10, 41, 53, 59)


@pytest.mark.parametrize("seed", FAST)
def test_random_shots_agree_event_by_event(seed):
    check_against_oracle(shot(seed))


@pytest.mark.parametrize("seed", [1, 2, 5])
def test_the_first_collisions_of_a_break_agree(seed):
    agreement = check_against_oracle(random_break(seed, n=7), max_ball_collisions=3)
    assert agreement.ball_collisions >= 1


# See `test_the_fast_shots_on_the_cloth_have_every_law`.
FAST_ON_CLOTH = (0, 6, 7, 8, 11, 18, 22, 25, 27, 28)


@pytest.mark.parametrize("seed", FAST_ON_CLOTH)
def test_random_shots_on_the_cloth_agree_event_by_event(seed):
    check_against_oracle(random_cloth_shot(seed))


def test_the_fast_shots_have_every_law_and_count_of_balls():
    assert {seed // 5 % len(LAWS) for seed in FAST} == set(range(len(LAWS)))
    assert {len(shot(seed).balls) for seed in FAST} == {2, 3, 4, 5, 6}


def test_the_fast_shots_on_the_cloth_have_every_law():
    scenes = [random_cloth_shot(seed) for seed in FAST_ON_CLOTH]
    cushioned = [scene.physics.cushion for scene in scenes if scene.table is not None]
    assert set(cushioned) == {"mirror", "restitution", "frictional", "han2005"}
    assert {len(scene.balls) for scene in scenes} == {2, 3, 4, 5}
    frictions = [scene.physics.ball_friction for scene in scenes]
    assert {0.0, "alciatore"} < set(frictions)
    assert any(scene.balls[0].sliding_friction is not None for scene in scenes)
    for friction in ("sliding_friction", "rolling_friction", "spinning_friction_rate"):
        assert any(getattr(scene.physics, friction) == 0.0 for scene in scenes)
    assert {scene.physics.ball_restitution == 1.0 for scene in scenes} == {False, True}
    assert any(scene.table is None for scene in scenes)


def test_two_slides_that_end_together_are_compared_in_any_order():
    # Without ball friction a rolling ball and the resting one that it hits slip alike.
    scene = scene_of(
        ball((0.3, 0.3), (1.5, 0.1)), ball((0.8, 0.35)), table=POOL_TABLE, motion="sliding"
    )
    agreement = check_against_oracle(scene)
    assert agreement.ties >= 1
    assert agreement.reached_the_end


def caught_by_the_comparison() -> Scene:
    """Return a shot that every coefficient takes part in: two cushions, a hit, slides, side."""
    return scene_of(
        ball((0.3, 0.3), (1.2, 0.9), angular_velocity=(20.0, -30.0, 40.0)),
        ball((0.55, 0.49), sliding_friction=0.25, rolling_friction=0.012, mass=0.2),
        table=Table(length=0.9, width=0.7),
        motion="sliding",
        ball_restitution=0.93,
        ball_friction=0.06,
        cushion="han2005",
        cushion_restitution=0.8,
        cushion_friction=0.17,
        cushion_height=0.036,
    )


@cache
def truth_and_nudged() -> tuple[OracleRun, list[OracleRun]]:
    scene = caught_by_the_comparison()
    limits = {"max_ball_collisions": 6, "max_events": 60}
    return solve(scene, **limits), [solve(scene, nudge_seed=k, **limits) for k in (1, 2)]


COEFFICIENTS = (
    "gravity",
    "rolling_friction",
    "sliding_friction",
    "spinning_friction_rate",
    "ball_restitution",
    "ball_friction",
    "cushion_restitution",
    "cushion_friction",
    "cushion_height",
)


@pytest.mark.parametrize("field", COEFFICIENTS)
def test_the_comparison_sees_a_coefficient_that_is_off(field):
    # It must be able to fail: one part in 1e10 is a hundred thousand roundings.
    scene = caught_by_the_comparison()
    off = dict(scene.physics, **{field: getattr(scene.physics, field) * (1 + 1e-10)})
    wrong = simulate(scene.model_copy(update={"physics": Physics(**off)}), record="events")
    with workdps(DIGITS), pytest.raises(AssertionError, match="roundings"):
        compare(wrong, *truth_and_nudged())


def test_the_comparison_sees_events_that_are_missing_or_too_many():
    right = simulate(caught_by_the_comparison(), record="events")
    truth, nudged = truth_and_nudged()
    with workdps(DIGITS):
        assert compare(right, truth, nudged).reached_the_end
        for events in (right.events[:-1], right.events[[*range(len(right.events)), -1]]):
            with pytest.raises(AssertionError, match="event"):
                compare(dataclasses.replace(right, events=events), truth, nudged)
