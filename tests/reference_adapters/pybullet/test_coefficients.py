"""Each coefficient of a scene is the product of the factors of two bodies, as in Bullet."""

from __future__ import annotations

import pytest
from shots import R, ball, scene_of

from ghostball.reference_adapters.pybullet.coefficients import Coefficients

G, ROLLING, SLIDING, SPINNING = 9.81, 0.013, 0.21, 7.0
LAWS = {
    "motion": "sliding",
    "gravity": G,
    "rolling_friction": ROLLING,
    "sliding_friction": SLIDING,
    "spinning_friction_rate": SPINNING,
    "cushion": "frictional",
    "cushion_friction": 0.14,
    "cushion_restitution": 0.8,
}


@pytest.mark.parametrize("friction", [0.0, 0.06])
@pytest.mark.parametrize("restitution", [0.0, 0.9, 1.0])
def test_pairs_multiply_to_what_the_scene_says(restitution, friction):
    scene = scene_of(
        ball((0.0, 0.0)), ball((1.0, 0.0)),
        ball_restitution=restitution, ball_friction=friction, **LAWS,
    )  # fmt: skip
    one = Coefficients.of(scene, planar=False)
    assert one.ball_restitution**2 == pytest.approx(restitution, abs=1e-15)
    assert one.ball_restitution * one.cushion_restitution == pytest.approx(0.8)
    assert one.ball_friction**2 == pytest.approx(friction, abs=1e-12)
    assert one.ball_friction * one.cushion_friction == pytest.approx(0.14)
    assert one.ball_friction * one.table_friction == pytest.approx(SLIDING)


@pytest.mark.parametrize("friction", [0.0, 0.06])
def test_moments_slow_a_ball_that_rolls_and_one_that_spins_as_the_scene_says(friction):
    """Bullet's torque is a length times the table's friction times the weight."""
    cloth = {name: LAWS[name] for name in list(LAWS)[:5]}
    scene = scene_of(ball((0.0, 0.0)), ball((1.0, 0.0)), ball_friction=friction, **cloth)
    one = Coefficients.of(scene, planar=False)
    slowed = one.rolling_friction * one.table_friction * G / (1.4 * R)  # for a mass of 1
    assert slowed == pytest.approx(ROLLING * G)
    spin = one.spinning_friction * one.table_friction * G / (0.4 * R * R)
    assert spin == pytest.approx(SPINNING)
    assert not one.own_tables
    other = scene_of(ball((0.0, 0.0)), ball((1.0, 0.0), sliding_friction=0.3), **cloth)
    assert Coefficients.of(other, planar=False).own_tables


def test_balls_in_the_plane_have_no_friction():
    one = Coefficients.of(scene_of(ball((0.0, 0.0)), rolling_friction=0.5), planar=True)
    assert (one.ball_friction, one.cushion_friction, one.own_tables) == (0.0, 0.0, False)
    assert not one.rolling_friction.any()
