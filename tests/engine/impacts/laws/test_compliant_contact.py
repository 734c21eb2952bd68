"""Tests of a cushion that yields along the slip, against its two springs in small steps.

They fail for a wrong stiffness, a slip that never reverses, sticking that begins or ends at a wrong
time, a restitution that acts along the slip, or a gain of energy.
"""

import math

import numpy as np
import pytest
from cushion_impacts import R, cushion_of, energy, impact_of, rolling
from hypothesis import given, settings, strategies as st
from kernels import entry_to

from ghostball.engine.impacts.laws.compliant_contact import (
    arcsine,
    compliant_share,
    cosine_and_sine,
)
from ghostball.engine.impacts.laws.cushion_han2005 import han2005
from ghostball.model import Ball, Physics, Scene, SceneError, Table

share, cosine_and_sine, arcsine, nose = map(
    entry_to, (compliant_share, cosine_and_sine, arcsine, han2005)
)

STEPS = 100_000


def by_steps(slip, friction, e, ratio, steps=STEPS):
    """Return the impulse along the surface over mass and slip, from the springs in small steps.

    The point of contact has no mass. In each step it follows the ball, or slips so far that the
    spring pulls no more strongly than friction.
    """
    flexibility = 3.5 / ratio**2
    speed, deflection = slip, 0.0
    compression = np.linspace(0.0, 0.5 * math.pi, steps + 1)
    phases = np.concatenate([compression, np.linspace(0.5 * math.pi, math.pi, steps + 1)])
    lasts = np.concatenate([np.full(steps, 1.0), np.full(steps, e)]) * (0.5 * math.pi / steps)
    middles = np.concatenate(
        [0.5 * (p[1:] + p[:-1]) for p in (phases[: steps + 1], phases[steps + 1 :])]
    )
    limits = friction * flexibility * np.sin(middles)
    for most, step in zip(limits.tolist(), lasts.tolist(), strict=True):
        deflection = max(-most, min(most, deflection + speed * step))
        speed -= step * 3.5 * deflection / flexibility
    return (slip - speed) / (3.5 * slip)


@pytest.mark.parametrize("e", [0.0, 0.4, 0.85, 1.0])
@pytest.mark.parametrize("ratio", [1.1, 1.76, 1.95])
@pytest.mark.parametrize("relative", [0.3, 1.5, 3.0, 4.5, 6.0, 9.0])
def test_the_impulse_is_that_of_two_springs_in_small_steps(e, ratio, relative):
    friction = 0.2
    slip = relative * friction
    expected = by_steps(slip, friction, e, ratio)
    assert share(slip, friction, e, ratio) == pytest.approx(expected, abs=2e-5)


def test_friction_without_limit_is_a_harmonic_spring_until_the_end():
    # Elastic, with a ratio of 1.5: the ball leaves after 1.5 half turns of the second spring, when
    # its speed would be 0. The friction vanishes with the normal force, so the ball slips just
    # before.
    assert share(1.0, 1e9, 1.0, 1.5) == pytest.approx(2 / 7, abs=1e-4)
    # With a ratio near 1, the whole slip is reversed.
    assert share(1.0, 1e9, 1.0, 1.0 + 1e-9) == pytest.approx(4 / 7, abs=1e-6)


def test_much_slip_ends_as_with_a_rigid_contact():
    for slip in (3.0, 30.0, 1e6):
        assert share(slip, 0.14, 0.9, 1.76) == 0.14 * 1.9 / slip


@settings(max_examples=300)
@given(
    st.floats(0.0, 30.0),
    st.one_of(st.just(0.0), st.floats(1e-3, 3.0)),
    st.floats(0.0, 1.0),
    st.floats(1.001, 1.999),
)
def test_the_part_is_bounded_and_a_little_more_slip_changes_it_little(slip, friction, e, ratio):
    part = share(slip, friction, e, ratio)
    assert 0.0 <= part <= 4.0 / 7.0
    assert part * slip <= friction * (1.0 + e) * (1.0 + 1e-15)
    near = share(slip + 1e-9, friction, e, ratio)
    assert abs((slip + 1e-9) * near - slip * part) < 1e-8


def test_a_yielding_cushion_reverses_the_slip_that_a_rigid_cushion_ends():
    """Much friction: a rigid cushion ends the slip, and one that yields reverses it."""
    cushion, impact = cushion_of(e=0.85, friction=0.6, height=R), impact_of(1.0, 1.2)
    rigid, soft = (nose(impact, cushion._replace(ratio=ratio)) for ratio in (0.0, 1.76))
    assert soft.vn == rigid.vn == -0.85
    assert rigid.vt + R * rigid.wz == pytest.approx(0.0, abs=1e-15)
    assert -0.5 < soft.vt + R * soft.wz < -0.4
    assert energy(soft) < energy(impact)


def test_a_ball_without_slip_or_friction_only_bounces():
    for impact, friction in ((impact_of(1.0), 0.2), (rolling(1.0, 0.5), 0.0)):
        after = nose(impact, cushion_of(e=0.8, friction=friction, height=R, ratio=1.8))
        assert after == (*impact._replace(vn=-0.8)[:5], 0.0)


@pytest.mark.parametrize("angle", np.linspace(0.0, 4.0, 41).tolist())
def test_cosines_and_sines(angle):
    cosine, sine = cosine_and_sine(angle)
    assert abs(cosine - math.cos(angle)) < 1e-14
    assert abs(sine - math.sin(angle)) < 1e-14


@pytest.mark.parametrize("sine", [0.0, 1e-300, 1e-8, 0.3, 0.9, 1.0 - 1e-9, 1.0])
def test_arcsines(sine):
    assert arcsine(sine) == pytest.approx(math.asin(sine), rel=1e-14, abs=0.0)


@pytest.mark.parametrize("ratio", [1.0, 2.0, 0.5, -1.0, math.nan])
def test_a_ratio_outside_of_1_and_2_is_refused(ratio):
    with pytest.raises(ValueError, match="cushion_frequency_ratio"):
        Physics(motion="sliding", cushion="stronge2000", cushion_frequency_ratio=ratio)


def test_the_ratio_is_refused_with_another_law_and_stored_with_this_one():
    with pytest.raises(ValueError, match="has no effect with `cushion`"):
        Physics(motion="sliding", cushion="han2005", cushion_frequency_ratio=1.5)
    assert "cushion_frequency_ratio" not in Physics().model_dump()
    physics = Physics(motion="sliding", cushion="stronge2000")
    assert physics.model_dump()["cushion_frequency_ratio"] == 1.8


def test_a_rolling_scene_refuses_the_law():
    with pytest.raises(SceneError, match='`motion` must be "sliding" with `cushion` = "stronge'):
        Scene(
            name="a",
            table=Table(length=2, width=1),
            balls=(Ball(id="a", position=(0.5, 0.5)),),
            physics=Physics(cushion="stronge2000"),
        )
