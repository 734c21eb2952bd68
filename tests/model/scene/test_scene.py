"""The rules of a scene: each refuses what breaks it, and says which ball, value and rule."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest
from refusals import refusal
from shots import POOL_TABLE, R, ball, rack, scene_of

from ghostball.model import CUSHIONS, Ball, Physics, SceneError, Table, rolling_angular_velocity


def test_z_defaults_to_the_radius_and_vertical_velocity_to_zero():
    given = Ball(id="cue", position=(0.5, 0.25), velocity=(1, 2), radius=0.03)
    assert given.position == (0.5, 0.25, 0.03)
    assert given.velocity == (1.0, 2.0, 0.0)


def test_a_scene_is_frozen():
    scene = scene_of(ball((0, 0)))
    with pytest.raises(ValueError, match="frozen"):
        scene.name = "other"
    with pytest.raises(ValueError, match="frozen"):
        scene.balls[0].radius = 1.0


def test_arrays_are_fresh_so_that_nobody_can_change_a_scene_through_them():
    scene = scene_of(ball((0.5, 0.25), (1, 0)))
    names = ["positions", "velocities", "angular_velocities", "radii", "masses"]
    names += ["rolling_frictions", "sliding_frictions", "spinning_friction_rates"]
    for name in names:
        array = getattr(scene, name)
        assert array.dtype == np.float64
        array[...] = -1.0
        assert not np.array_equal(getattr(scene, name), array)


def test_a_scene_survives_pickling_to_a_worker():
    scene = scene_of(ball((0.5, 0.25), (1, 0)), table=POOL_TABLE)
    assert pickle.loads(pickle.dumps(scene)) == scene


def test_rolling_means_that_the_lowest_point_of_the_ball_does_not_slip():
    velocity = np.array([[0.3, -1.7, 0.0], [2.0, 0.1, 0.0]])
    radius = np.array([0.028575, 0.05])
    omega = rolling_angular_velocity(velocity, radius)
    lever = np.stack([np.zeros(2), np.zeros(2), -radius], axis=1)
    slip = velocity + np.cross(omega, lever)
    assert np.all(np.abs(slip) < 4 * 2**-52)


def test_frictions_are_the_scene_s_unless_a_ball_has_its_own():
    # 0 is a friction of its own, not a missing one.
    scene = scene_of(
        ball((0, 0)),
        ball((1, 0), rolling_friction=0.0, sliding_friction=0.0, spinning_friction_rate=0.0),
        ball((2, 0), rolling_friction=0.5, sliding_friction=0.25, spinning_friction_rate=2.0),
        rolling_friction=0.03,
        sliding_friction=0.3,
        spinning_friction_rate=3.0,
    )
    assert scene.rolling_frictions.tolist() == [0.03, 0.0, 0.5]
    assert scene.sliding_frictions.tolist() == [0.3, 0.0, 0.25]
    assert scene.spinning_friction_rates.tolist() == [3.0, 0.0, 2.0]


class TestRolls:
    def rolls(self, velocity, angular_velocity, radius=R, motion="sliding"):
        spinning = ball((0, 0), velocity, radius=radius, angular_velocity=angular_velocity)
        rolls = scene_of(spinning, motion=motion).rolls
        assert rolls.dtype == np.bool_
        return rolls.tolist()

    @pytest.mark.parametrize("velocity", [(0.0, 0.0), (1.0, -2.0), (1e-300, 0.0), (1e9, 1.0)])
    def test_a_ball_rolls_where_no_spin_is_given(self, velocity):
        assert self.rolls(velocity, None) == [True]

    def test_a_ball_rolls_also_where_its_v_over_r_rounds_to_nothing(self):
        assert self.rolls((1e-300, 0.0), None, radius=1e30) == [True]
        assert self.rolls((1e-300, 0.0), (0, 0, 0), radius=1e30) == [False]

    def test_spin_about_the_vertical_does_not_make_a_ball_slide(self):
        assert self.rolls((1, 0.5), (-0.5 / R, 1 / R, 1e6)) == [True]

    def test_stun_draw_side_roll_and_spin_in_place_slide(self):
        assert self.rolls((1, 0), (0, 0, 0)) == [False]
        assert self.rolls((1, 0), (0, -1 / R, 0)) == [False]
        assert self.rolls((1, 0), (1e-9, 1 / R, 0)) == [False]
        assert self.rolls((0, 0), (1e-300, 0, 0)) == [False]

    @pytest.mark.parametrize("seed", range(20))
    def test_a_spin_that_was_computed_as_v_over_r_rolls(self, seed):
        chance = np.random.default_rng(seed)
        vx, vy, radius = (float(x) for x in np.exp(chance.uniform(-12.0, 12.0, 3)))
        assert self.rolls((vx, -vy), (vy / radius, vx / radius, 0), radius) == [True]
        assert self.rolls((vx, -vy), (vy * (1 / radius), vx * (1 / radius), 0), radius) == [True]

    @pytest.mark.parametrize(("roundings", "rolls"), [(3, True), (6, False)])
    def test_slip_beyond_rounding_counts(self, roundings, rolls):
        # Of a unit radius nothing is rounded: the slip is exactly what is put here.
        spin = 1.0 + roundings * 2.0**-52
        assert self.rolls((1.0, 0.0), (0.0, spin, 0.0), radius=1.0) == [rolls]
        assert self.rolls((1.0, 0.0), (roundings * 2.0**-52, 1.0, 0.0), radius=1.0) == [rolls]


class TestBallsTogether:
    def test_two_balls_of_one_name(self):
        message = refusal(ball((0, 0), id="cue"), ball((1, 0)), ball((2, 0), id="cue"))
        assert '`balls[2].id` must be unique, but `balls[0]` is called "cue" too' in message

    def test_overlap_names_both_balls_and_the_depth(self):
        message = refusal(ball((0, 0), id="cue"), ball((1, 0)), ball((0.05, 0), id="eight"))
        assert '`balls[0]` ("cue") and `balls[2]` ("eight")' in message
        assert f"{2 * R - 0.05:.6g} m" in message
        assert "Move one" in message

    def test_the_reach_of_unequal_balls_is_the_sum_of_their_radii_in_the_plane(self):
        # In space the centres are farther apart than in the plane, as their heights differ.
        scene_of(ball((0, 0), radius=0.25), ball((0.75, 0), radius=0.5))
        assert "overlap" in refusal(ball((0, 0), radius=0.25), ball((0.74, 0), radius=0.5))

    @pytest.mark.parametrize("apex", [(0.0, 0.0), (1.905, 0.635), (17.3, -4.1)])
    def test_a_touching_rack_computed_from_sqrt_3_is_accepted(self, apex):
        assert len(scene_of(*rack(15, apex, gap=0.0)).balls) == 15

    def test_the_worst_overlap_of_a_ball_is_the_one_reported(self):
        message = refusal(ball((0, 0)), ball((0.1, 0)), ball((0.06, 0)))
        assert "`balls[1]`" in message
        assert "`balls[2]`" in message


class TestTable:
    @pytest.mark.parametrize(
        ("cushion", "place"),
        [
            ("left", (0.02, 0.6)),
            ("right", (2.53, 0.6)),
            ("bottom", (1.0, 0.0)),
            ("top", (1.0, 1.3)),
            # By hardly more than rounding, and by far.
            ("left", (R - 1e-9, 0.6)),
            ("right", (2.54 - R + 1e-9, 0.6)),
            ("bottom", (1.0, R - 1e-9)),
            ("top", (1.0, 1.27 - R + 1e-9)),
            ("right", (1e6, 0.6)),
            ("bottom", (1.0, -1e6)),
        ],
    )
    def test_a_ball_outside_the_table(self, cushion, place):
        message = refusal(ball((1, 0.3)), ball(place, id="lost"), table=POOL_TABLE)
        assert "`balls[1].position` must be inside the table" in message
        assert '"lost"' in message
        assert f"beyond the {cushion} cushion" in message

    @pytest.mark.parametrize("name", CUSHIONS)
    def test_a_side_without_a_cushion_is_open(self, name):
        places = {"left": (-9, 1), "right": (9, 1), "bottom": (1, -9), "top": (1, 9)}
        others = tuple(other for other in CUSHIONS if other != name)
        table = Table(length=2, width=2, cushions=others)
        assert scene_of(ball(places[name]), table=table).table == table

    def test_cushions_keep_the_order_of_their_index_and_appear_once(self):
        assert Table(length=1, width=1, cushions=("top", "left")).cushions == ("left", "top")
        with pytest.raises(SceneError, match="`cushions` must name each cushion once"):
            Table(length=1, width=1, cushions=("top", "top"))
        with pytest.raises(SceneError, match=r"`cushions\[0\]` must be 'left'"):
            Table(length=1, width=1, cushions=("north",))


class TestPhysics:
    def test_the_paper_preset_is_the_paper(self):
        physics = Physics(preset="paper")
        assert physics == Physics()
        assert (physics.motion, physics.rolling_friction) == ("rolling", 0.02)
        assert (physics.ball_restitution, physics.cushion) == (1.0, "mirror")

    def test_a_field_overrides_its_preset(self):
        physics = Physics(preset="pool", rolling_friction=0.005)
        assert physics.rolling_friction == 0.005
        assert physics.ball_restitution == 0.95

    @pytest.mark.parametrize("value", ["sometimes", -0.1, math.nan])
    def test_ball_friction_is_a_number_or_a_law(self, value):
        with pytest.raises(SceneError, match=r"`ball_friction` must be .*, or must be 'alciatore'"):
            Physics(ball_friction=value)

    def test_endless_motion_needs_t_max(self):
        message = refusal(ball((0, 0)), ball((1, 0), (1, 0)), rolling_friction=0.0)
        assert "`t_max` must be given" in message
        assert "`balls[1]`" in message
        assert scene_of(ball((0, 0), (1, 0)), rolling_friction=0.0, t_max=1.0).t_max == 1.0
        assert scene_of(ball((0, 0)), rolling_friction=0.0).t_max is None

    def test_a_ball_in_the_air_needs_airborne(self):
        assert "z must be the radius" in refusal(ball((0, 0, 0.1)))
        assert "z must be 0, got 1.0 m/s" in refusal(ball((0, 0), (0, 0, 1)))
        flies = scene_of(ball((0, 0, 0.1), (0, 0, 1)), motion="sliding", airborne=True)
        assert flies.balls[0].position[2] == 0.1

    def test_no_ball_is_inside_the_table_or_begins_into_it(self):
        inside = {"motion": "sliding", "airborne": True}
        assert "z must be at least the radius" in refusal(ball((0, 0, 0.9 * R)), **inside)
        assert "z must be at least 0 of a ball that lies" in refusal(
            ball((0, 0), (0, 0, -1e-9)), **inside
        )
        assert scene_of(ball((0, 0, 1.1 * R), (0, 0, -1)), **inside).balls[0].velocity[2] == -1.0

    def test_a_ball_above_a_cushion_may_be_nearer_to_it(self):
        fields = {"motion": "sliding", "airborne": True, "table": POOL_TABLE}
        on_nose = 0.0357 + R
        scene_of(ball((1e-3, 0.5, on_nose)), **fields)
        assert "beyond the left cushion" in refusal(ball((1e-3, 0.5, 0.99 * on_nose)), **fields)
        assert "beyond the left cushion" in refusal(ball((-1e-3, 0.5, 2 * on_nose)), **fields)
        # On the cloth, at sqrt(h (2 R - h)): a little less than its radius.
        scene_of(ball((0.97 * R, 0.5)), **fields)
        assert "so far at this height" in refusal(ball((0.96 * R, 0.5)), **fields)

    def test_a_table_that_returns_all_needs_an_end(self):
        fields = {"motion": "sliding", "airborne": True, "table_restitution": 1.0}
        assert "`t_max` must be given where `table_restitution` is 1" in refusal(
            ball((0, 0), (0, 0, 1)), **fields
        )
        assert scene_of(ball((0, 0)), t_max=1.0, **fields).t_max == 1.0

    def test_balls_above_each_other_do_not_overlap_in_the_air(self):
        scene_of(ball((0, 0)), ball((0, 0, 3.5 * R)), motion="sliding", airborne=True)
        fields = {"motion": "sliding", "airborne": True}
        assert "overlap" in refusal(ball((0, 0)), ball((0, 0, 2.5 * R)), **fields)

    def test_spin_that_does_not_roll_needs_sliding(self):
        spinning = ball((0, 0), (1.0, 0.0), angular_velocity=(0.0, 30.0, 0.0))
        message = refusal(spinning)
        assert "`balls[0].angular_velocity` must be that of rolling without slip" in message
        assert scene_of(spinning, motion="sliding").angular_velocities[0, 1] == 30.0
        rolling = ball((0, 0), (1.0, 0.0), angular_velocity=(0.0, 1.0 / R, 0.0))
        assert scene_of(rolling).balls[0].angular_velocity == (0.0, 1.0 / R, 0.0)


class TestMagnitudes:
    """Beyond 1e50 the engine's products would turn infinite without a word: refused here."""

    @pytest.mark.parametrize("place", [(1e14, 0), (0, -1e14)])
    def test_a_place_where_rounding_is_larger_than_a_ball(self, place):
        # Two balls in one place would pass for touching there.
        message = refusal(ball((0, 0)), ball(place))
        assert "`balls[1].position` must be known to better than the radius, 0.028575 m" in message
        assert "rounds by up to 0.36 m" in message
        assert "must not overlap" in refusal(ball((1e12, 0)), ball((1e12, 0)))
