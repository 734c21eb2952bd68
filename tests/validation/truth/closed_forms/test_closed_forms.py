from __future__ import annotations

import math

import pytest
from mpmath import mp

from ghostball.model import Ball, Physics, Scene
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.closed_forms import closed_form, has_closed_form

# Closed forms of balls in air, against numbers computed elsewhere


def test_the_numbers_of_one_ball_are_those_computed_elsewhere() -> None:
    form = closed_form(find_scene("air-slides"))
    assert form is not None
    # A stunned ball of 3 m/s slides 1.1168 m, and rolls on at 2.1344 m/s: ln(1 + q^2) / 2b.
    a, b = 0.01 * 9.81, 5 * 0.0041 / 7
    on = math.log1p(b * 2.1343833222613356**2 / a) / (2 * b)
    assert float(form.rest_positions[0][0]) == pytest.approx(1.1168116256280046 + on, rel=1e-13)


def test_a_scene_of_that_name_without_air_or_with_a_slip_across_has_none() -> None:
    scene = find_scene("air-slides")
    assert not has_closed_form(scene.model_copy(update={"physics": Physics(preset="pool")}))
    turned = scene.balls[0].model_copy(update={"angular_velocity": (1.0, 0.0, 0.0)})
    assert not has_closed_form(scene.model_copy(update={"balls": (turned, *scene.balls[1:])}))
    crossing = scene.balls[0].model_copy(update={"position": (0.0, 0.48)})
    assert not has_closed_form(scene.model_copy(update={"balls": (crossing, *scene.balls[1:])}))


# Closed forms of balls that fall and are thrown up in air: against numbers, and our engine


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
