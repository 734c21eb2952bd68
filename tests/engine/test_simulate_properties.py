"""What holds for every shot: conservation, symmetry, scaling, order of time, no overlap."""

from __future__ import annotations

import itertools
import random

import numpy as np
import pytest
from hypothesis import given, strategies as st
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
from shot_strategies import all_shots, shots, sliding_shots, spun
from shots import POOL_TABLE, ball, random_break, scene_of
from transforms import (
    MAPS,
    changed,
    image,
    same_log,
    scaled,
    sensitivity,
    shuffled,
    spin_under,
    with_balls,
)

from ghostball.engine import Ball, EventKind, Scene, Status, Table, simulate


@given(all_shots())
def test_energy_never_rises(scene):
    # A push-apart, a floor on the separation speed or a wrong impulse would raise it.
    result = simulate(scene, record="trajectory")
    energy = energies(result, instants(result))
    assert np.all(np.diff(energy) <= 16 * EPS * energy[0])


FREE = {"rolling_friction": 0.0, "t_max": 3.0}
INTEGRATED = {"mathavan2014", "mathavan2010"}


@given(
    st.one_of(
        shots(laws=st.just(FREE)),
        sliding_shots(
            laws=st.just(
                {
                    **FREE,
                    "motion": "sliding",
                    "sliding_friction": 0.0,
                    "spinning_friction_rate": 0.0,
                }
            )
        ),
    )
)
def test_energy_stays_without_friction_or_losses(scene):
    result = simulate(scene, record="trajectory")
    energy = energies(result, instants(result))
    # Each collision may round it by a few ulp.
    assert np.all(np.abs(energy - energy[0]) <= (8 + 8 * len(result.events)) * EPS * energy[0])


@given(all_shots(ball_laws=("frictional",)))  # in the other the cloth takes part
def test_momentum_survives_every_ball_impact(scene):
    result = simulate(scene, record="trajectory")
    masses = scene.masses
    for t, a, b in ball_impacts(result):
        if t == 0.0:
            continue
        before, after = result.sample([np.nextafter(t, 0.0), t]).velocities
        scale = masses[a] * np.abs(before[a]).max() + masses[b] * np.abs(before[b]).max()
        scale += (masses[a] + masses[b]) * 4.0 * t  # the clock's last unit, at 4 m/s^2
        for i in range(len(masses)):
            if i not in (a, b):
                assert np.allclose(before[i], after[i], rtol=0, atol=8 * EPS * 10)
        momenta = [masses[a] * v[a] + masses[b] * v[b] for v in (before, after)]
        assert np.allclose(*momenta, rtol=0, atol=16 * EPS * scale)


@given(all_shots(ball_laws=("frictional",)))  # in the other, e is one of energies
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
        assert after == pytest.approx(-e * before, abs=64 * EPS * (speeds + 4.0 * t))


@given(all_shots())
def test_nothing_overlaps_at_events_or_between(scene):
    # A missed collision shows as an overlap of the order of a radius.
    result = simulate(scene, record="trajectory")
    depth = overlaps(scene, result.sample(instants(result, 20)).positions).max()
    # A contact force holds gaps to 4e-13 m for pool balls, other contacts are exact.
    assert depth <= (1e-12 if result.work["contact_steps"] else 1e-13)


@given(all_shots())
def test_balls_touch_when_they_collide(scene):
    # A phantom collision, at any distance, would show here.
    result = simulate(scene, record="trajectory")
    for t, a, b in ball_impacts(result):
        centres = result.sample(t).positions[0, :, :2]
        gap = np.linalg.norm(centres[a] - centres[b]) - scene.radii[a] - scene.radii[b]
        assert abs(gap) <= (1e-12 if result.work["contact_steps"] else 1e-14)


@given(all_shots())
def test_the_run_ends_at_rest_with_events_in_order_of_time(scene):
    result = simulate(scene, record="events")
    assert result.status is Status.REST
    assert not np.any(result.final_state.velocities)
    assert not np.any(result.final_state.angular_velocities)
    times = result.events["t"]
    assert np.all(np.diff(times) >= 0.0)
    last = times[-1] if len(times) else 0.0
    spinning = np.any(result.sample(last).angular_velocities[0, :, 2])
    assert result.rest_time > last if spinning else result.rest_time == last
    pairs = result.events[result.events["kind"] == EventKind.BALL_BALL]
    assert np.all(pairs["a"] < pairs["b"])


@given(all_shots())
def test_every_record_gives_the_same_bits(scene):
    runs = {record: simulate(scene, record=record) for record in ("rest", "events", "trajectory")}
    assert len({state_bits(run) for run in runs.values()}) == 1
    assert log_bits(runs["events"]) == log_bits(runs["trajectory"])
    assert len({str(run.collision_counts) for run in runs.values()}) == 1


@given(all_shots())
def test_the_recorded_motion_ends_where_the_run_ended(scene):
    result = simulate(scene, record="trajectory")
    end = result.sample([result.rest_time, result.rest_time + 1.0])
    for sampled, final in zip(end, result.final_state, strict=True):
        assert np.allclose(sampled, final, rtol=0, atol=16 * EPS * (1 + np.abs(final)))
    start = result.sample(0.0).positions[0]
    assert np.array_equal(start, scene.positions)


@given(all_shots(most=5), st.randoms(use_true_random=False))
def test_the_order_of_the_balls_does_not_matter(scene, chance):
    # Results that depend on labels are FastFiz's defect. Same bits, since + and * commute.
    order = list(range(len(scene.balls)))
    chance.shuffle(order)
    base = simulate(scene, record="events")
    other = simulate(shuffled(scene, order), record="events")
    assert same_log(base, other, order)
    assert np.array_equal(other.rest_positions, base.rest_positions[order])


@pytest.mark.parametrize("name", MAPS)
@given(scene=all_shots(tables=st.none()))
def test_an_image_of_the_cloth_gives_the_image_to_the_bit(name, scene):
    # Mirrors, and turns by right angles.
    base, other = (simulate(one, record="events") for one in (scene, image(scene, name)))
    assert log_bits(base) == log_bits(other)
    x, y = MAPS[name](base.rest_positions[:, 0], base.rest_positions[:, 1])
    assert np.array_equal(other.rest_positions[:, :2], np.stack([x, y], axis=1))


@given(all_shots(tables=st.just(POOL_TABLE)))
def test_a_diagonal_mirror_image_of_a_table_gives_the_mirror_image_to_the_bit(scene):
    base, other = (simulate(one, record="events") for one in (scene, image(scene, "diagonal")))
    assert base.events["t"].tobytes() == other.events["t"].tobytes()
    assert np.array_equal(other.rest_positions[:, :2], base.rest_positions[:, 1::-1])


# Alciatore's friction knows a speed, so it is not the same at another scale.
@given(all_shots(frictions=(0.0, 0.06)), st.integers(-3, 3))
def test_lengths_times_4_and_speeds_times_2_change_no_bit(scene, k):
    # g and mu stay, so a = mu g does; powers of two commute with + - * / and sqrt. An absolute
    # tolerance on a gap, a speed or the clock would show as other bits.
    base, other = (simulate(one, record="events") for one in (scene, scaled(scene, k)))
    assert collisions(base) == collisions(other)
    assert np.array_equal(other.events["t"], 2.0**k * base.events["t"])
    assert np.array_equal(other.rest_positions, 4.0**k * base.rest_positions)


@given(all_shots(), st.integers(-40, 40))
def test_masses_times_a_power_of_two_change_no_bit(scene, k):
    heavier = [changed(one, mass=one.mass * 2.0**k) for one in scene.balls]
    base = simulate(scene, record="events")
    other = simulate(with_balls(scene, heavier), record="events")
    assert log_bits(base) == log_bits(other)
    assert state_bits(base) == state_bits(other)


@given(all_shots(most=4, frictions=(0.0, 0.06)), st.sampled_from([1, 2, 3]))
def test_faster_play_without_friction_is_the_same_path_sooner(scene, k):
    physics = scene.physics.model_copy(
        update={"rolling_friction": 0.0, "sliding_friction": 0.0, "spinning_friction_rate": 0.0}
    )
    slow = with_balls(scene, scene.balls, t_max=2.0, physics=physics)
    faster = [
        changed(
            one,
            velocity=[2.0**k * c for c in one.velocity[:2]],
            **({"angular_velocity": [2.0**k * c for c in one.angular_velocity]} if spins else {}),
        )
        for one in scene.balls
        for spins in [one.angular_velocity is not None]
    ]
    fast = with_balls(scene, faster, t_max=2.0 / 2.0**k, physics=physics)
    base, other = simulate(slow, record="events"), simulate(fast, record="events")
    assert collisions(base) == collisions(other)
    assert np.array_equal(other.events["t"] * 2.0**k, base.events["t"])
    assert np.array_equal(other.rest_positions, base.rest_positions)


def on_grid(scene: Scene) -> Scene:
    """Return the scene on a grid of 2^-30 m, so that shifting it by whole metres is exact."""
    return with_balls(
        scene,
        [
            changed(one, position=[round(c * 2**30) / 2**30 for c in one.position[:2]])
            for one in scene.balls
        ],
    )


def assert_alike(base: Scene, other: Scene, back, scale: float) -> None:
    """Assert that two shots are one but for rounding, as far as chaos allows.

    `back` takes the other's places to the first's; coordinates are up to `scale` m. Where a contact
    force held balls together, hops that it took for none, of 4e-13 m, had up to 2e-6 m/s. A law
    that integrates an impact errs by up to 1e-7 of the speeds, and rounding may change its steps.
    """
    growth = sensitivity(base)
    if growth * EPS > 1e-9:
        return  # chaos: nothing to compare
    first, second = simulate(base, record="events"), simulate(other, record="events")
    assert sorted(event[0] for event in collisions(first)) == sorted(
        event[0] for event in collisions(second)
    )
    apart = back(second.rest_positions[:, :2]) - first.rest_positions[:, :2]
    error = 64 * EPS * scale
    laws = {"ball-ball": base.physics.ball_impact, "ball-cushion": base.physics.cushion}
    if any(first.collision_counts[kind] and law in INTEGRATED for kind, law in laws.items()):
        error = 1e-6
    if first.work["contact_steps"] or second.work["contact_steps"]:
        error = 2e-6
    assert np.max(np.abs(apart)) <= error * growth


@given(
    all_shots(tables=st.none(), most=4), st.sampled_from([(1.0, 0.0), (-4.0, 2.0), (16.0, -8.0)])
)
def test_where_on_an_unbounded_cloth_does_not_matter_beyond_rounding(scene, shift):
    base = on_grid(scene)
    moved = [
        changed(one, position=[c + s for c, s in zip(one.position, shift, strict=False)])
        for one in base.balls
    ]
    assert_alike(base, with_balls(base, moved), lambda places: places - shift, 16.0)


@given(all_shots(tables=st.just(Table(length=2.5, width=1.25)), most=3))
def test_a_table_turned_by_a_right_angle_gives_the_same_beyond_rounding(scene):
    base = on_grid(scene)
    turned = []
    for one in base.balls:
        spin = one.angular_velocity
        turned.append(
            changed(
                one,
                position=(1.25 - one.position[1], one.position[0]),
                velocity=(-one.velocity[1], one.velocity[0]),
                **({} if spin is None else {"angular_velocity": spin_under("quarter turn", spin)}),
            )
        )
    other = with_balls(base, turned, table=Table(length=1.25, width=2.5))
    assert_alike(base, other, lambda p: np.stack([p[:, 1], 1.25 - p[:, 0]], axis=1), 4.0)


def few_large_balls(seed: int, n: int, motion: str) -> Scene:
    """Return n balls, large on their table, so that some ten collisions amplify little."""
    chance = random.Random(seed)
    places = chance.sample(list(itertools.product((0.2, 0.5, 0.8), (0.2, 0.5, 0.8))), n)
    balls = [
        ball(place, (chance.uniform(-1, 1), chance.uniform(-1, 1)), radius=0.1, mass=1.0 + k % 2)
        for k, place in enumerate(places)
    ]
    free = {"rolling_friction": 0.0, "sliding_friction": 0.0, "spinning_friction_rate": 0.0}
    physics = {"rolling_friction": 0.0} if motion == "rolling" else {"motion": motion, **free}
    scene = scene_of(*balls, table=Table(length=1.0, width=1.0), t_max=1.25, **physics)
    return scene if motion == "rolling" else spun(scene, seed)


def assert_runs_backwards(scene: Scene) -> bool:
    """Assert that the shot's end, turned round, runs back to its start; False is chaos."""
    there = simulate(scene, record="events")
    ends = zip(scene.balls, *(array[0] for array in there.final_state), strict=True)
    back = with_balls(
        scene,
        [
            changed(
                one,
                position=position[:2].tolist(),
                velocity=(-velocity[:2]).tolist(),
                **({} if one.angular_velocity is None else {"angular_velocity": (-spin).tolist()}),
            )
            for one, position, velocity, spin in ends
        ],
    )
    growth = max(sensitivity(scene), sensitivity(back))
    if growth * EPS > 1e-9:
        return False  # chaos: nothing to compare
    home = simulate(back, record="events")
    assert sorted(collisions(home)) == sorted(collisions(there))
    assert np.max(np.abs(home.rest_positions - scene.positions)) <= 256 * EPS * growth
    assert np.max(np.abs(home.final_state.velocities[0] + scene.velocities)) <= 256 * EPS * growth
    return True


@given(st.integers(0, 10_000), st.integers(2, 5), st.sampled_from(["rolling", "sliding"]))
def test_elastic_play_without_friction_runs_backwards(seed, n, motion):
    assert_runs_backwards(few_large_balls(seed, n, motion))


@pytest.mark.compiled
@pytest.mark.parametrize("motion", ["rolling", "sliding"])
def test_it_runs_backwards_through_at_least_ten_ball_collisions(motion):
    compared = 0
    for seed in range(40):
        scene = few_large_balls(seed, 3, motion)
        long = with_balls(scene, scene.balls, t_max=20.0)
        times = [t for t, _, _ in ball_impacts(simulate(long, record="events"))]
        middle = 0.5 * (times[9] + times[10])  # after the tenth, before the eleventh
        compared += assert_runs_backwards(with_balls(scene, scene.balls, t_max=middle))
    assert compared >= 20


@given(all_shots(tables=st.none(), most=4))
def test_a_far_away_resting_ball_changes_nothing(scene):
    more = with_balls(scene, [*scene.balls, Ball(id="lonely", **ball((50.0, 50.0)))])
    base, other = simulate(scene, record="events"), simulate(more, record="events")
    assert log_bits(base) == log_bits(other)
    assert np.array_equal(base.rest_positions, other.rest_positions[:-1])


@pytest.mark.compiled
@given(st.integers(0, 10_000))
def test_a_break_keeps_the_same_bits_whatever_is_recorded(seed):
    scene = random_break(seed, e=0.95)
    assert state_bits(simulate(scene)) == state_bits(simulate(scene, record="trajectory"))
