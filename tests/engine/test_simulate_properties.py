"""What holds for every shot: conservation, symmetry, scaling, order of time, no overlap."""

from __future__ import annotations

import itertools
import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from invariants import (
    EPS,
    ball_impacts,
    collisions,
    energies,
    instants,
    log_bits,
    overlaps,
    state_bits,
)
from shots import POOL_TABLE, ball, random_break, random_shot, scene_of

from engine import Ball, EventKind, Result, Scene, Status, Table, simulate

LAWS = st.fixed_dictionaries(
    {
        "rolling_friction": st.sampled_from([0.005, 0.02, 0.3]),
        "ball_restitution": st.sampled_from([1.0, 0.95, 0.5]),
    }
)
TABLES = st.sampled_from(
    [None, POOL_TABLE, Table(length=2.54, width=1.27, cushions=("left", "top"))]
)


@st.composite
def shots(draw, tables=TABLES, laws=LAWS, most=6):
    """Return a random shot: seed, count, table and physics are what hypothesis shrinks."""
    n = draw(st.integers(1, most))
    return random_shot(draw(st.integers(0, 10_000)), n, table=draw(tables), **draw(laws))


def with_balls(scene: Scene, balls, **update) -> Scene:
    fields = {name: getattr(scene, name) for name in ("name", "physics", "table", "t_max")}
    return Scene(**{**fields, "balls": tuple(balls), **update})


def changed(one: Ball, **update) -> Ball:
    return Ball(**{**one.model_dump(exclude_none=True), **update})


def sensitivity(scene: Scene) -> float:
    """Measure how much the end of a run moves per relative change of its start; at least 1.

    A nudge of 1e-10 is far above rounding; where the events themselves change, the answer is inf.
    """
    chance = random.Random(0)

    def nudged(vector):
        scale = 1e-10 * max(map(abs, vector))
        return [component + scale * chance.uniform(-1, 1) for component in vector[:2]]

    base = simulate(scene, record="events")
    moved = with_balls(
        scene,
        [
            changed(one, position=nudged(one.position), velocity=nudged(one.velocity))
            for one in scene.balls
        ],
    )
    other = simulate(moved, record="events")
    if collisions(base) != collisions(other):
        return np.inf
    ends = [np.array(run.final_state[:2]) for run in (base, other)]
    return max(1.0, float(np.max(np.abs(ends[0] - ends[1]))) / 1e-10)


@given(shots())
def test_energy_never_rises(scene):
    # A push-apart, a floor on the separation speed or a wrong impulse would raise it.
    result = simulate(scene, record="trajectory")
    energy = energies(result, instants(result))
    assert np.all(np.diff(energy) <= 16 * EPS * energy[0])


@given(shots(laws=st.just({"rolling_friction": 0.0, "t_max": 3.0})))
def test_energy_stays_without_friction_or_losses(scene):
    result = simulate(scene, record="trajectory")
    energy = energies(result, instants(result))
    # Each collision may round it by a few ulp.
    assert np.all(np.abs(energy - energy[0]) <= (8 + 8 * len(result.events)) * EPS * energy[0])


@given(shots())
def test_momentum_survives_every_ball_impact(scene):
    result = simulate(scene, record="trajectory")
    masses = scene.masses
    for t, a, b in ball_impacts(result):
        if t == 0.0:
            continue
        before, after = result.sample([np.nextafter(t, 0.0), t]).velocities
        scale = masses[a] * np.abs(before[a]).max() + masses[b] * np.abs(before[b]).max()
        for i in range(len(masses)):
            if i not in (a, b):
                assert np.allclose(before[i], after[i], rtol=0, atol=8 * EPS * 10)
        momenta = [masses[a] * v[a] + masses[b] * v[b] for v in (before, after)]
        assert np.allclose(*momenta, rtol=0, atol=16 * EPS * scale)


@given(shots())
def test_an_impact_reverses_the_approach_with_its_restitution(scene):
    result = simulate(scene, record="trajectory")
    e = scene.physics.ball_restitution
    for t, a, b in ball_impacts(result):
        if t == 0.0:
            continue
        samples = result.sample([np.nextafter(t, 0.0), t])
        r = samples.positions[1, b] - samples.positions[1, a]
        r[2] = 0.0
        normal = r / np.linalg.norm(r)
        before, after = ((v[b] - v[a]) @ normal for v in samples.velocities)
        speeds = np.abs(samples.velocities[:, [a, b]]).max()
        assert before < 16 * EPS * speeds
        assert after == pytest.approx(-e * before, abs=64 * EPS * speeds)


@given(shots())
def test_nothing_overlaps_at_events_or_between(scene):
    # A missed collision shows as an overlap of the order of a radius.
    result = simulate(scene, record="trajectory")
    assert overlaps(scene, result.sample(instants(result, 20)).positions).max() <= 1e-13


@given(shots())
def test_balls_touch_when_they_collide(scene):
    # A phantom collision, at any distance, would show here.
    result = simulate(scene, record="trajectory")
    for t, a, b in ball_impacts(result):
        centres = result.sample(t).positions[0, :, :2]
        gap = np.linalg.norm(centres[a] - centres[b]) - scene.radii[a] - scene.radii[b]
        assert abs(gap) <= 1e-14


@given(shots())
def test_the_run_ends_at_rest_with_events_in_order_of_time(scene):
    result = simulate(scene, record="events")
    assert result.status is Status.REST
    assert not np.any(result.final_state.velocities)
    times = result.events["t"]
    assert np.all(np.diff(times) >= 0.0)
    assert result.rest_time == (times[-1] if len(times) else 0.0)
    pairs = result.events[result.events["kind"] == EventKind.BALL_BALL]
    assert np.all(pairs["a"] < pairs["b"])


@given(shots())
def test_every_record_gives_the_same_bits(scene):
    runs = {record: simulate(scene, record=record) for record in ("rest", "events", "trajectory")}
    assert len({state_bits(run) for run in runs.values()}) == 1
    assert log_bits(runs["events"]) == log_bits(runs["trajectory"])
    assert len({str(run.collision_counts) for run in runs.values()}) == 1


@given(shots())
def test_the_recorded_motion_ends_where_the_run_ended(scene):
    result = simulate(scene, record="trajectory")
    end = result.sample([result.rest_time, result.rest_time + 1.0])
    for sampled, final in zip(end, result.final_state, strict=True):
        assert np.allclose(sampled, final, rtol=0, atol=16 * EPS * (1 + np.abs(final)))
    start = result.sample(0.0).positions[0]
    assert np.array_equal(start, scene.positions)


@given(shots(most=5), st.randoms(use_true_random=False))
def test_the_order_of_the_balls_does_not_matter(scene, chance):
    # Results that depend on labels are FastFiz's defect. Same bits, since + and * commute.
    order = list(range(len(scene.balls)))
    chance.shuffle(order)
    base = simulate(scene, record="events")
    other = simulate(with_balls(scene, [scene.balls[i] for i in order]), record="events")
    assert same_log(base, other, order)
    assert np.array_equal(other.rest_positions, base.rest_positions[order])


def same_log(base: Result, other: Result, order: list[int]) -> bool:
    """Whether `other`, whose ball k is ball order[k] of `base`, has the same events to the bit."""

    def row(event, name):
        kind, a, b = int(event["kind"]), name(event["a"]), int(event["b"])
        if kind == EventKind.BALL_BALL:
            a, b = sorted((a, name(event["b"])))
        return float(event["t"]).hex(), kind, a, b

    return sorted(row(event, int) for event in base.events) == sorted(
        row(event, lambda i: order[int(i)]) for event in other.events
    )


MIRRORS = {
    "left-right": lambda x, y: (-x, y),
    "up-down": lambda x, y: (x, -y),
    "diagonal": lambda x, y: (y, x),
    "half turn": lambda x, y: (-x, -y),
}


@pytest.mark.parametrize("mirror", MIRRORS.values(), ids=MIRRORS.keys())
@given(scene=shots(tables=st.none()))
def test_a_mirror_image_of_the_cloth_gives_the_mirror_image_to_the_bit(mirror, scene):
    image = with_balls(
        scene,
        [
            changed(one, position=mirror(*one.position[:2]), velocity=mirror(*one.velocity[:2]))
            for one in scene.balls
        ],
    )
    base, other = simulate(scene, record="events"), simulate(image, record="events")
    assert log_bits(base) == log_bits(other)
    x, y = mirror(base.rest_positions[:, 0], base.rest_positions[:, 1])
    assert np.array_equal(other.rest_positions[:, :2], np.stack([x, y], axis=1))


@given(shots(tables=st.just(POOL_TABLE)))
def test_a_diagonal_mirror_image_of_a_table_gives_the_mirror_image_to_the_bit(scene):
    image = with_balls(
        scene,
        [
            changed(one, position=one.position[1::-1], velocity=one.velocity[1::-1])
            for one in scene.balls
        ],
        table=Table(length=scene.table.width, width=scene.table.length),
    )
    base, other = simulate(scene, record="events"), simulate(image, record="events")
    assert base.events["t"].tobytes() == other.events["t"].tobytes()
    assert np.array_equal(other.rest_positions[:, :2], base.rest_positions[:, 1::-1])


@given(shots(), st.integers(-3, 3))
def test_lengths_times_4_and_speeds_times_2_change_no_bit(scene, k):
    # g and mu stay, so a = mu g does; powers of two commute with + - * / and sqrt. An absolute
    # tolerance on a gap, a speed or the clock would show as other bits.
    length, speed = 4.0**k, 2.0**k
    balls = [
        changed(
            one,
            position=[length * c for c in one.position[:2]],
            velocity=[speed * c for c in one.velocity[:2]],
            radius=length * one.radius,
        ).model_copy(update={"position": tuple(length * c for c in one.position)})
        for one in scene.balls
    ]
    table = scene.table
    if table is not None:
        table = Table(
            length=length * table.length, width=length * table.width, cushions=table.cushions
        )
    base = simulate(scene, record="events")
    other = simulate(with_balls(scene, balls, table=table), record="events")
    assert collisions(base) == collisions(other)
    assert np.array_equal(other.events["t"], speed * base.events["t"])
    assert np.array_equal(other.rest_positions, length * base.rest_positions)


@given(shots(), st.integers(-40, 40))
def test_masses_times_a_power_of_two_change_no_bit(scene, k):
    heavier = [changed(one, mass=one.mass * 2.0**k) for one in scene.balls]
    base = simulate(scene, record="events")
    other = simulate(with_balls(scene, heavier), record="events")
    assert log_bits(base) == log_bits(other)
    assert state_bits(base) == state_bits(other)


@given(shots(most=4), st.sampled_from([1, 2, 3]))
def test_faster_play_without_friction_is_the_same_path_sooner(scene, k):
    free = {"physics": scene.physics.model_copy(update={"rolling_friction": 0.0})}
    slow = with_balls(scene, scene.balls, t_max=2.0, **free)
    fast = with_balls(
        scene,
        [changed(one, velocity=[2.0**k * c for c in one.velocity[:2]]) for one in scene.balls],
        t_max=2.0 / 2.0**k,
        **free,
    )
    base, other = simulate(slow, record="events"), simulate(fast, record="events")
    assert collisions(base) == collisions(other)
    assert np.array_equal(other.events["t"] * 2.0**k, base.events["t"])
    assert np.array_equal(other.rest_positions, base.rest_positions)


@given(shots(tables=st.none(), most=4), st.sampled_from([(1.0, 0.0), (-4.0, 2.0), (16.0, -8.0)]))
def test_where_on_an_unbounded_cloth_does_not_matter_beyond_rounding(scene, shift):
    def on_grid(vector):  # so that shifting is exact and only the engine's rounding differs
        return [round(component * 2**30) / 2**30 for component in vector[:2]]

    base = with_balls(scene, [changed(one, position=on_grid(one.position)) for one in scene.balls])
    moved = with_balls(
        scene,
        [
            changed(one, position=[c + s for c, s in zip(one.position, shift, strict=False)])
            for one in base.balls
        ],
    )
    growth = sensitivity(base)
    if growth * EPS > 1e-9:
        return  # chaos: nothing to compare
    first, second = simulate(base, record="events"), simulate(moved, record="events")
    assert collisions(first) == collisions(second)
    apart = second.rest_positions[:, :2] - shift - first.rest_positions[:, :2]
    assert np.max(np.abs(apart)) <= 64 * EPS * 16.0 * growth


@given(st.integers(0, 10_000), st.integers(2, 5))
def test_elastic_play_without_friction_runs_backwards(seed, n):
    # A few balls, large on their table, so that some ten collisions amplify little.
    chance = random.Random(seed)
    places = chance.sample(list(itertools.product((0.2, 0.5, 0.8), (0.2, 0.5, 0.8))), n)
    balls = [
        ball(place, (chance.uniform(-1, 1), chance.uniform(-1, 1)), radius=0.1, mass=1.0 + k % 2)
        for k, place in enumerate(places)
    ]
    scene = scene_of(*balls, table=Table(length=1.0, width=1.0), rolling_friction=0.0, t_max=1.25)
    growth = sensitivity(scene)
    there = simulate(scene, record="events")
    back = with_balls(
        scene,
        [
            changed(one, position=position[:2].tolist(), velocity=(-velocity[:2]).tolist())
            for one, position, velocity in zip(
                scene.balls, *(array[0] for array in there.final_state[:2]), strict=True
            )
        ],
    )
    growth = max(growth, sensitivity(back))
    if growth * EPS > 1e-9:
        return  # chaos: nothing to compare
    home = simulate(back, record="events")
    assert sorted(collisions(home)) == sorted(collisions(there))
    assert np.max(np.abs(home.rest_positions - scene.positions)) <= 256 * EPS * growth
    assert np.max(np.abs(home.final_state.velocities[0] + scene.velocities)) <= 256 * EPS * growth


@given(shots(most=4))
def test_a_far_away_resting_ball_changes_nothing(scene):
    lonely = ball((50.0, 50.0)) if scene.table is None else None
    if lonely is None:
        return
    more = with_balls(scene, [*scene.balls, Ball(id="lonely", **lonely)])
    base, other = simulate(scene, record="events"), simulate(more, record="events")
    assert log_bits(base) == log_bits(other)
    assert np.array_equal(base.rest_positions, other.rest_positions[:-1])


@pytest.mark.compiled
@given(st.integers(0, 10_000))
def test_a_break_keeps_the_same_bits_whatever_is_recorded(seed):
    scene = random_break(seed, e=0.95)
    assert state_bits(simulate(scene)) == state_bits(simulate(scene, record="trajectory"))
