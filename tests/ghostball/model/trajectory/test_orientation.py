"""Orientation of balls that roll, slide and spin: unit quaternions, w first."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, strategies as st
from segments import SPIN_DECELERATION, rest, roll, slide, trajectory_of, whole_shot
from shots import R

from ghostball.engine import simulate
from ghostball.model import Ball, ExactTrajectory, GhostballError, Physics, SampledTrajectory, Scene
from ghostball.model.trajectory.orientation import (
    STEP_TURN,
    TRUNCATION,
    Pieces,
    fixed_axis_turn,
    orientation_at,
    series_turn,
    terms_needed,
)


def rolling_scene(velocity, **physics):
    ball = Ball(id="cue", position=(0.3, 0.3), velocity=velocity)
    return Scene(name="roll", balls=[ball], physics=Physics(**physics))


def test_angle_is_distance_over_radius_and_axis_is_k_cross_v():
    result = simulate(rolling_scene((0.3, -0.4)), record="events")
    (q,) = result.orientation([result.rest_time])[0]
    angle = 0.5**2 / (2 * 0.02 * 9.81) / R
    assert q[0] == pytest.approx(math.cos(angle / 2), abs=1e-12)
    axis = np.array([0.4, 0.3, 0.0]) / 0.5  # k x v
    assert q[1:] == pytest.approx(axis * math.sin(angle / 2), abs=1e-12)


def test_a_resting_ball_keeps_its_orientation():
    result = simulate(rolling_scene((0.5, 0.0)), record="events")
    at_rest = result.orientation([result.rest_time, result.rest_time + 1.0])
    assert np.array_equal(at_rest[0], at_rest[1])


# --- a moving axis


def turn_in_closed_form(spin, change, duration):
    """Return the turn by w + b s, from the parabolic cylinder functions of Landau and Zener.

    In axes with b along z and w in the xz plane, the spinor of q obeys
    psi' = -i (beta tau sigma_z + delta sigma_x) psi / 2, which is Weber's equation.
    """
    with mpmath.workdps(60):
        w, b = ([mpmath.mpf(float(x)) for x in vector] for vector in (spin, change))
        beta = mpmath.sqrt(sum(x * x for x in b))
        z = [x / beta for x in b]
        along = sum(x * y for x, y in zip(w, z, strict=True))
        across = [x - along * y for x, y in zip(w, z, strict=True)]
        delta = mpmath.sqrt(sum(x * x for x in across))
        x = [c / delta for c in across]
        y = [z[k - 2] * x[k - 1] - z[k - 1] * x[k - 2] for k in range(3)]  # z cross x
        start = along / beta
        end = start + mpmath.mpf(float(duration))
        u = spinors(beta, delta, end) * spinors(beta, delta, start) ** -1
        parts = [-mpmath.im(u[1, 0]), mpmath.re(u[1, 0]), -mpmath.im(u[0, 0])]
        vector = [
            sum(p * axis[k] for p, axis in zip(parts, (x, y, z), strict=True)) for k in (0, 1, 2)
        ]
        assert abs(mpmath.fabs(u[0, 0]) ** 2 + mpmath.fabs(u[1, 0]) ** 2 - 1) < 1e-30
        return np.array([float(v) for v in (mpmath.re(u[0, 0]), *vector)])


def spinors(beta, delta, tau):
    """Return a fundamental matrix at tau: psi = exp(-z / 2) f, with f Kummer's functions of z."""
    i = mpmath.mpc(0, 1)
    z, a, half = i * beta * tau**2 / 2, i * delta**2 / (8 * beta), mpmath.mpf(1) / 2
    envelope = mpmath.exp(-z / 2)

    def f(upper, lower):
        return mpmath.hyp1f1(upper, lower, z)

    even, odd = f(a, half), tau * f(a + half, 3 * half)
    even_rate = i * beta * tau * (a / half) * f(a + 1, 3 * half)
    odd_rate = f(a + half, 3 * half) + i * beta * tau**2 * (a + half) / (3 * half) * f(
        a + 3 * half, 5 * half
    )
    upper = [envelope * even, envelope * odd]
    rates = [
        envelope * (rate - i * beta * tau / 2 * value)
        for rate, value in ((even_rate, even), (odd_rate, odd))
    ]
    lower = [
        (2 * i * rate - beta * tau * value) / delta
        for rate, value in zip(rates, upper, strict=True)
    ]
    return mpmath.matrix([upper, lower])


def turn_in_small_steps(spin, change, duration, steps=4000):
    """Follow q' = w q / 2 by a Magnus integrator of sixth order (Blanes and Moan 2006)."""
    h = duration / steps
    middles = (np.arange(steps) + 0.5) * h
    first = h * (spin + middles[:, None] * change)
    second = np.broadcast_to(h * h * change, first.shape)
    bracket = np.cross(first, second)
    exponent = first + np.cross(-20 * first + bracket, second - np.cross(first, bracket) / 60) / 240
    q = np.array([1.0, 0.0, 0.0, 0.0])
    for vector in exponent:
        angle = np.linalg.norm(vector)
        q = product([math.cos(angle / 2), *(math.sin(angle / 2) / angle * vector)], q)
    return q


def product(p, q):
    """Multiply two quaternions by the rule for scalar and vector."""
    (a, u), (b, v) = ((x[0], np.array(x[1:])) for x in (p, q))
    return np.array([a * b - u @ v, *(a * v + b * u + np.cross(u, v))])


def angle_between(p, q):
    """Return the angle of the turn from one orientation to another [rad], without cancellation."""
    return 2.0 * np.minimum(np.linalg.norm(p - q, axis=-1), np.linalg.norm(p + q, axis=-1))


SLIDES = {
    "draw with side": ((3.0, 0.5), (60.0, -80.0, 120.0)),
    "slow masse": ((0.4, 0.1), (-40.0, -30.0, -5.0)),
    "spinning top": ((0.2, 0.0), (0.0, 40.0, 400.0)),
}


@pytest.mark.parametrize("name", SLIDES)
def test_a_sliding_ball_turns_as_the_closed_form_says(name):
    """Fails if the motion of the axis is ignored, or if the steps of the rotation are too long."""
    segment, duration = slide(0.0, (0.0, 0.0), *SLIDES[name])
    spin, change = segment[7:10], np.array([segment[10], segment[11], 0.0])
    if abs(spin[2]) < SPIN_DECELERATION * duration:
        duration = 0.9 * abs(spin[2]) / SPIN_DECELERATION
    change[2] = -math.copysign(SPIN_DECELERATION, spin[2])
    trajectory = trajectory_of(segment, t_end=duration)
    times = duration * np.array([0.01, 0.3, 1.0])
    q = trajectory.orientation(times)[:, 0]
    for t, found in zip(times, q, strict=True):
        exact = turn_in_closed_form(spin, change, t)
        assert angle_between(found, exact) < 1e-13
        assert np.linalg.norm(found) == pytest.approx(1.0, rel=0, abs=4e-16)
    # The closed form agrees with small steps.
    assert angle_between(turn_in_small_steps(spin, change, duration), exact) < 1e-12


def test_a_ball_that_rolls_with_vertical_spin_turns_as_the_closed_form_says():
    """The path is straight, but the axis moves: a rotation by s / R would be wrong."""
    segment, duration = roll(0.0, (0.0, 0.0), (0.6, -0.8), 90.0)
    duration = min(duration, 5.0)
    spin = np.array([0.8, 0.6, 90.0 * R]) / R
    change = np.array([segment[6] / -R, segment[5] / R, -SPIN_DECELERATION])
    (q,) = trajectory_of(segment, t_end=duration).orientation(np.array([duration]))[:, 0]
    exact = turn_in_closed_form(spin, change, duration)
    assert angle_between(q, exact) < 1e-12


def test_vertical_spin_ends_within_a_segment():
    """Fails if the spin continues past 0, or if its end is missed."""
    ends, after = 0.3, 0.25
    segment, _ = slide(0.0, (0.0, 0.0), (4.0, 0.0), (30.0, -50.0, -SPIN_DECELERATION * ends))
    change = np.array([segment[10], segment[11], SPIN_DECELERATION])
    first = turn_in_closed_form(segment[7:10], change, ends)
    then = segment[7:10] + ends * change
    then[2] = change[2] = 0.0
    second = turn_in_closed_form(then, change, after)
    trajectory = trajectory_of(segment, t_end=1.0)
    q = trajectory.orientation(np.array([ends, ends + after]))[:, 0]
    assert angle_between(q[0], first) < 1e-13
    assert angle_between(q[1], product(second, first)) < 1e-13


def test_a_contact_step_changes_the_vertical_spin_besides_its_decay():
    """The decay ends with the segment's own spin; the added spin continues."""
    segment, _ = slide(0.0, (0.0, 0.0), (4.0, 0.0), (30.0, -50.0, 2.0))
    segment[12] = 7.0
    change = np.array([segment[10], segment[11], 7.0 - SPIN_DECELERATION])
    first = turn_in_closed_form(segment[7:10], change, 0.2)
    then = segment[7:10] + 0.2 * change
    assert then[2] == pytest.approx(1.4)
    change[2] = 7.0
    second = turn_in_closed_form(then, change, 0.3)
    (q,) = trajectory_of(segment, t_end=1.0).orientation(np.array([0.5]))[:, 0]
    assert angle_between(q, product(second, first)) < 1e-13


def test_a_ball_that_spins_in_place_turns_about_the_vertical():
    trajectory = trajectory_of(rest(0.0, (0.0, 0.0), 3.0), t_end=2.0)
    times = np.array([0.1, 0.3, 1.0])
    angle = [0.3 - 0.05, 0.45, 0.45]  # 3 t - 5 t^2 until 0.3 s
    q = trajectory.orientation(times)[:, 0]
    assert q[:, 0] == pytest.approx(np.cos(np.array(angle) / 2), abs=1e-15)
    assert q[:, 3] == pytest.approx(np.sin(np.array(angle) / 2), abs=1e-15)
    assert np.all(q[:, 1:3] == 0.0)


def test_a_straight_slide_turns_about_its_one_axis():
    """Stun and draw along x: the axis stays, and the turn is the integral of the spin."""
    segment, duration = slide(0.0, (0.0, 0.0), (2.0, 0.0), (0.0, -60.0, 0.0))
    q = trajectory_of(segment, t_end=duration).orientation(np.array([duration]))[0, 0]
    angle = -60.0 * duration + segment[11] * duration**2 / 2
    assert q == pytest.approx([math.cos(angle / 2), 0, math.sin(angle / 2), 0], abs=1e-14)


def test_through_a_whole_shot_the_quaternion_follows_the_angular_velocity():
    """dq/dt = w q / 2 while sliding, rolling, resting and spinning; fails if a piece is wrong."""
    trajectory = whole_shot((1.0, 0.3), (20.0, -50.0, 150.0))
    starts = trajectory.segments[0][:, 0]
    times = np.linspace(0.0, trajectory.t_end, 302)[1:-1]
    times = times[np.min(np.abs(times[:, None] - starts), axis=1) > 1e-3]
    h = 1e-5
    before, q, after = (trajectory.orientation(times + s)[:, 0] for s in (-h, 0.0, h))
    spin = trajectory.sample(times).angular_velocities[:, 0]
    expected = np.array([product([0.0, *w], p) / 2 for w, p in zip(spin, q, strict=True)])
    assert np.max(np.abs((after - before) / (2 * h) - expected)) < 1e-4 * np.max(np.abs(spin))
    assert np.allclose(np.linalg.norm(q, axis=1), 1.0, rtol=0, atol=4e-16)


def test_the_orientation_at_an_instant_does_not_depend_on_the_others_asked_for():
    trajectory = whole_shot((1.0, 0.3), (20.0, -50.0, 150.0))
    times = np.linspace(0.0, trajectory.t_end, 50)
    together = trajectory.orientation(times)
    assert np.array_equal(
        together, np.concatenate([trajectory.orientation(t) for t in times[:, None]])
    )
    assert np.array_equal(together[::-1], trajectory.orientation(times[::-1]))
    assert trajectory.orientation(np.array([])).shape == (0, 1, 4)


def test_a_turn_that_can_not_be_followed_is_refused():
    trajectory = whole_shot((1.0, 0.3), (20.0, -50.0, 1e8))
    with pytest.raises(GhostballError, match=r"`orientation`.* rad .*Set a smaller `t_max`"):
        trajectory.orientation(np.array([0.0]))


def test_the_published_turn_with_a_moving_axis():
    """Separately computed numbers with 30 digits: w0 (0, 30, 20), alpha (10, -15, -10), 0.5 s."""
    spin = np.array([[[0.0, 30.0, 20.0], [10.0, -15.0, -10.0]]])
    pieces = Pieces(np.zeros(1), np.array([0.5]), spin)
    (q,) = orientation_at(np.array([0.5]), pieces)
    published = [
        -0.067751142398126465,
        0.090039045551562179,
        0.81625418516057009,
        0.56659673330135452,
    ]
    assert angle_between(q, published) < 1e-15


@given(
    axis=st.tuples(*[st.floats(-1.0, 1.0)] * 3),
    powers=st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=6),
)
def test_the_power_series_turns_about_a_fixed_axis_as_its_integral_says(axis, powers):
    """This includes a spin that changes its sign within the step, the worst case of the series."""
    norm = np.linalg.norm(axis)
    unit = np.array(axis) / norm if norm > 1e-3 else np.array([0.0, 0.0, 1.0])
    spin = (STEP_TURN / len(powers) * np.array(powers))[None, :, None] * unit
    one = np.array([1.0])
    assert series_turn(spin, one, terms_needed(spin, one)) == pytest.approx(
        fixed_axis_turn(spin, one), rel=0, abs=1e-15
    )


@pytest.mark.parametrize("degree", [0, 1, 2, 7])
def test_what_the_power_series_leaves_out_is_below_rounding(degree):
    """The recurrence in absolute values bounds the remainder for the largest step."""
    spin = np.zeros((1, degree + 1, 3))
    spin[0, :, degree % 3] = STEP_TURN / (degree + 1)
    terms = terms_needed(spin, np.array([1.0]))
    bounds = [1.0]
    for n in range(1, 400):
        bounds.append(0.5 * STEP_TURN / (degree + 1) * sum(bounds[-degree - 1 :]) / n)
    assert sum(bounds[terms:]) <= TRUNCATION


def test_a_spin_of_a_higher_degree_turns_as_small_steps_of_it_do():
    """Motion in air needs this; fails if a power is lost, or if a step starts with a wrong spin."""
    powers = np.array([[3.0, -40.0, 9.0], [20.0, 5.0, -30.0], [-8.0, 30.0, 2.0], [5.0, 5.0, -9.0]])
    (q,) = orientation_at(np.array([0.9]), Pieces(np.zeros(1), np.array([0.9]), powers[None]))
    steps = 3000
    expected = np.array([1.0, 0.0, 0.0, 0.0])
    for k in range(steps):
        s, h = 0.9 * k / steps, 0.9 / steps
        first, last = (sum(c * x**p for p, c in enumerate(powers)) for x in (s, s + h))
        expected = product(turn_in_small_steps(first, (last - first) / h, h, 1), expected)
    assert angle_between(q, expected) < 1e-6  # the chords of a curve


def test_frames_turn_a_ball_by_their_angular_velocities():
    """The rotation is linear between frames, even if two frames have one time, as in collisions."""
    times = np.array([0.0, 0.5, 0.5, 1.0])
    spins = np.zeros((4, 1, 3))
    spins[:, 0, 2] = 2.0, 4.0, -1.0, -1.0
    frames = SampledTrajectory(times, np.zeros((4, 1, 3)), np.zeros((4, 1, 3)), spins)
    q = frames.orientation(np.array([0.25, 0.5, 1.0, 2.0]))[:, 0]
    angle = np.array([0.625, 1.5, 1.0, 1.0])
    assert q[:, 0] == pytest.approx(np.cos(angle / 2), abs=1e-15)
    assert q[:, 3] == pytest.approx(np.sin(angle / 2), abs=1e-15)


def test_each_ball_turns_on_its_own():
    both = [whole_shot((1.0, 0.3), (20.0, -50.0, 150.0)), whole_shot((0.0, 0.9), (0.0, 0.0, 3.0))]
    end = max(one.t_end for one in both)
    trajectory = ExactTrajectory(
        np.array([R, R]),
        (both[0].segments[0], both[1].segments[0]),
        end,
        np.full(2, SPIN_DECELERATION),
    )
    times = np.linspace(0.0, min(one.t_end for one in both), 20)
    expected = np.concatenate([one.orientation(times) for one in both], axis=1)
    assert np.array_equal(trajectory.orientation(times), expected)
