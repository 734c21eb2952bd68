"""Tests of impacts that last, against published numbers, SciPy and conservation laws."""

from __future__ import annotations

import math

import numpy as np
import pytest
from recorded import fingerprint
from scipy.integrate import solve_ivp
from shots import R

from ghostball import Ball, EventKind, Scene, UnsupportedSceneError, simulate, simulate_many
from ghostball.engine.impacts.hertz import deepest_overlap, loss_of, stiffness
from ghostball.engine.running.from_scene import contact_modulus
from ghostball.model import Phase, energy_of

FREE = {
    "motion": "sliding",
    "sliding_friction": 0.0,
    "rolling_friction": 0.0,
    "spinning_friction_rate": 0.0,
    "impacts": "compliant",
}
"""A cloth without friction, so that only contacts change velocities."""

POOL = {"preset": "pool", "impacts": "compliant", "ball_restitution": 0.97, "ball_friction": 0.06}


def break_of(
    gap, *, rows=5, v=10.7, off=0.1, uneven=0.0, seed=1, t_max=2.5e-3, table=None, at=0.0, **physics
):
    """Return a cue ball about to hit a rack of `rows` rows, whose front is at (`at`, `at`)."""
    chance = np.random.default_rng(seed)
    apart = 2.0 * R + gap
    cue = (at - 2.0 * R * math.sqrt(1.0 - 0.25 * off * off) - 1e-6 - 2.0 * uneven, at + off * R)
    balls = [Ball(id="cue", position=cue, velocity=(v, 0.0), angular_velocity=(0.0, 0.0, 0.0))]
    for row in range(rows):
        for place in range(row + 1):
            dx, dy = uneven * chance.uniform(-1.0, 1.0, 2)
            where = (at + row * math.sqrt(0.75) * apart + dx, at + (place - row / 2) * apart + dy)
            balls.append(Ball(id=str(len(balls)), position=where))
    laws = {**FREE, "ball_restitution": 0.97, "ball_friction": 0.06, **physics}
    return Scene(name="break", balls=balls, table=table, physics=laws, t_max=t_max)


def ends(scene):
    """Return positions, velocities and angular velocities at the end."""
    return simulate(scene, record="events").final_state


def speeds(scene):
    velocities = ends(scene).velocities[0]
    return np.hypot(velocities[:, 0], velocities[:, 1])


def test_a_rack_has_the_speeds_and_directions_that_belk_published():
    """Belk's table for a cue ball of speed 10 and a touching rack of elastic Hertzian balls.

    The balls are so stiff that their overlaps don't turn the lines of centres.
    """
    hit = break_of(0.0, v=1.0, off=0.0, ball_restitution=1.0, ball_friction=0.0, t_max=0.01)
    balls = [hit.balls[0].model_copy(update={"position": (-2.0 * R, 0.0, R)}), *hit.balls[1:]]
    physics = hit.physics.model_copy(update={"ball_youngs_modulus": 1e13})
    scene = Scene(
        name="belk",
        balls=[ball.model_dump() for ball in balls],
        physics=physics.model_dump(),
        t_max=0.01,
    )
    found = ends(scene).velocities[0]
    of_ball = 10.0 * np.hypot(found[:, 0], found[:, 1])
    published = [1.792, 1.202, 1.572, 1.572, 1.424, 0.123, 1.424, 1.310]
    published += [0.251, 0.251, 1.310, 5.597, 2.567, 2.633, 2.567, 5.597]
    assert of_ball == pytest.approx(published, abs=6e-4)
    angles = np.degrees(np.arctan2(found[11:, 1], found[11:, 0]))
    assert angles == pytest.approx([-30.00, -1.78, 0.0, 1.78, 30.00], abs=6e-3)


def test_a_cradle_of_three_touching_balls_leaves_as_published():
    """-0.071, 0.076 and 0.995 of the speed: three elastic Hertzian balls in a row."""
    balls = [
        Ball(id="a", position=(-0.1, 0.0), velocity=(1.0, 0.0), angular_velocity=(0.0, 0.0, 0.0)),
        Ball(id="b", position=(0.0, 0.0)),
        Ball(id="c", position=(2.0 * R, 0.0)),
    ]
    found = ends(Scene(name="cradle", balls=balls, physics=FREE, t_max=0.1)).velocities[0][:, 0]
    assert found == pytest.approx([-0.071, 0.076, 0.995], abs=6e-4)


def row_of_three(gap, v=10.0):
    """Return a shot of ball a head-on onto ball b, with ball c `gap` [m] behind ball b."""
    balls = [
        Ball(
            id="a", position=(-2.0 * R - 1e-9, 0), velocity=(v, 0), angular_velocity=(0.0, 0.0, 0.0)
        ),
        Ball(id="b", position=(0.0, 0.0)),
        Ball(id="c", position=(2.0 * R + gap, 0.0)),
    ]
    return Scene(name="row", balls=balls, physics=FREE, t_max=3e-3)


@pytest.mark.parametrize("depths", [0.0, 0.5, 1.0, 1.49, 1.51, 3.0])
def test_a_third_ball_takes_part_up_to_one_and_a_half_depths_away(depths):
    """Impacts with a larger gap are rigid. Both ways agree with SciPy's integration.

    Without a loss, errors are larger than in a break with a restitution of 0.97: 2.2e-5 m/s if the
    balls touch.
    """
    mass = Ball(id="a", position=(0.0, 0.0)).mass
    stiff = stiffness(contact_modulus(row_of_three(0.0).physics), R, R)
    scene = row_of_three(depths * deepest_overlap(10.0, stiff, 0.5 * mass))
    found = ends(scene)
    assert ("compliant_impacts" in simulate(scene).work) == (depths < 1.5)
    assert found.velocities[0][:, :2] == pytest.approx(reference_of(scene, 1.0)[0], abs=3e-5)


def reference_of(scene, slip):
    """Return the final velocities and spins of the same equations of motion, by SciPy's DOP853."""
    x, v, w = scene.positions[:, :2], scene.velocities[:, :2], scene.angular_velocities
    n, m, r = len(x), scene.masses, scene.radii
    i, j = np.triu_indices(n, 1)
    near = np.hypot(*(x[j] - x[i]).T) < 2.2 * R
    i, j = i[near], j[near]
    modulus, loss = contact_modulus(scene.physics), loss_of(scene.physics.ball_restitution)
    stiff = 4.0 / 3.0 * modulus * np.sqrt(r[i] * r[j] / (r[i] + r[j]))
    reduced = m[i] * m[j] / (m[i] + m[j])

    def slopes(_, state):
        x, v = state[: 2 * n].reshape(n, 2), state[2 * n : 4 * n].reshape(n, 2)
        w = state[4 * n :].reshape(n, 3)
        apart = x[j] - x[i]
        distance = np.sqrt(np.sum(apart * apart, axis=1))
        overlap = np.maximum(r[i] + r[j] - distance, 0.0)
        normal = apart / distance[:, np.newaxis]
        across = np.stack((-normal[:, 1], normal[:, 0]), axis=1)
        relative = v[i] - v[j]
        rate = np.sum(relative * normal, axis=1)
        energy = np.sqrt(rate**2 + 0.8 * stiff / reduced * overlap**2.5)
        force = stiff * overlap**1.5 * (1.0 + loss * rate / np.where(energy > 0.0, energy, 1.0))
        lever = (distance / (r[i] + r[j]))[:, np.newaxis]
        turning = lever * (r[i, np.newaxis] * w[i] + r[j, np.newaxis] * w[j])
        along = np.sum(relative * across, axis=1) + turning[:, 2]
        up = normal[:, 1] * turning[:, 0] - normal[:, 0] * turning[:, 1]
        part = scene.physics.ball_friction * force / np.sqrt(along**2 + up**2 + slip**2)
        push = -force[:, np.newaxis] * normal - (part * along)[:, np.newaxis] * across
        turn = lever * np.stack(
            (-part * up * normal[:, 1], part * up * normal[:, 0], -part * along), 1
        )
        accelerations, spins = np.zeros((n, 2)), np.zeros((n, 3))
        np.add.at(accelerations, i, push)
        np.add.at(accelerations, j, -push)
        for ends_of in (i, j):
            np.add.at(spins, ends_of, turn)
        accelerations /= m[:, np.newaxis]
        spins *= (2.5 / (m * r))[:, np.newaxis]
        return np.concatenate((v.ravel(), accelerations.ravel(), spins.ravel()))

    start = np.concatenate((x.ravel(), v.ravel(), w.ravel()))
    found = solve_ivp(
        slopes, (0.0, scene.t_max), start, "DOP853", rtol=1e-9, atol=1e-12, max_step=2e-5
    ).y[:, -1]
    return found[2 * n : 4 * n].reshape(n, 2), found[4 * n :].reshape(n, 3)


@pytest.mark.parametrize("friction", [0.0, 0.06])
def test_the_integration_is_within_its_stated_error(friction):
    scene = break_of(2e-5, rows=3, v=10.0, uneven=5e-6, ball_friction=friction, t_max=2e-3)
    found = ends(scene)
    velocities, spins = reference_of(scene, 0.0075 * 10.0)
    assert found.velocities[0][:, :2] == pytest.approx(velocities, abs=1e-5)
    assert R * found.angular_velocities[0] == pytest.approx(R * spins, abs=2e-5)


@pytest.mark.parametrize("gap", [0.0, 1e-6, 3e-5, 3e-4])
def test_a_break_keeps_momentum_and_angular_momentum_and_gains_no_energy(gap):
    scene = break_of(gap, uneven=gap / 4)
    found = ends(scene)
    m, v, w = scene.masses, found.velocities[0], found.angular_velocities[0]
    x = found.positions[0]
    assert m @ v[:, :2] == pytest.approx((m[0] * 10.7, 0.0), abs=1e-14)
    orbital = m @ (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0])
    begun = -m[0] * scene.balls[0].position[1] * 10.7
    assert orbital + 0.4 * R * R * (m @ w[:, 2]) == pytest.approx(begun, abs=1e-6 * abs(begun))
    assert energy_of(scene, found).total[0] < 0.5 * m[0] * 10.7**2


@pytest.mark.compiled
def test_speeds_change_smoothly_with_the_gap():
    """Rigid impacts jump between a touching rack and one with gaps of a nanometre."""
    gaps = np.linspace(0.0, 1e-3, 41)
    found = np.array([speeds(break_of(gap, off=0.0, t_max=8e-3)) for gap in gaps])
    assert np.max(np.abs(np.diff(found, axis=0))) < 0.35
    near = np.array([speeds(break_of(gap, off=0.0)) for gap in (0.0, 1e-9, 1e-7, 1e-6)])
    assert np.max(np.abs(near - near[0])) < 0.02
    corner = found[:, 11]
    assert np.all(np.diff(corner) > -1e-2)
    assert corner[-1] > corner[0] + 0.8


def row_of(gap, modulus, impacts):
    cue = Ball(id="cue", position=(-0.2, 0.004), velocity=(1.0, 0.0))
    balls = [Ball(id=str(k), position=(k * (2.0 * R + gap), 0.0)) for k in range(4)]
    stiff = {"ball_youngs_modulus": modulus} if impacts == "compliant" else {}
    laws = {**FREE, "impacts": impacts, "ball_restitution": 0.95, "ball_friction": 0.05, **stiff}
    return Scene(name="row", balls=[cue, *balls], physics=laws, t_max=0.4)


def test_results_approach_sequential_impacts_as_stiffness_grows():
    rigid = ends(row_of(2e-5, 0.0, "sequential")).velocities[0]
    off = []
    for modulus in (1e8, 1e10, 1e11, 1e13):
        soft = ends(row_of(2e-5, modulus, "compliant")).velocities[0]
        off.append(float(np.max(np.abs(soft - rigid))))
    assert off[0] > 1e-2
    assert off[0] > off[1] > off[2] > off[3]
    assert off[3] == 0.0  # no third ball is within the depth of the impact


def test_a_pair_alone_is_resolved_by_the_law_of_rigid_impacts():
    def pair(impacts):
        cue = Ball(id="cue", position=(0.3, 0.5), velocity=(3.0, 0.1))
        balls = [cue, Ball(id="a", position=(0.6, 0.53)), Ball(id="far", position=(0.9, 0.2))]
        return Scene(
            name="pair", table="wpa-9ft", balls=balls, physics={**POOL, "impacts": impacts}
        )

    rigid, soft = (
        simulate(pair(impacts), record="events") for impacts in ("simultaneous", "compliant")
    )
    assert "compliant_impacts" not in soft.work
    assert fingerprint(rigid) == fingerprint(soft)


def shot(impacts="compliant", **fields):
    cue = Ball(id="cue", position=(0.4953, 0.4953), velocity=(10.5, 0.0))
    rack = {"kind": "8-ball", "seed": 7}
    physics = {**POOL, "impacts": impacts}
    return Scene(name="shot", table="bar-7ft", balls=[cue], rack=rack, physics=physics, **fields)


def test_a_whole_break_comes_to_rest_with_the_same_bits_on_every_path():
    scene = shot()
    one = simulate(scene, record="trajectory")
    assert one.status.name == "REST"
    assert one.work["compliant_impacts"] >= 1
    assert fingerprint(one) == fingerprint(simulate(scene, record="events"))
    many = simulate_many([scene] * 3, threads=2)
    for rest in many.rest_positions:
        assert np.array_equal(rest, one.rest_positions)
    assert np.array_equal(simulate(scene).rest_positions, one.rest_positions)


def test_the_mirror_image_of_a_shot_is_its_mirror_image_to_the_bit():
    def mirrored(scene):
        balls = []
        for ball in scene.balls:
            (x, y, _), (vx, vy, _) = ball.position, ball.velocity
            balls.append(
                Ball(
                    id=ball.id,
                    position=(x, -y),
                    velocity=(vx, -vy),
                    angular_velocity=(0.0, 0.0, 0.0),
                )
            )
        return Scene(name="mirror", balls=balls, physics=scene.physics, t_max=scene.t_max)

    scene = break_of(3e-5, uneven=7e-6)
    found, image = ends(scene), ends(mirrored(scene))
    assert np.array_equal(found.velocities[0] * (1.0, -1.0, 1.0), image.velocities[0])


def test_the_numbers_of_balls_matter_no_more_than_rounding():
    scene = break_of(3e-5, uneven=7e-6)
    order = np.random.default_rng(3).permutation(len(scene.balls))
    again = Scene(
        name="again", balls=[scene.balls[k] for k in order], physics=scene.physics, t_max=2.5e-3
    )
    found, other = ends(scene).velocities[0], ends(again).velocities[0]
    assert found[order] == pytest.approx(other, abs=1e-9)


def test_the_recorded_motion_is_continuous_and_contacts_begin_where_balls_touch():
    scene = shot(t_max=0.3)
    result = simulate(scene, record="trajectory")
    for rows in result.trajectory.segments:
        starts = rows[1:, 0]
        before = result.trajectory.sample(np.nextafter(starts, 0.0))
        after = result.trajectory.sample(starts)
        assert np.max(np.abs(before.positions - after.positions), initial=0.0) < 1e-12
    events = result.events[result.events["kind"] == EventKind.BALL_BALL]
    for event in events:
        x = result.sample([event["t"]]).positions[0]
        apart = np.linalg.norm(x[event["a"]] - x[event["b"]]) - 2.0 * R
        assert abs(apart) < 1e-6
    touching = result.phases(np.array([events["t"][0] + 1e-5]))[0] == Phase.COMPRESSED
    assert np.count_nonzero(touching) >= 2
    assert not np.any(result.phases(np.array([0.29])) == Phase.COMPRESSED)


def test_balls_that_lie_against_each_other_begin_to_push_where_they_touch():
    result = simulate(break_of(0.0, rows=3), record="trajectory")
    events = result.events[result.events["kind"] == EventKind.BALL_BALL]
    assert len(events) >= 6
    for event in events:
        x = result.sample([event["t"]]).positions[0]
        apart = np.linalg.norm(x[event["a"]] - x[event["b"]]) - 2.0 * R
        assert abs(apart) < 5e-12


ALONG_CUSHION = {
    "into the cushion": [((0.5, 0.5), (0.0, -5.0)), ((0.5 - R, R), None), ((0.5 + R, R), None)],
    "near the cushion": [
        ((0.5, 0.3), (0.0, -3.0)),
        ((0.5, R + 2e-4), None),
        ((0.5 + 2.00001 * R, R + 1e-4), None),
    ],
    "towards a pocket": [
        ((0.3, 0.3), (-3.0, -3.0)),
        ((0.12, 0.12), None),
        ((0.1605, 0.0795), None),
    ],
}


@pytest.mark.parametrize("places", ALONG_CUSHION.values(), ids=ALONG_CUSHION)
def test_balls_that_push_each_other_meet_cushions_and_pockets(places):
    balls = [
        Ball(id=str(k), position=where, velocity=how or (0.0, 0.0))
        for k, (where, how) in enumerate(places)
    ]
    scene = Scene(name="cushion", table="bar-7ft", balls=balls, physics=POOL)
    result = simulate(scene, record="trajectory")
    assert result.status.name == "REST"
    assert result.work["compliant_impacts"] >= 1
    here = [
        k
        for k in range(len(balls))
        if not np.any(result.events["a"][result.events["kind"] == EventKind.POCKETED] == k)
    ]
    x, y = result.rest_positions[here, 0], result.rest_positions[here, 1]
    assert np.all((x > R - 1e-9) & (x < 1.9812 - R + 1e-9))
    assert np.all((y > R - 1e-9) & (y < 0.9906 - R + 1e-9))


def test_two_clusters_at_once_are_followed_together():
    """Two racks that are hit at the same time, and two that are hit within one contact."""
    one = break_of(2e-5, rows=3, t_max=3e-3)
    for later in (0.0, 3e-4):
        balls = list(one.balls)
        for ball in one.balls:
            x, y, _ = ball.position
            back = 10.7 * later if ball.id == "cue" else 0.0
            balls.append(
                Ball(
                    id=f"b{ball.id}",
                    position=(x - back, y + 1.0),
                    velocity=ball.velocity,
                    angular_velocity=(0.0, 0.0, 0.0),
                )
            )
        both = Scene(name="both", balls=balls, physics=one.physics, t_max=3e-3)
        alone, found = ends(one).velocities[0], ends(both).velocities[0]
        n = len(one.balls)
        assert found[:n] == pytest.approx(alone, abs=2e-5)
        assert found[n:] == pytest.approx(alone, abs=2e-5)


def test_there_is_no_tangent_map_of_impacts_that_last():
    result = simulate(shot(t_max=0.3), record="trajectory")
    with pytest.raises(UnsupportedSceneError, match='no tangent map for `impacts` = "compliant"'):
        result.sensitivity([0.2])
