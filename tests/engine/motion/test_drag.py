"""Tests of motion in air, against closed forms.

`tests/engine/motion/test_slide_series.py` compares turning slides with an integration.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from mpmath import mp, mpf
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.engine.core.tolerances import EPS, SLIDE_ERROR
from ghostball.model import EventKind, Status, Table

K = 0.0041
G = 9.81
POOL = {"preset": "pool", "air_drag": K}


def played(velocity, spin=None, t_max=None, **physics):
    scene = scene_of(
        ball((0.0, 0.0), velocity, angular_velocity=spin), t_max=t_max, **(POOL | physics)
    )
    return simulate(scene, record="trajectory")


# --- published numbers, computed with 30 digits by other code


@pytest.mark.parametrize(
    ("speed", "physics", "time", "distance"),
    [
        (2.0, {}, 19.629465424815389, 19.259093295102175),
        (8.0, {}, 55.723414139105355, 182.40202751261116),
        (2.0, {"preset": "paper"}, 9.9231021048020829, 9.7899900947054689),
    ],
    ids=["2 m/s", "8 m/s", "the paper's point"],
)
def test_a_roll_has_the_duration_and_length_of_the_closed_form(speed, physics, time, distance):
    """Fails if the cloth's friction doesn't take its 2/7, or takes them in the paper's model."""
    result = played((speed, 0.0), **physics)
    assert result.rest_time == pytest.approx(time, rel=4 * EPS)
    assert result.rest_positions[0, 0] == pytest.approx(distance, rel=8 * EPS)


def test_a_roll_is_where_the_closed_form_says():
    result = played((2.0, 0.0))
    states = result.sample([5.0, 5.9521690053140506])
    assert states.velocities[0, 0, 0] == pytest.approx(1.4653067196992342, rel=4 * EPS)
    assert states.positions[:, 0, 0] == pytest.approx([8.6519743223088194, 10.0], rel=4 * EPS)


def test_a_stunned_ball_slides_along_a_line():
    result = played((3.0, 0.0), (0.0, 0.0, 0.0))
    end = result.events["t"][0]
    assert end == pytest.approx(0.43514440820822335, rel=4 * EPS)
    state = result.sample([end])
    assert state.positions[0, 0, 0] == pytest.approx(1.1168116256280046, rel=4 * EPS)
    assert state.velocities[0, 0, 0] == pytest.approx(2.1343833222613356, rel=4 * EPS)


def test_a_slide_with_side_turns():
    result = played((3.0, 0.0), (-50.0, 60.0, 0.0))
    assert result.events["kind"][0] == EventKind.SLIDE_TO_ROLL
    end = result.events["t"][0]
    assert end == pytest.approx(0.27906760072226945, rel=4 * EPS)
    state = result.sample([end])
    place = [0.78488866111409261, 0.056830779037561494]
    assert state.positions[0, 0, :2] == pytest.approx(place, abs=SLIDE_ERROR)
    velocity = [2.6262173230896689, 0.40775401791915694]
    assert state.velocities[0, 0, :2] == pytest.approx(velocity, abs=SLIDE_ERROR)
    # From this time the ball rolls; its spin just before agrees with rolling, too.
    before = result.sample([end * (1 - 1e-12)])
    rolling = np.array([-velocity[1], velocity[0]]) / R
    assert before.angular_velocities[0, 0, :2] == pytest.approx(rolling, rel=1e-11)


def test_rolling_friction_that_grows_with_the_speed_is_beside_the_air():
    """With a + b v^2, a = mu g, a roll is ln(1 + b v^2 / a) / 2b long; air adds 5/7 of k to b."""
    a, v = 0.01 * G, 2.0
    for physics, b in (
        ({"rolling_friction_quadratic": 0.0088}, 0.0088),
        ({"rolling_friction_quadratic": 0.0088, "air_drag": K}, 0.0088 + 5 * K / 7),
        ({"rolling_friction_quadratic": 0.02, "rolling_friction": 0.01, "preset": "paper"}, 0.02),
    ):
        result = played((v, 0.0), **({"air_drag": 0.0} | physics))
        assert result.rest_positions[0, 0] == pytest.approx(
            math.log1p(b * v * v / a) / (2 * b), rel=8 * EPS
        )


def test_the_end_of_an_accelerating_slip_is_not_missed():
    """Air slows a ball ever less against its slip, so Newton's first step is too long.

    The step may go beyond the end of the piece, and must come back: the slide ends in the piece.
    """
    k, v = 10.0, 0.7
    u, a = 0.0076, 0.2 * G
    result = played((v, 0.0), (0.0, (v + u) / R, 0.0), air_drag=k)
    assert result.events["kind"][0] == EventKind.SLIDE_TO_ROLL
    # The solution of v' = a - k v^2 is w coth(...), and the spin reduces the slip by 5/2 a t.
    with mp.workdps(30):
        w = mp.sqrt(mpf(a) / k)
        start = mp.atanh(w / v) / mp.sqrt(mpf(a) * k)  # time since the speed was infinite
        rate = mp.sqrt(mpf(a) * k)
        end = mp.findroot(
            lambda t: w * mp.coth(rate * (t + start)) - (v + u) + mpf(5) / 2 * a * t, 0.0037
        )
    assert result.events["t"][0] == pytest.approx(float(end), rel=1e-12)


def test_a_ball_whose_squared_speed_underflows_stops_in_air():
    result = played((1e-170, 0.0))
    assert result.status is Status.REST
    assert result.rest_positions[0, 0] == pytest.approx(0.0, abs=1e-300)


# --- contacts


def test_a_resting_ball_is_hit_at_the_time_of_the_closed_form():
    """v(x)^2 = (v0^2 + a/b) exp(-2 b x) - a/b, t = (atan(q) - atan(v sqrt(b/a))) / sqrt(a b)."""
    scene = scene_of(ball((0.0, 0.0), (2.0, 0.0)), ball((10.0 + 2 * R, 0.0)), **POOL)
    result = simulate(scene, record="events")
    assert result.events["t"][0] == pytest.approx(5.9521690053140506, rel=8 * EPS)


@pytest.mark.parametrize("v", [0.5, 3.0, 8.0])
def test_a_cushion_is_hit_at_the_time_of_the_closed_form(v):
    a, b = mpf(0.01) * mpf(G), 5 * mpf(K) / 7
    way = mpf(1.2) - mpf(R)
    left = mp.sqrt((v * v + a / b) * mp.exp(-2 * b * way) - a / b)
    t = (mp.atan(v * mp.sqrt(b / a)) - mp.atan(left * mp.sqrt(b / a))) / mp.sqrt(a * b)
    table = Table(length=1.2, width=1.0, cushions=("right",))
    scene = scene_of(ball((0.0, 0.5), (v, 0.0)), table=table, **POOL)
    result = simulate(scene, record="events")
    assert result.events["kind"][0] == EventKind.BALL_CUSHION
    assert result.events["t"][0] == pytest.approx(float(t), rel=8 * EPS)


def test_without_friction_only_the_air_slows():
    """v = v0 / (1 + k v0 t): the ball never stops, so the scene needs `t_max`."""
    scene = scene_of(
        ball((0.0, 0.0), (3.0, 0.0), angular_velocity=(0.0, 0.0, 0.0)),
        ball((0.0, 1.0), (3.0, 0.0)),
        t_max=30.0,
        **(POOL | {"rolling_friction": 0.0, "sliding_friction": 0.0}),
    )
    result = simulate(scene, record="trajectory")
    assert result.status is Status.T_MAX
    for i, k in ((0, K), (1, 5 * K / 7)):
        v = 3.0 / (1.0 + k * 3.0 * 30.0)
        x = math.log1p(k * 3.0 * 30.0) / k
        assert result.final_state.velocities[0, i, 0] == pytest.approx(v, rel=1e-14)
        assert result.rest_positions[i, 0] == pytest.approx(x, rel=1e-14)


def test_orientation_follows_the_angular_velocity_through_a_slide_and_a_roll():
    result = played((3.0, 0.4), (-50.0, -60.0, 30.0))
    times = np.array([0.1, 0.3, 0.5, 2.0, 4.0])
    h = 1e-5
    before, q, after = (result.orientation(times + s)[:, 0] for s in (-h, 0.0, h))
    w = result.sample(times).angular_velocities[:, 0]
    for a, here, b, spin in zip(before, q, after, w, strict=True):
        x, y, z = spin
        matrix = np.array([[0, -x, -y, -z], [x, 0, -z, y], [y, z, 0, -x], [z, -y, x, 0]])
        assert (b - a) / (2 * h) == pytest.approx(
            0.5 * matrix @ here, abs=2e-5 * max(1, abs(spin).max())
        )


def test_touching_balls_with_equal_velocity_in_air_roll_like_one_ball():
    """The jerks by air once looked like an approach: contact steps held the balls, 1e-11 m off."""
    alone = scene_of(ball((0.0, 0.0), (1.0, 0.0)), air_drag=0.0041)
    both = scene_of(ball((0.0, 0.0), (1.0, 0.0)), ball((2.0 * R, 0.0), (1.0, 0.0)), air_drag=0.0041)
    result = simulate(both)
    assert result.rest_positions[0, 0] == simulate(alone).rest_positions[0, 0]
    assert result.work["contact_steps"] == 0
    assert result.work["advancement_steps"] < 20


def test_touching_balls_after_an_inelastic_collision_continue_in_air_without_friction():
    """The cloth can't push the balls together, so a contact step once had no length."""
    scene = scene_of(
        ball((0.9736669107529253, 0.0), (-5.626838330323487, 0.0)),
        ball((0.31768120373487063, 0.0)),
        air_drag=0.023679174653121488, rolling_friction=0.0, ball_restitution=0.0, t_max=0.5,
    )  # fmt: skip
    result = simulate(scene, record="events")
    assert result.status is Status.T_MAX
    collision = result.events["t"][0]
    velocities = result.sample([collision, collision + 0.2]).velocities[:, :, 0]
    assert velocities[:, 0] == pytest.approx(velocities[:, 1], rel=1e-15)
    slowed = velocities[0, 0] / (1.0 - 0.023679174653121488 * velocities[0, 0] * 0.2)
    assert velocities[1, 0] == pytest.approx(slowed, rel=1e-13)
