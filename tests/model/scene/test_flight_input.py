"""What makes no sense in flight is refused by name; the cloth's own rules are in `test_scene`."""

from typing import Any

import pytest

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene, SceneError, Table, UnsupportedSceneError

FLIES: dict[str, Any] = {"motion": "sliding", "airborne": True}


def flying(position: tuple[float, ...], velocity: tuple[float, ...] = (0.0, 0.0), **more) -> Scene:
    """One ball that may leave the cloth of a table."""
    return Scene(
        name="flight",
        balls=[Ball(id="cue", position=position, velocity=velocity)],
        table=Table(length=2.54, width=1.27),
        physics=Physics(**FLIES | more),
    )


@pytest.mark.parametrize(
    ("physics", "message"),
    [
        ({"airborne": True}, '`motion` must be "sliding" where `airborne` = true, got "rolling"'),
        ({"preset": "paper", "airborne": True}, '`motion` must be "sliding" where `airborne`'),
        (FLIES | {"ball_impact": "mathavan2014"}, '`ball_impact` must be "frictional" where'),
        (FLIES | {"cushion": "mathavan2010"}, '`cushion` must be "mirror", "restitution"'),
        (FLIES | {"table_restitution": 1.5}, "`table_restitution` must be at most 1, got 1.5"),
        (FLIES | {"table_restitution": -0.1}, "`table_restitution` must be at least 0, got -0.1"),
        (FLIES | {"table_restitution": float("nan")}, "`table_restitution` must be a finite"),
        (FLIES | {"gravity": 0.0}, "`gravity` must be greater than 0, got 0.0"),
    ],
)
def test_physics_that_cannot_fly(physics: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError) as refused:
        Physics(**physics)
    assert message in str(refused.value)


@pytest.mark.parametrize(
    ("position", "velocity", "message"),
    [
        ((1.0, 0.5, 0.02), (0.0, 0.0), "z must be at least the radius, 0.028575 m, got 0.02 m"),
        ((1.0, 0.5, -0.1), (0.0, 0.0), "the ball would be inside the table"),
        ((1.0, 0.5), (1.0, 0.0, -1.0), "`balls[0].velocity` z must be at least 0 of a ball that"),
        ((1.0, 0.5), (0.0, 0.0, float("nan")), "`velocity[2]` must be a finite number, got nan"),
        ((1.0, 0.5, float("inf")), (0.0, 0.0), "`position[2]` must be a finite number, got inf"),
        ((1.0, 0.5, 1e200), (0.0, 0.0), "`position[2]` must be at most 1e+50"),
        ((0.014, 0.5), (0.0, 0.0), "beyond the left cushion"),
        ((-0.1, 0.5, 0.1), (0.0, 0.0), "beyond the left cushion"),
    ],
)
def test_balls_where_none_can_be(position: Any, velocity: Any, message: str) -> None:
    with pytest.raises(SceneError) as refused:
        flying(position, velocity)
    assert message in str(refused.value)


def test_drag_in_flight_is_refused_and_of_a_cloth_it_is_not() -> None:
    with pytest.raises(UnsupportedSceneError, match="no air drag of balls that leave the cloth"):
        simulate(flying((1.0, 0.5), (0.0, 0.0, 1.0), air_drag=0.004))
    grows = flying((1.0, 0.5), (0.5, 0.0), rolling_friction_quadratic=0.004)
    assert grows.physics.rolling_friction_quadratic == 0.004


def test_a_nose_is_lower_than_the_balls() -> None:
    with pytest.raises(SceneError, match="`cushion_height` must be less than the height of every"):
        flying((1.0, 0.5), cushion_height=0.08)
