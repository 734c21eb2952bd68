"""Balls and the table: default values, and the spin of rolling balls."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
import pytest

from ghostball.model import (
    Ball,
    Physics,
    Scene,
    SceneError,
    Strike,
    Table,
    rolling_angular_velocity,
)
from ghostball.model.scene import stroke_of

SLIDES, CUE = Physics(motion="sliding"), Strike(speed=1.0, direction=0.0)


def test_z_defaults_to_the_radius_and_vertical_velocity_to_zero():
    given = Ball(id="cue", position=(0.5, 0.25), velocity=(1, 2), radius=0.03)
    assert given.position == (0.5, 0.25, 0.03)
    assert given.velocity == (1.0, 2.0, 0.0)


def test_cushions_keep_the_order_of_their_index_and_appear_once():
    assert Table(length=1, width=1, cushions=("top", "left")).cushions == ("left", "top")
    with pytest.raises(SceneError, match="`cushions` must name each cushion once"):
        Table(length=1, width=1, cushions=("top", "top"))
    with pytest.raises(SceneError, match=r"`cushions\[0\]` must be 'left'"):
        Table(length=1, width=1, cushions=("north",))


def test_rolling_means_that_the_lowest_point_of_the_ball_does_not_slip():
    velocity = np.array([[0.3, -1.7, 0.0], [2.0, 0.1, 0.0]])
    radius = np.array([0.028575, 0.05])
    omega = rolling_angular_velocity(velocity, radius)
    lever = np.stack([np.zeros(2), np.zeros(2), -radius], axis=1)
    slip = velocity + np.cross(omega, lever)
    assert np.all(np.abs(slip) < 4 * 2**-52)


class TestStrike:
    """A ball with a cue stroke, which determines its velocities."""

    FIELDS: ClassVar = {"id": "cue", "position": (0.5, 0.25)}
    STRIKE: ClassVar = {"speed": 2.0, "direction": 0.5, "offset_left": 0.2, "elevation": 0.3}

    def test_a_struck_ball_has_the_velocities_of_the_stroke_on_the_cloth(self):
        ball = Ball(**self.FIELDS, strike=self.STRIKE, mass=0.16, radius=0.03)
        stroke = stroke_of(Strike(**self.STRIKE), 0.03, 0.16)
        assert stroke.velocity[2] < 0.0
        assert ball.velocity == (*stroke.velocity[:2], 0.0)
        assert ball.angular_velocity == stroke.angular_velocity
        assert ball.speed == math.hypot(*stroke.velocity[:2])

    def test_what_was_typed_is_kept_and_no_more(self):
        ball = Ball(**self.FIELDS, strike=Strike(**self.STRIKE))
        fields = ball.model_dump()
        assert fields["strike"] == Strike(**self.STRIKE).model_dump()
        assert not {"velocity", "angular_velocity"} & set(fields)
        assert Ball(**fields) == Ball.model_validate(ball) == ball
        assert "strike" not in Ball(**self.FIELDS).model_dump()

    @pytest.mark.parametrize(
        ("field", "name", "value"),
        [
            ("velocity", "velocity", (1.0, 0.0, 0.0)),
            ("velocity", "velocity", (0.0, 0.0, 0.0)),
            ("angular_velocity", "angular velocity", (0.0, 0.0, 1.0)),
        ],
    )
    def test_a_strike_with_a_velocity_is_refused(self, field, name, value):
        fields = {**self.FIELDS, "strike": self.STRIKE, field: value}
        with pytest.raises(SceneError, match=f"both a strike and its own {name}, got"):
            Ball(**fields)
        # A copy, which isn't checked until it is part of a scene, is refused, too.
        copied = Ball(**self.FIELDS, strike=self.STRIKE).model_copy(update={field: value})
        with pytest.raises(SceneError, match=r"`balls\[0\]` must not have both a strike"):
            Scene(name="a", balls=[copied])

    def test_a_struck_ball_lies_on_the_cloth(self):
        with pytest.raises(SceneError, match=r"must lie on the cloth; got 0.1 m. Remove z"):
            Ball(id="a", position=(0.0, 0.0, 0.1), strike=self.STRIKE)
        assert Ball(id="a", position=(0.0, 0.0, 0.1), radius=0.1, strike=self.STRIKE).speed > 0.0

    def test_without_its_strike_it_has_the_velocities(self):
        ball = Ball(**self.FIELDS, strike=self.STRIKE)
        moving = ball.without_strike()
        assert moving.strike is None
        assert (moving.velocity, moving.angular_velocity) == (ball.velocity, ball.angular_velocity)
        assert Ball(**moving.model_dump()) == moving
        assert moving.without_strike() is moving


def test_a_part_is_checked_once_and_a_copy_with_other_fields_again():
    # Fails if parts are checked again in each scene, or if a changed copy counts as checked.
    still, struck = Ball(id="a", position=(0, 0)), Ball(id="b", position=(1, 0), strike=CUE)
    scene = Scene(name="two", balls=[still, struck], physics=SLIDES)
    assert scene.balls[0] is still
    assert scene.physics is SLIDES
    assert scene.balls[1] is not struck  # its velocities depend on the scene
    for copied in (still.model_copy(update={"radius": -1.0}), Ball.model_construct(id="c")):
        with pytest.raises(SceneError, match=r"balls\[0\]"):
            Scene(name="one", balls=[copied])
