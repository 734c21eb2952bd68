"""Closed forms of balls that fall and are thrown up in air: against numbers, and our engine."""

import pytest
from mpmath import mp

from ghostball.model import Ball, Physics, Scene
from ghostball.validation.truth.closed_forms import closed_form

R = 0.028575


def named(*balls: Ball, **physics) -> Scene:
    """A scene that has a form of falls in air by its name."""
    given = {"air_drag": 0.0041, "gravity": 9.81} | physics
    return Scene(
        name="air-drop", balls=list(balls), physics=Physics(preset="pool", airborne=True, **given)
    )


def test_a_fall_and_a_throw_last_as_long_as_the_formulas_say() -> None:
    drop = Ball(id="drop", position=(0.0, 0.0, R + 0.2))
    form = closed_form(named(drop, table_restitution=0.0))
    assert form is not None
    assert float(form.rest_time) == pytest.approx(0.20195510882942493, rel=1e-14)
    throw = Ball(id="throw", position=(0.0, 0.0), velocity=(0.0, 0.0, 3.0))
    form = closed_form(named(throw, table_restitution=0.0))
    assert form is not None
    with mp.workdps(30):
        g, k = mp.mpf(9.81), mp.mpf(0.0041)
        height = mp.log(1 + k * 9 / g) / (2 * k)
        lasts = (mp.atan(3 * mp.sqrt(k / g)) + mp.acosh(mp.exp(k * height))) / mp.sqrt(g * k)
    assert float(form.rest_time) == pytest.approx(float(lasts), rel=1e-15)


@pytest.mark.parametrize(
    "ball",
    [
        Ball(id="aside", position=(0.0, 1.0, 0.2), velocity=(0.1, 0.0, 0.0)),
        Ball(id="spins", position=(0.0, 1.0, 0.2), angular_velocity=(0.0, 0.0, 1.0)),
        Ball(id="above", position=(0.0, 0.01, 0.5)),
    ],
)
def test_there_is_none_where_balls_go_aside_spin_or_may_meet(ball: Ball) -> None:
    assert closed_form(named(Ball(id="drop", position=(0.0, 0.0, 0.2)), ball)) is None
