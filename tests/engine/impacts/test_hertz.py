"""Tests of the force of a contact that lasts, against closed forms and SciPy."""

from __future__ import annotations

import math

import pytest
from scipy.integrate import quad, solve_ivp

from ghostball.engine.impacts.hertz import (
    CONTACT_TIME,
    contact_time,
    deepest_overlap,
    fifth_root,
    loss_of,
    push,
    stiffness,
)

MODULUS = 5.84e9 / (2.0 * (1.0 - 0.34**2))
RADIUS, MASS = 0.028575, 0.5 * 0.170097


@pytest.mark.parametrize("a", [1e-60, 1e-24, 3e-7, 1.0, 3.0, 1e10])
def test_a_fifth_root_is_within_rounding(a):
    assert fifth_root(a) == pytest.approx(a**0.2, rel=4e-15)


def test_the_fifth_root_of_zero_is_zero():
    assert fifth_root(0.0) == 0.0


def test_the_duration_of_an_impact_is_the_integral_over_its_overlap():
    # 2 int_0^1 dx / sqrt(1 - x^2.5), with x = 1 - u^2 so that the integrand has no pole.
    found, _ = quad(lambda u: 4.0 * u / math.sqrt(1.0 - (1.0 - u * u) ** 2.5), 0.0, 1.0)
    assert found == pytest.approx(CONTACT_TIME, rel=1e-9)


def test_the_depth_of_an_impact_has_all_of_its_energy():
    stiff = stiffness(MODULUS, RADIUS, RADIUS)
    depth = deepest_overlap(8.5, stiff, MASS)
    assert 0.4 * stiff * depth**2.5 == pytest.approx(0.5 * MASS * 8.5**2, rel=1e-14)


def test_the_stiffness_of_two_balls_is_that_of_one_with_the_reduced_radius():
    reduced = RADIUS * 0.03 / (RADIUS + 0.03)
    expected = 4.0 / 3.0 * MODULUS * math.sqrt(reduced)
    assert stiffness(MODULUS, RADIUS, 0.03) == pytest.approx(expected, rel=1e-15)
    assert stiffness(MODULUS, 0.03, RADIUS) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize("e", [0.5, 0.7, 0.89, 0.95, 0.97, 1.0])
@pytest.mark.parametrize("speed", [1e-3, 1.0, 12.0])
def test_an_impact_has_the_restitution_of_the_scene_at_every_speed(e, speed):
    stiff, loss = stiffness(MODULUS, RADIUS, RADIUS), loss_of(e)
    energy = 0.8 * stiff / MASS

    def slopes(_, state):
        overlap, rate = state
        force = push(max(overlap, 0.0), rate, stiff, energy, loss)
        return (rate, -force / MASS)

    def parted(t, state):
        return state[0] if t > 0.0 else 1.0

    parted.terminal, parted.direction = True, -1.0
    lasts = contact_time(speed, stiff, MASS)
    depth = deepest_overlap(speed, stiff, MASS)
    found = solve_ivp(
        slopes,
        (0.0, 3.0 * lasts),
        (0.0, speed),
        method="DOP853",
        rtol=1e-11,
        atol=(1e-13 * depth, 1e-13 * speed),
        events=parted,
    )
    assert -found.y_events[0][0][1] / speed == pytest.approx(e, abs=1e-8)


def test_the_force_never_pulls_for_the_least_restitution():
    stiff, loss = stiffness(MODULUS, RADIUS, RADIUS), loss_of(0.5)
    for share in (0.0, 1e-9, 0.1, 0.5, 1.0):
        for rate in (-10.0, -1e-6, 0.0, 3.0):
            assert push(share * 1e-3, rate, stiff, 0.8 * stiff / MASS, loss) >= 0.0


def test_no_loss_without_a_loss():
    assert loss_of(1.0) == 0.0
