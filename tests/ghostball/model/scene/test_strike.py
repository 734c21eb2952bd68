"""The cue stroke agrees with numbers to 17 digits and with an oracle, and refuses bad input."""

from __future__ import annotations

import math
import random

import mpmath
import numpy as np
import pytest
from refusals import refusal_of

from ghostball.engine import simulate
from ghostball.model import POOL_BALL_MASS, POOL_BALL_RADIUS, Ball, EventKind, Physics, Scene
from ghostball.model.scene import Strike, stroke_of
from ghostball.model.scene.strike import bounced

TEN = math.radians(10.0)
NO_SQUIRT = {"squirt": "none", "direction": 0.0}
END = {"end_mass": POOL_BALL_MASS / 25.0, "direction": 0.0}


def stroke(**fields):
    return stroke_of(Strike(**fields), POOL_BALL_RADIUS, POOL_BALL_MASS)


def near(vector):
    return pytest.approx(vector, rel=4e-15, abs=4e-15)


# The formula of Leckie and Greenspan, evaluated at 30 digits; a cue of 0.567 kg and a pool ball.
NO_END = [
    (
        {"speed": 2.0, "tip_restitution": 1.0},
        (3.0769356000634923, 0.0, 0.0),
        (0.0, 0.0, 0.0),
        1.0769356000634923,
    ),
    (
        {"speed": 3.0, "offset_left": -0.2, "offset_up": 0.3, "elevation": TEN}
        | {"tip_restitution": 1.0},
        (3.6362250814519345, 0.0, -0.64116458978881174),
        (11.218977949060573, 96.911278596133989, 63.625985677199204),
        1.8923236217293341,
    ),
    (
        {"speed": 3.0, "offset_left": -0.2, "offset_up": 0.3, "elevation": TEN},
        (3.1453346954559234, 0.0, -0.55460737016732215),
        (9.7044159259373955, 83.8282559856559, 55.036477610777312),
        2.041859932795874,
    ),
]


@pytest.mark.parametrize(("fields", "velocity", "spin", "cue_speed"), NO_END)
def test_a_cue_that_gives_way_across_its_axis(fields, velocity, spin, cue_speed):
    found = stroke(**NO_SQUIRT, **fields)
    assert found.velocity == near(velocity)
    assert found.angular_velocity == near(spin)
    assert found.cue_speed == near(cue_speed)


# Alciatore's assumption in proof A.31, an end mass across the cue, also used for the speeds.
WITH_END = [
    (
        {"speed": 3.0, "offset_left": 0.3, "tip_restitution": 1.0},
        (3.9817073443891113, -0.10075084149555799, 0.0),
        (0.0, 0.0, -96.098165007731893),
        -1.4494702848598342,
    ),
    (
        {"speed": 3.0, "offset_left": 0.3, "offset_up": 0.2, "tip_restitution": 0.75},
        (3.2814428301935897, -0.081474519391986244, -0.054316346261324163),
        (0.0, 52.98562126009611, -79.478431890144165),
        -1.4221025478323005,
    ),
]


@pytest.mark.parametrize(("fields", "velocity", "spin", "degrees"), WITH_END)
def test_a_cue_whose_end_has_a_mass(fields, velocity, spin, degrees):
    found = stroke(**END, **fields)
    assert found.velocity == near(velocity)
    assert found.angular_velocity == near(spin)
    x, y, z = found.velocity
    assert math.degrees(math.atan2(y, math.hypot(x, z))) == near(degrees)


def test_squirt_is_that_of_alciatore_s_proof_with_either_law_where_the_cue_is_level():
    published = 1.1993583313332898  # degrees; the ball has 20 end masses, and is hit at 0.2 radii
    for squirt in ("end-mass", "alciatore"):
        x, y, _ = stroke(
            speed=1.7, direction=0.0, offset_left=0.2, squirt=squirt, end_mass=POOL_BALL_MASS / 20.0
        ).velocity
        assert math.degrees(math.atan2(y, x)) == near(-published)


def test_alciatore_s_law_turns_the_velocity_alone():
    fields = {"speed": 3.0, "direction": 0.7, "offset_left": 0.3, "offset_up": -0.2}
    plain = stroke(**fields, elevation=0.4, squirt="none")
    turned = stroke(**fields, elevation=0.4, squirt="alciatore")
    assert turned.angular_velocity == plain.angular_velocity
    assert math.hypot(*turned.velocity) == near(math.hypot(*plain.velocity))
    assert turned.velocity[2] == plain.velocity[2]


def by_linear_equations(strike, radius, mass):
    """Return J / m and the angular velocity along d, l, p, by solving the linear equations."""
    with mpmath.workdps(40):
        a, b = mpmath.mpf(strike.offset_left), mpmath.mpf(strike.offset_up)
        arm = mpmath.matrix([-mpmath.sqrt(1 - a**2 - b**2), a, b]) * radius
        cross = mpmath.matrix([[0, -arm[2], arm[1]], [arm[2], 0, -arm[0]], [-arm[1], arm[0], 0]])
        inertia = mpmath.mpf(2) / 5 * mass * mpmath.mpf(radius) ** 2
        equations = mpmath.eye(3) / mass + cross.T * cross / inertia
        end = mpmath.mpf(strike.end_mass)
        for k, moved in enumerate((mpmath.mpf(strike.cue_mass), end, end)):
            equations[k, k] += 1 / moved
        change = (1 + mpmath.mpf(strike.tip_restitution)) * strike.speed
        impulse = mpmath.lu_solve(equations, mpmath.matrix([change, 0, 0]))
        spin = cross * impulse / inertia
        return [float(x / mass) for x in impulse], [float(w) for w in spin]


@pytest.mark.parametrize("seed", range(20))
def test_the_equation_is_solved(seed):
    chance = random.Random(seed)
    radius, mass = chance.uniform(0.01, 0.05), chance.uniform(0.05, 1.0)
    strike = Strike(
        speed=chance.uniform(0.1, 12.0),
        direction=0.0,
        offset_left=chance.uniform(-0.35, 0.35),
        offset_up=chance.uniform(-0.35, 0.35),
        cue_mass=chance.uniform(0.2, 0.7),
        end_mass=chance.uniform(0.002, 0.05),
        tip_restitution=chance.uniform(0.0, 1.0),
    )
    velocity, spin = by_linear_equations(strike, radius, mass)
    found = stroke_of(strike, radius, mass)
    assert found.velocity == pytest.approx(velocity, rel=1e-14, abs=1e-15)
    assert found.angular_velocity == pytest.approx(spin, rel=1e-13, abs=1e-13)


@pytest.mark.parametrize("squirt", ["end-mass", "none"])
def test_impulse_and_energy_are_those_of_two_bodies(squirt):
    # With an elastic tip and no end mass, the ball gains the energy that the cue loses; an end mass
    # takes a part.
    fields = {"speed": 3.0, "direction": 0.4, "elevation": 0.3, "offset_left": 0.2}
    strike = Strike(**fields, offset_up=-0.3, tip_restitution=1.0, squirt=squirt)
    found = stroke_of(strike, POOL_BALL_RADIUS, POOL_BALL_MASS)
    velocity, spin = map(np.array, found[:2])
    inertia = 0.4 * POOL_BALL_MASS * POOL_BALL_RADIUS**2
    ball = 0.5 * (POOL_BALL_MASS * velocity @ velocity + inertia * spin @ spin)
    cue = 0.5 * strike.cue_mass * (3.0**2 - found.cue_speed**2)
    lift, along = math.sin(0.3), math.cos(0.3)
    axis = np.array([along * math.cos(0.4), along * math.sin(0.4), -lift])
    across = POOL_BALL_MASS * (velocity - (velocity @ axis) * axis)
    end = 0.0 if squirt == "none" else 0.5 * across @ across / strike.end_mass
    assert ball + end == pytest.approx(cue, rel=1e-14)
    if squirt == "none":
        assert np.linalg.norm(across) < 1e-15


@pytest.mark.parametrize("squirt", ["end-mass", "alciatore", "none"])
def test_a_stroke_mirrored_and_scaled(squirt):
    fields = {"speed": 3.0, "elevation": 0.3, "offset_up": 0.1, "squirt": squirt}
    one = stroke(**fields, direction=0.6, offset_left=0.25)
    other = stroke(**fields, direction=-0.6, offset_left=-0.25)
    x, y, z = one.velocity
    wx, wy, wz = one.angular_velocity
    assert other.velocity == (x, -y, z)
    assert other.angular_velocity == (-wx, wy, -wz)
    faster = stroke(**fields | {"speed": 6.0}, direction=0.6, offset_left=0.25)
    assert faster.velocity == (2.0 * x, 2.0 * y, 2.0 * z)
    assert faster.angular_velocity == (2.0 * wx, 2.0 * wy, 2.0 * wz)


def test_a_level_hit_two_fifths_above_the_centre_rolls_at_once():
    struck = {"id": "a", "position": (0.0, 0.0)}
    rolls = {"speed": 2.0, "direction": 0.9, "offset_up": 0.4, "squirt": "none"}
    scene = Scene(name="a", balls=[Ball(**struck, strike=Strike(**rolls))])
    assert scene.physics.motion == "rolling"
    assert scene.rolls.tolist() == [True]
    for wrong in ({"offset_up": 0.39}, {"offset_left": 0.1}, {"squirt": "end-mass"}):
        message = refusal_of(
            lambda wrong=wrong: Scene(
                name="a", balls=[Ball(**struck, strike=Strike(**rolls | wrong))]
            )
        )
        assert '`balls[0].strike` must make the ball roll without slip if `motion` = "rolling"' in (
            message
        )
        assert '"sliding"' in message


# -- the table's answer --------------------------------------------------------------------------

BOUNCES = [  # of a pool ball, with a restitution of 0.5 and a friction of 0.2
    ((2.0, 0.0, -1.0), (0.0, 0.0, 0.0), (1.7, 0.0, 0.5), (0.0, 26.246719160104987, 0.0)),
    (
        (0.5, 0.0, -2.0),
        (0.0, 0.0, 40.0),
        (0.35714285714285714, 0.0, 1.0),
        (0.0, 12.498437695288089, 40.0),
    ),
    (
        (1.0, 0.5, -1.0),
        (20.0, -30.0, 10.0),
        (0.74014490651493903, 0.35008225458648925, 0.5),
        (6.88383679671822, -7.2655211299159254, 10.0),
    ),
]


@pytest.mark.parametrize(("velocity", "spin", "velocity_after", "spin_after"), BOUNCES)
def test_the_table_answers_to_a_ball_that_is_pushed_down(
    velocity, spin, velocity_after, spin_after
):
    rising = [1.0, 2.0, 0.5]  # a ball that isn't pushed down
    velocities, spins = np.array([velocity, rising]), np.array([spin, rising])
    found = bounced(velocities, spins, POOL_BALL_RADIUS, 0.2, 0.5)
    assert found[0].tolist() == [near(velocity_after), rising]
    assert found[1].tolist() == [near(spin_after), rising]


@pytest.mark.parametrize("seed", range(6))
def test_the_table_answers_as_the_engine_lets_it(seed):
    chance = random.Random(seed)
    physics = Physics(preset="pool", airborne=True, table_restitution=chance.uniform(0.3, 0.9))
    spin = tuple(chance.uniform(-100.0, 100.0) for _ in range(3))
    fall = {"velocity": (chance.uniform(-3.0, 3.0), 1.0, 0.0), "angular_velocity": spin}
    ball = Ball(id="a", position=(0.0, 0.0, POOL_BALL_RADIUS + 0.2), **fall)
    result = simulate(Scene(name="a", balls=[ball], physics=physics), record="trajectory")
    landing = next(row["t"] for row in result.events if row["kind"] == EventKind.BALL_CLOTH)
    after = result.sample([math.nextafter(landing, math.inf)])
    down = -math.sqrt(2.0 * physics.gravity * 0.2)
    velocity, spin = bounced(
        np.array([(*fall["velocity"][:2], down)]),
        np.array([spin]),
        POOL_BALL_RADIUS,
        physics.sliding_friction,
        physics.table_restitution,
    )
    assert after.velocities[0, 0].tolist() == pytest.approx(velocity[0], rel=1e-9, abs=1e-9)
    assert after.angular_velocities[0, 0].tolist() == pytest.approx(spin[0], rel=1e-6, abs=1e-6)


# -- what is refused -----------------------------------------------------------------------------

WRONG = [
    {"elevation": 60},
    {"elevation": math.pi / 2},
    {"elevation": -0.01},
    {"direction": 90},
    {"direction": -6.3},
    {"offset_left": 0.6},
    {"offset_left": 0.4, "offset_up": -0.35},
    {"offset_up": 0.3, "tip_friction": 0.2},
    {"offset_left": -0.8, "offset_up": 0.6},
    {"offset_up": 15},
    {"speed": 1.1e49},
    {"squirt": "none", "end_mass": 0.01},
    {"end_mass": 9.8},
]


@pytest.mark.parametrize("fields", WRONG, ids=str)
def test_what_no_cue_does_is_refused(fields, snapshot):
    assert refusal_of(lambda: Strike(**{"speed": 2.0, "direction": 0.0, **fields})) == snapshot


def test_the_friction_of_the_tip_is_the_limit_of_a_miscue():
    most = 0.6 / math.sqrt(1.36)
    for angle in np.linspace(0.0, 2.0 * math.pi, 9):
        left, up = math.cos(angle) * most, math.sin(angle) * most
        within = {"offset_left": left * (1.0 - 1e-12), "offset_up": up * (1.0 - 1e-12)}
        assert Strike(speed=1.0, direction=0.0, **within).speed == 1.0
        beyond = {"offset_left": left * (1.0 + 1e-12), "offset_up": up * (1.0 + 1e-12)}
        assert "miscue" in refusal_of(lambda b=beyond: Strike(speed=1.0, direction=0.0, **b))


@pytest.mark.parametrize(("left", "up"), [(0.0, 0.1), (0.7, -0.7), (-0.99, 0.14)])
def test_a_tip_that_never_slips_hits_anywhere_on_the_ball(left, up):
    # Even at this cue speed, the ball has speeds that a scene allows.
    fields = {"offset_left": left, "offset_up": up, "tip_friction": 1e50}
    found = stroke(speed=1e49, direction=0.3, elevation=1.5, **fields)
    assert math.hypot(*found.velocity) < 2e49
    assert POOL_BALL_RADIUS * math.hypot(*found.angular_velocity) < 5e49
