"""The rules of how balls begin to move: their spin, what slows them, and whether a shot ends."""

from __future__ import annotations

import pytest
from refusals import refusal
from shots import R, ball, scene_of

from ghostball.model import SceneError, Table

SLIDE = {"motion": "sliding"}


def test_spin_that_does_not_roll_needs_sliding():
    spinning = ball((0, 0), (1.0, 0.0), angular_velocity=(0.0, 30.0, 0.0))
    message = refusal(spinning)
    assert "`balls[0].angular_velocity` must be that of rolling without slip" in message
    assert scene_of(spinning, motion="sliding").angular_velocities[0, 1] == 30.0
    rolling = ball((0, 0), (1.0, 0.0), angular_velocity=(0.0, 1.0 / R, 0.0))
    assert scene_of(rolling).balls[0].angular_velocity == (0.0, 1.0 / R, 0.0)


class TestDrag:
    """What slows by more the faster a ball is: too fast, and powers of it are no doubles."""

    @pytest.mark.parametrize("field", ["air_drag", "rolling_friction_quadratic"])
    @pytest.mark.parametrize("speed", [1e-20, 1.0, 1e6])
    def test_it_slows_within_what_can_be_computed(self, field, speed):
        moving = ball((0, 0), (speed, 0.0))
        message = refusal(moving, **{field: 1.1e10 / speed})
        assert f"`physics.{field}` times the speed of a ball must be at most 1e+10" in message
        assert f"the {speed:g} m/s of `balls[0]`" in message
        assert "Lower one of them" in message
        assert scene_of(moving, **{field: 0.9e10 / speed})

    def test_it_holds_a_fall_within_what_can_be_computed(self):
        flies = {"motion": "sliding", "airborne": True, "gravity": 10.0}
        message = refusal(ball((0, 0)), **flies, air_drag=1.1e5)
        assert "`physics.air_drag` times `physics.gravity` must be at most 1e+06" in message
        assert "got 110000 1/m times 10 m/s^2" in message
        assert scene_of(ball((0, 0)), **flies, air_drag=0.9e5)
        assert scene_of(ball((0, 0)), **flies | {"airborne": False}, air_drag=1.1e5)


class TestEnds:
    """`t_max` is asked for where a ball might move for ever: any may set any other moving."""

    @pytest.mark.parametrize("motion", ["rolling", "sliding"])
    def test_a_ball_without_rolling_friction_beside_one_that_moves(self, motion):
        balls = [ball((0, 0), rolling_friction=0.0), ball((1, 0), (1, 0))]
        message = refusal(*balls, motion=motion)
        assert "`t_max` must be given where a ball moves (`balls[1]`)" in message
        assert "while it rolls (`balls[0]`, `rolling_friction` = 0.0)" in message
        assert "Set `t_max` to a time in seconds" in message
        assert scene_of(*balls, motion=motion, t_max=1.0).t_max == 1.0

    def test_a_ball_s_own_friction_stands_for_the_scene_s(self):
        moving = ball((0, 0), (1, 0), rolling_friction=0.01)
        assert scene_of(moving, rolling_friction=0.0)
        assert "`rolling_friction` = 0.0" in refusal(moving, ball((1, 0)), rolling_friction=0.0)

    def test_without_sliding_friction_a_ball_that_is_hit_slides_for_ever(self):
        message = refusal(ball((0, 0), (1, 0)), ball((1, 0)), sliding_friction=0.0, **SLIDE)
        assert "while it slides (`balls[0]`, `sliding_friction` = 0.0)" in message
        assert scene_of(ball((0, 0), (1, 0)), sliding_friction=0.0)  # always rolls

    def test_spin_about_a_level_axis_moves_a_ball(self):
        turning = ball((0, 0), angular_velocity=(0, 5, 0))
        for field in ("rolling_friction", "sliding_friction"):
            message = refusal(turning, **{field: 0.0}, **SLIDE)
            assert "a ball moves (`balls[0]`)" in message
        assert scene_of(turning, **SLIDE)

    def test_spin_about_the_vertical_may_last_for_ever(self):
        # Nobody waits for it: it moves nothing.
        spinning = ball((0, 0), angular_velocity=(0, 0, 5))
        ice = {"rolling_friction": 0.0, "sliding_friction": 0.0, **SLIDE}
        assert scene_of(spinning, spinning_friction_rate=0.0, **ice).t_max is None

    @pytest.mark.parametrize(
        ("velocity", "spin"), [((1e10, 0), None), ((0, 0), (1e12, 0, 0)), ((1e10, 0), (0, 0, 0))]
    )
    @pytest.mark.parametrize(
        ("field", "verb"), [("rolling_friction", "roll"), ("sliding_friction", "slide")]
    )
    def test_longer_than_doubles_can_follow(self, field, verb, velocity, spin):
        balls = [ball((0, 0), velocity, angular_velocity=spin), ball((1, 0), **{field: 1e-42})]
        message = refusal(*balls, **SLIDE)
        assert f"would {verb} for more than 1e+50 s: `balls[1]` loses" in message
        assert "the speed of `balls[0]`" in message
        assert scene_of(*balls, **SLIDE, t_max=1.0)

    @pytest.mark.parametrize("speed", [1e8, 1e30])
    def test_more_impacts_than_anyone_waits_for(self, speed):
        table = Table(length=2.54, width=1.27)
        fast = ball((0.5, 0.5), (0.0, speed))
        message = refusal(ball((1.0, 1.0)), fast, table=table)
        assert "`t_max` must be given where balls would hit cushions more than 1e+12" in message
        assert f"`balls[1]` begins with {speed:g} m/s" in message
        for fewer in (
            {"t_max": 1.0},
            {"table": Table(length=2.54, width=1.27, cushions=("left", "right"))},
            {"preset": "pool"},
            {"cushion": "restitution", "cushion_restitution": 0.9},
            {"rolling_friction_quadratic": 1e-30},
        ):
            assert scene_of(ball((1.0, 1.0)), fast, **({"table": table} | fewer))
        assert scene_of(ball((0.5, 0.5), (0.0, 1e6)), table=table)
        # Lost are m mu g in each metre, wherever the energy went, on ways of at most 2.84 m.
        some = ball((0.5, 0.5), (0.0, 1.06e6), mass=1.0)
        assert "at least 1e+12" in refusal(some, table=table)
        assert scene_of(some, ball((1.0, 1.0), mass=2.0), table=table)

    def test_a_friction_that_rounds_to_nothing(self):
        # mu g rounds to 0: the engine would see no friction at all.
        for field in ("rolling_friction", "sliding_friction"):
            message = refusal(ball((0, 0), (1e-300, 0), **{field: 1e-300}), gravity=1e-50, **SLIDE)
            assert "never come to rest" in message

    def test_a_table_that_returns_all_needs_an_end(self):
        fields = {"motion": "sliding", "airborne": True, "table_restitution": 1.0}
        assert "`t_max` must be given where `table_restitution` is 1" in refusal(
            ball((0, 0), (0, 0, 1)), **fields
        )
        assert scene_of(ball((0, 0)), t_max=1.0, **fields).t_max == 1.0


class TestSpinMagnitude:
    @pytest.mark.parametrize("axis", range(3))
    def test_the_surface_of_a_ball_is_no_faster_than_a_ball_may_be(self, axis):
        spin = [0.0, 0.0, 0.0]
        spin[axis] = -2e30
        fast = ball((0, 0), radius=1e20, angular_velocity=tuple(spin))
        message = refusal(fast, motion="sliding", t_max=1.0)
        assert "`balls[0].angular_velocity` must turn the ball's surface at no more than" in message
        assert "1e+50 m/s" in message
        assert "2e+50 m/s" in message
        slower = fast | {"radius": 1e19}
        assert scene_of(slower, motion="sliding", t_max=1.0).rolls.tolist() == [axis == 2]

    def test_extremes_are_judged_without_a_warning(self):
        # Warnings are errors here: an overflow in a rule would fail this.
        most = ball((0, 0), (1e50, 0), radius=1e50, angular_velocity=(0.5, 0.5, 0.5))
        small = ball((1e30, 1e30), (0, -1e50), radius=1e-50, angular_velocity=(1e50, 0, 1e50))
        assert scene_of(most, motion="sliding", t_max=1e50).rolls.tolist() == [False]
        with pytest.raises(SceneError, match="known to better than the radius"):
            scene_of(small, motion="sliding", t_max=1.0)
        at_origin = small | {"position": (0, 0)}
        assert scene_of(at_origin, motion="sliding", t_max=1.0).rolls.tolist() == [False]
        ends = refusal(at_origin, motion="sliding", rolling_friction=1e-30)
        assert "would roll for more than 1e+50 s" in ends
