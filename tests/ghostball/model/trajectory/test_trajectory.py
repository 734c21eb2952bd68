"""Samples of recorded motions, exact or in frames, and the energy of a state."""

from __future__ import annotations

import math

import numpy as np
import pytest
from segments import (
    ROLLING_FRICTION,
    SLIDING_FRICTION,
    SPIN_DECELERATION,
    G,
    rest,
    roll,
    slide,
    trajectory_of,
    whole_shot,
)
from shots import R, ball, scene_of

from ghostball.engine.core import state
from ghostball.model import (
    ExactTrajectory,
    Phase,
    SampledTrajectory,
    Samples,
    energy_of,
    initial_state,
)


def line(times, xs, vxs) -> SampledTrajectory:
    """Return the motion of one ball on the x axis."""
    k = len(times)
    positions, velocities = np.zeros((k, 1, 3)), np.zeros((k, 1, 3))
    positions[:, 0, 0], velocities[:, 0, 0] = xs, vxs
    return SampledTrajectory(np.array(times, dtype=float), positions, velocities, velocities / R)


def sampled_x(trajectory, *times) -> list[float]:
    return trajectory.sample(np.array(times)).positions[:, 0, 0].tolist()


def test_straight_lines_between_frames_and_stored_values_at_frames():
    trajectory = line([0.0, 1.0, 3.0], [0.0, 2.0, 1.0], [2.0, 2.0, -0.5])
    assert trajectory.t_end == 3.0
    assert sampled_x(trajectory, 0.0, 0.25, 1.0, 2.0, 3.0) == [0.0, 0.5, 2.0, 1.5, 1.0]


def test_before_the_start_and_after_the_end_the_balls_stay():
    trajectory = line([0.0, 1.0], [0.0, 2.0], [2.0, 2.0])
    assert sampled_x(trajectory, -1.0, 5.0) == [0.0, 2.0]


def test_at_a_collision_the_state_after_it_counts():
    trajectory = line([0.0, 1.0, 1.0, 2.0], [0.0, 1.0, 1.0, 0.0], [1.0, 1.0, -1.0, -1.0])
    velocities = trajectory.sample(np.array([np.nextafter(1.0, 0.0), 1.0])).velocities[:, 0, 0]
    assert velocities[1] == -1.0
    assert velocities[0] == pytest.approx(1.0)


def test_a_collision_in_the_last_frame():
    trajectory = line([0.0, 1.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, -1.0])
    assert trajectory.sample(np.array([1.0])).velocities[0, 0, 0] == -1.0


def test_a_rolling_ball_has_seven_tenths_m_v_squared_whatever_its_radius():
    scene = scene_of(ball((0, 0), (3, 4), mass=2.0), ball((9, 9), (0, 1), mass=3.0, radius=0.5))
    energy = energy_of(scene, initial_state(scene))
    assert energy.translation[0] == pytest.approx(25.0 + 1.5, rel=1e-15)
    assert energy.rotation[0] == pytest.approx(0.4 * (25.0 + 1.5), rel=1e-15)
    assert energy.height[0] == 0.0
    assert energy.total[0] == pytest.approx(1.4 * 26.5, rel=1e-15)


def test_height_is_counted_from_lying_on_the_cloth():
    scene = scene_of(ball((0, 0, R + 0.5), mass=2.0), motion="sliding", airborne=True, gravity=10.0)
    energy = energy_of(scene, initial_state(scene))
    assert energy.height[0] == pytest.approx(10.0, rel=1e-15)
    assert energy.total[0] == energy.height[0]


def test_energy_of_several_instants_at_once():
    scene = scene_of(ball((0, 0), (1, 0), mass=1.0))
    one = initial_state(scene)
    both = Samples(*(np.concatenate([array, 2.0 * array]) for array in one))
    assert energy_of(scene, both).translation.tolist() == [0.5, 2.0]


# --- exact motion


def slip_of(samples: Samples) -> np.ndarray:
    """Return the velocity of the lowest point over the cloth, (k, n, 2) [m/s]."""
    v, w = samples.velocities, samples.angular_velocities
    return np.stack([v[..., 0] - R * w[..., 1], v[..., 1] + R * w[..., 0]], axis=-1)


def test_the_phases_are_those_of_the_kernels():
    kernels = [state.RESTING, state.SLIDING, state.ROLLING, state.GONE, state.FLYING]
    kernels.append(state.COMPRESSED)
    assert [float(phase) for phase in Phase] == kernels


def test_a_slide_is_sampled_from_its_closed_form():
    """A draw shot with side: a parabola, on which v + (2/5) R (w x z) never changes."""
    velocity, spin = (2.0, 0.3), (10.0, -60.0, 40.0)
    segment, duration = slide(0.0, (0.1, 0.2), velocity, spin)
    times = np.linspace(0.0, duration, 7)
    samples = trajectory_of(segment, t_end=duration).sample(times)
    v, w = samples.velocities[:, 0], samples.angular_velocities[:, 0]
    kept = np.stack([v[:, 0] + 0.4 * R * w[:, 1], v[:, 1] - 0.4 * R * w[:, 0]], axis=1)
    assert kept == pytest.approx(np.tile(kept[0], (7, 1)), rel=1e-14)
    slip = slip_of(samples)[:, 0]
    assert slip == pytest.approx(np.outer(1.0 - times / duration, slip[0]), abs=1e-14)
    assert v[-1, :2] == pytest.approx(np.array(velocity) - 2.0 / 7.0 * slip[0], rel=1e-14)
    a = -SLIDING_FRICTION * G * slip[0] / np.hypot(*slip[0])
    x = samples.positions[:, 0, :2]
    assert x == pytest.approx(
        np.array([0.1, 0.2]) + np.outer(times, velocity) + np.outer(times**2 / 2, a), rel=1e-14
    )
    assert np.all(samples.positions[..., 2] == R)
    assert w[:, 2] == pytest.approx(40.0 - SPIN_DECELERATION * times, rel=1e-15)
    assert np.all(v[:, 2] == 0.0)


def test_rolling_has_the_spin_of_its_velocity_whatever_the_segment_says():
    """The segment's own wx, wy, bx, by are NaN there."""
    segment, duration = roll(0.0, (0.0, 0.0), (0.3, -0.4), -7.0)
    samples = trajectory_of(segment, t_end=duration).sample(np.linspace(0.0, duration, 5))
    assert np.max(np.abs(slip_of(samples))) < 1e-16
    w = samples.angular_velocities[:, 0]
    assert w[0, :2] == pytest.approx([0.4 / R, 0.3 / R], rel=1e-15)
    half = 0.5 * math.hypot(0.3, 0.4) / (ROLLING_FRICTION * G)
    assert duration == pytest.approx(2 * half)
    assert w[2, :2] == pytest.approx([0.2 / R, 0.15 / R], rel=1e-14)


@pytest.mark.parametrize("wz", [7.0, -7.0, 0.0])
def test_vertical_spin_decays_to_nothing_and_no_further(wz):
    """The spin decays even while the centre rests; fails if it passes 0, or never decays."""
    trajectory = trajectory_of(rest(0.0, (0.0, 0.0), wz), t_end=2.0)
    found = trajectory.sample(np.array([0.0, 0.5, 0.7, 1.0])).angular_velocities[:, 0]
    assert found[:, 2] == pytest.approx([wz, wz * 2 / 7, 0.0, 0.0], abs=1e-15)
    assert np.all(found[:, :2] == 0.0)


def test_what_a_contact_step_adds_to_the_vertical_spin():
    segment = rest(0.0, (0.0, 0.0), 1.0)
    segment[state.BZ] = 4.0
    found = trajectory_of(segment, t_end=1.0).sample(np.array([0.05, 0.1, 0.3])).angular_velocities
    assert found[:, 0, 2] == pytest.approx([0.7, 0.4, 1.2], rel=1e-15)


def test_the_state_is_continuous_from_slide_to_roll_to_rest():
    """Fails if a segment is read as a segment of another phase."""
    trajectory = whole_shot((1.0, 0.3), (20.0, -50.0, 150.0))
    starts = trajectory.segments[0][1:, 0]
    before, after = trajectory.sample(np.nextafter(starts, 0.0)), trajectory.sample(starts)
    for one, other in zip(before, after, strict=True):
        assert one == pytest.approx(other, abs=1e-12)


def test_the_phase_after_an_event_counts():
    trajectory = whole_shot((1.0, 0.3), (20.0, -50.0, 150.0))
    rolls, rests = trajectory.segments[0][1:, 0]
    times = np.array([0.0, np.nextafter(rolls, 0.0), rolls, rests, trajectory.t_end, 1e9])
    phases = trajectory.phases(times)
    assert phases.dtype == np.int8
    assert phases[:, 0].tolist() == [
        Phase.SLIDING,
        Phase.SLIDING,
        Phase.ROLLING,
        Phase.RESTING,
        Phase.RESTING,
        Phase.RESTING,
    ]
    assert trajectory.phases(np.array([])).shape == (0, 1)


def test_energy_falls_by_what_friction_and_spin_take():
    """The slide costs m u^2 / 7, the vertical spin I wz^2 / 2, and rolling the rest."""
    scene = scene_of(ball((0, 0), mass=2.0))
    inertia = 0.4 * 2.0 * R**2
    velocity, spin = (1.0, 0.3), (20.0, -50.0, 150.0)
    trajectory = whole_shot(velocity, spin)
    rolls, rests = trajectory.segments[0][1:, 0]
    samples = trajectory.sample(np.array([0.0, rolls, rests, trajectory.t_end]))
    energy = energy_of(scene, samples)
    assert energy.rotation[0] == pytest.approx(inertia / 2 * (20**2 + 50**2 + 150**2), rel=1e-14)
    wz = samples.angular_velocities[:, 0, 2]
    excess = energy.total - inertia / 2 * wz**2
    slip = slip_of(samples)[0, 0]
    assert excess[0] - excess[1] == pytest.approx(2.0 * slip @ slip / 7.0, rel=1e-13)
    v = samples.velocities[1, 0]
    assert excess[1] == pytest.approx(0.7 * 2.0 * v @ v, rel=1e-14)
    assert excess[2] == pytest.approx(0.0, abs=1e-15)
    assert energy.total[3] == pytest.approx(0.0, abs=1e-15)
    assert wz[2] > 0.0


def test_a_path_through_its_bend_times_stays_near_the_curve():
    trajectory = whole_shot((1.0, 0.3), (20.0, -50.0, 150.0))
    slides = trajectory.segments[0][1, 0]
    bends = trajectory.bend_times(1e-5, 1000)
    assert bends[0] == 0.0
    assert bends[-1] == slides
    middles = (bends[1:] + bends[:-1]) / 2
    x = trajectory.sample(bends).positions[:, 0]
    beside = trajectory.sample(middles).positions[:, 0] - (x[1:] + x[:-1]) / 2
    distance = np.linalg.norm(beside, axis=1)
    assert 0.5e-5 < distance.max() <= 1e-5  # within the limit, but not far below it
    assert len(trajectory.bend_times(1e-5, 3)) == 4


def test_positions_alone_are_those_of_the_states():
    """The motion has flights, and powers of the time that only one of the balls needs."""
    random = np.random.default_rng(1)
    powers = 3
    segments = []
    for ball_powers in (0, powers):
        pieces = random.normal(size=(6, 17 + 5 * powers))
        pieces[:, 0] = np.arange(6.0)
        pieces[:, 13] = [Phase.SLIDING, Phase.FLYING, Phase.COMPRESSED, Phase.ROLLING, 0, 2]
        pieces[:, 17 + 5 * ball_powers :] = 0.0
        segments.append(pieces)
    trajectory = ExactTrajectory(
        np.array([R, 1.1 * R]), tuple(segments), 7.0, np.array([10.0, 0.5]), lifts=True
    )
    times = [random.uniform(-1.0, 8.0, 50), np.arange(8.0)]
    for number, positions in enumerate(trajectory.positions_apart(times)):
        expected = trajectory.sample(times[number]).positions
        assert trajectory.positions_at(times[number]).tobytes() == expected.tobytes()
        assert positions.tobytes() == np.ascontiguousarray(expected[:, number]).tobytes()
