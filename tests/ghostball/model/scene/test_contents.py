"""A scene's balls as arrays, and which balls roll at the start."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from shots import POOL_TABLE, R, ball, scene_of


def test_arrays_are_fresh_so_that_nobody_can_change_a_scene_through_them():
    scene = scene_of(ball((0.5, 0.25), (1, 0)))
    names = ["positions", "velocities", "angular_velocities", "radii", "masses"]
    names += ["rolling_frictions", "sliding_frictions", "spinning_friction_rates"]
    for name in names:
        array = getattr(scene, name)
        assert array.dtype == np.float64
        array[...] = -1.0
        assert not np.array_equal(getattr(scene, name), array)


def test_frictions_are_the_scene_s_unless_a_ball_has_its_own():
    # 0 is a friction, not a missing one.
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
        # With a radius of 1 nothing is rounded: the slip is exactly this number.
        spin = 1.0 + roundings * 2.0**-52
        assert self.rolls((1.0, 0.0), (0.0, spin, 0.0), radius=1.0) == [rolls]
        assert self.rolls((1.0, 0.0), (roundings * 2.0**-52, 1.0, 0.0), radius=1.0) == [rolls]


# --- a whole scene is frozen and can be pickled


def test_a_scene_is_frozen():
    scene = scene_of(ball((0, 0)))
    with pytest.raises(ValueError, match="frozen"):
        scene.name = "other"
    with pytest.raises(ValueError, match="frozen"):
        scene.balls[0].radius = 1.0


def test_a_scene_survives_pickling_to_a_worker():
    scene = scene_of(ball((0.5, 0.25), (1, 0)), table=POOL_TABLE)
    assert pickle.loads(pickle.dumps(scene)) == scene
