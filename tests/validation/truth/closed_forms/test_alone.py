"""Closed forms of single balls in air and in flight agree with separately computed numbers."""

from __future__ import annotations

import math

import pytest
from mpmath import mp

from ghostball.model import Ball, Physics, Scene
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.closed_forms import ClosedForm, closed_form

R = 0.028575


def solved(name: str, *balls: Ball, **physics) -> ClosedForm:
    """Return the closed form of airborne balls; the name of the scene selects the form."""
    chosen = Physics(preset="pool", airborne=True, **{"gravity": 9.81} | physics)
    form = closed_form(Scene(name=name, balls=list(balls), physics=chosen))
    assert form is not None
    return form


def test_the_numbers_of_one_ball_are_those_computed_elsewhere() -> None:
    form = closed_form(find_scene("air-slides"))
    assert form is not None
    # A stunned ball at 3 m/s slides 1.1168 m, then rolls from 2.1344 m/s: ln(1 + q^2) / 2b.
    a, b = 0.01 * 9.81, 5 * 0.0041 / 7
    on = math.log1p(b * 2.1343833222613356**2 / a) / (2 * b)
    assert float(form.rest_positions[0][0]) == pytest.approx(1.1168116256280046 + on, rel=1e-13)


def test_a_fall_and_a_throw_last_as_long_as_the_formulas_say() -> None:
    drop = Ball(id="drop", position=(0.0, 0.0, R + 0.2))
    form = solved("air-drop", drop, air_drag=0.0041, table_restitution=0.0)
    assert float(form.rest_time) == pytest.approx(0.20195510882942493, rel=1e-14)
    throw = Ball(id="throw", position=(0.0, 0.0), velocity=(0.0, 0.0, 3.0))
    form = solved("air-drop", throw, air_drag=0.0041, table_restitution=0.0)
    with mp.workdps(30):
        g, k = mp.mpf(9.81), mp.mpf(0.0041)
        height = mp.log(1 + k * 9 / g) / (2 * k)
        lasts = (mp.atan(3 * mp.sqrt(k / g)) + mp.acosh(mp.exp(k * height))) / mp.sqrt(g * k)
    assert float(form.rest_time) == pytest.approx(float(lasts), rel=1e-15)


def test_all_bounces_of_a_drop_end_after_the_sum_of_a_geometric_series() -> None:
    # From 0.1 m with e = 0.6: sqrt(2 h / g) (1 + e) / (1 - e).
    drop = Ball(id="cue", position=(1.0, 0.0, R + 0.1))
    form = solved("flight-throw", drop, table_restitution=0.6)
    assert float(form.rest_time) == pytest.approx(0.57113724917082579, rel=1e-12)


def test_a_bounce_that_slips_takes_mu_times_the_impulse() -> None:
    # (2, 0, -1) without spin becomes (1.7, 0, 0.5), wy 26.2467...: Alciatore's constants.
    drop = Ball(
        id="cue",
        position=(0.0, 0.0, R + 0.5 / 9.81),
        velocity=(2.0, 0.0, 0.0),
        angular_velocity=(0.0, 0.0, 0.0),
    )
    form = solved("flight-throw", drop, table_restitution=0.0)
    with mp.workdps(30):
        fall = 1.0 / 9.81
        # After one bounce with e = 0: velocity 2 - 0.2, slip 2 - 0.7, of which sliding takes 2/7.
        slip = 2.0 - 3.5 * 0.2
        velocity = 1.8 - 2.0 / 7.0 * slip
        slide = slip / (3.5 * 0.2 * 9.81)
        way = 2.0 * fall + (1.8 + velocity) / 2.0 * slide + velocity**2 / (2.0 * 0.01 * 9.81)
    assert float(form.rest_positions[0][0]) == pytest.approx(way, rel=1e-12)
