"""Closed forms of balls that bounce: against worked numbers, and our engine against them."""

import pytest
from mpmath import mp

from ghostball.model import Ball, Physics, Scene
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.closed_forms import closed_form

R = 0.028575


def named(name: str, *balls: Ball, **physics) -> Scene:
    """A scene that has a form of flight by its name."""
    chosen = Physics(preset="pool", airborne=True, **{"gravity": 9.81} | physics)
    return Scene(name=name, balls=list(balls), physics=chosen)


def test_all_bounces_of_a_drop_end_after_the_sum_of_a_geometric_series() -> None:
    # From 0.1 m with e = 0.6: sqrt(2 h / g) (1 + e) / (1 - e).
    drop = Ball(id="cue", position=(1.0, 0.0, R + 0.1))
    form = closed_form(named("flight-throw", drop, table_restitution=0.6))
    assert form is not None
    assert float(form.rest_time) == pytest.approx(0.57113724917082579, rel=1e-12)


def test_a_bounce_that_slips_takes_mu_times_the_impulse() -> None:
    # (2, 0, -1) without spin becomes (1.7, 0, 0.5), wy 26.2467...: Alciatore's constants.
    drop = Ball(
        id="cue",
        position=(0.0, 0.0, R + 0.5 / 9.81),
        velocity=(2.0, 0.0, 0.0),
        angular_velocity=(0.0, 0.0, 0.0),
    )
    flat = named("flight-throw", drop, table_restitution=0.0)
    form = closed_form(flat)
    assert form is not None
    with mp.workdps(30):
        fall = 1.0 / 9.81
        # What is left after one bounce of e = 0: 2 - 0.2, and 5/7 of a slip of 2 - 0.7.
        slip = 2.0 - 3.5 * 0.2
        velocity = 1.8 - 2.0 / 7.0 * slip
        slide = slip / (3.5 * 0.2 * 9.81)
        way = 2.0 * fall + (1.8 + velocity) / 2.0 * slide + velocity**2 / (2.0 * 0.01 * 9.81)
    assert float(form.rest_positions[0][0]) == pytest.approx(way, rel=1e-12)


def test_there_is_none_where_balls_come_close_or_never_stop_bouncing() -> None:
    scene = dict(find_scene("flight-throw"))
    near = Ball(id="other", position=(2.0, 0.0))
    assert closed_form(Scene(**{**scene, "balls": [*scene["balls"], near]})) is None
    elastic = scene["physics"].model_copy(update={"table_restitution": 1.0})
    assert closed_form(Scene(**{**scene, "physics": elastic, "t_max": 1.0})) is None
    # By its shape no shot in flight has one: another name, no form.
    assert closed_form(Scene(**{**scene, "name": "another"})) is None
