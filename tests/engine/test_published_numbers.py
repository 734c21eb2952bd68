"""Every published number that a shot on the cloth can show, from whole simulated shots.

Sources: [3.3], [A.14], [A.16], [B.6] are technical proofs of D. Alciatore
(billiards.colostate.edu/technical_proofs); [M14] is Mathavan, Jackson and Parkin (2014), Sports
Engineering 17; [WS] is Wallace and Schroeder (1988), American Journal of Physics 56, 815.

Three published results are of other models than this one. Squirt, 1.1993583313332898 degrees, is
what a cue does to a ball. The cradle of three Hertzian balls, -0.071, 0.076, 0.995, needs balls
that give way; rigid ones have 0, 0, 1. And an equation of state is a gas's.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from invariants import EPS, ball_impacts
from sampling import (
    direction,
    kinetic_energy,
    once_rolling,
    speed,
    state_at,
    state_before,
    times_of,
)
from shots import R, ball, scene_of

from engine import EventKind, Result, Scene, Status, Table, simulate

HIT, ROLLS = EventKind.BALL_BALL, EventKind.SLIDE_TO_ROLL
FOOT, INCH, MILE_PER_HOUR = 0.3048, 0.0254, 0.44704
STANDARD_GRAVITY = 9.80665
HALF_A_DIGIT = 0.5 + 1e-6
"""In units of the last printed digit."""

CLOTH = {"motion": "sliding", "rolling_friction": 0.01, "sliding_friction": 0.2}


def printed(value: float, published: float, digits: int) -> None:
    assert abs(value - published) <= HALF_A_DIGIT * 10.0**-digits, f"{value}, printed {published}"


def cut_shot(cut: float, *, v: float = 1.5, radius: float = R, **physics) -> Scene:
    """Return a cue ball rolling along +x onto a resting ball, the line of centres `cut` rad up."""
    return scene_of(
        ball((-0.3, 0.0), (v, 0.0), radius=radius),
        ball((2 * radius * math.cos(cut), 2 * radius * math.sin(cut)), radius=radius),
        **{**CLOTH, **physics},
    )


def impact_time(result: Result) -> float:
    """Return the instant of the first ball-ball impact [s]."""
    return times_of(result, HIT)[0]


def rolling_velocities(result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Return the velocities of both balls once each rolls after the hit, over the cue ball's."""
    t = impact_time(result)
    v = speed(state_before(result, t).velocities[0])
    return tuple(once_rolling(result, i, since=t)[1] / v for i in (0, 1))


def deflection(cut: float) -> float:
    """Return by how many degrees a rolling cue ball's course changes at this cut [rad]."""
    cue, _ = rolling_velocities(simulate(cut_shot(cut), record="events"))
    return abs(direction(cue))


class TestRollingCueBall:
    """[3.3], [A.16], [WS]: a rolling cue ball, a resting ball; no ball friction, no loss."""

    @pytest.mark.parametrize(
        ("offset", "published"), [(0.5, 33.670), (0.75, 27.267), (0.25, 27.626)]
    )
    def test_deflection_by_half_quarter_and_three_quarter_ball_hits(self, offset, published):
        printed(deflection(math.asin(offset)), published, 3)

    @pytest.mark.parametrize(
        ("cut", "published"),
        [
            (10, 21.681),
            (20, 31.868),
            (30, 33.670),
            (40, 31.196),
            (45, 29.055),
            (60, 20.633),
            (80, 7.116),
        ],
    )
    def test_the_thirty_degree_rule(self, cut, published):
        printed(deflection(math.radians(cut)), published, 3)

    def test_the_largest_deflection(self):
        # Where it is as large a little before as a little after; at the top itself it is flat.
        low, high, apart = math.radians(20), math.radians(40), 1e-4
        while high - low > 1e-9:
            cut = 0.5 * (low + high)
            rises = deflection(cut + apart) > deflection(cut - apart)
            low, high = (cut, high) if rises else (low, cut)
        printed(math.degrees(low), 28.126, 3)
        printed(deflection(low), 33.749, 3)

    def test_speeds_after_a_thirty_degree_cut(self):
        cue, struck = rolling_velocities(simulate(cut_shot(math.radians(30)), record="events"))
        printed(100 * speed(struck), 61.859, 3)
        printed(100 * speed(cue), 55.787, 3)

    def test_where_both_balls_are_equally_fast(self):
        low, high = math.radians(20), math.radians(50)  # the cue ball is slower, faster
        while high - low > 1e-6:
            cut = 0.5 * (low + high)
            cue, struck = rolling_velocities(simulate(cut_shot(cut), record="events"))
            low, high = (cut, high) if speed(cue) < speed(struck) else (low, cut)
        printed(math.degrees(low), 33.211, 3)

    @pytest.mark.parametrize("cut", [5, 30, 45, 70])
    @pytest.mark.parametrize("v", [0.5, 4.0])
    def test_final_speeds_and_one_instant_for_both_slides(self, cut, v):
        result = simulate(cut_shot(math.radians(cut), v=v), record="events")
        cue, struck = rolling_velocities(result)
        s, c = math.sin(math.radians(cut)), math.cos(math.radians(cut))
        assert speed(struck) == pytest.approx(5 / 7 * c, rel=1e-13)
        assert speed(cue) == pytest.approx(5 / 7 * math.sqrt(9 / 5 * s**2 + 4 / 25), rel=1e-13)
        t = impact_time(result)
        ends = [once_rolling(result, i, since=t)[0] for i in (0, 1)]
        assert ends[0] == pytest.approx(ends[1], rel=1e-13)


@pytest.mark.parametrize(
    ("mph", "feet"), [(1.5, 7.522), (3, 14.033), (7, 25.041), (12, 30.752), (20, 39.291)]
)
def test_how_far_a_ball_goes_up_and_down_a_nine_foot_table(mph, feet):
    """[B.6] 100 inches from cushion to cushion; each takes 0.3 of the speed, and all of the spin.

    No law of the engine takes all of the spin, so the shot is played leg by leg: the next one
    starts with 0.7 of the speed with which the last met the cushion, and slides.
    """
    leg = 100 * INCH
    v, spin, travelled = mph * MILE_PER_HOUR, {}, 0.0
    while True:
        scene = scene_of(
            ball((0.0, 0.5), (v, 0.0), **spin),
            table=Table(length=leg + R, width=1.0, cushions=("right",)),
            gravity=STANDARD_GRAVITY,
            **CLOTH,
        )
        result = simulate(scene, record="events")
        meets = times_of(result, EventKind.BALL_CUSHION)
        if not meets:
            break
        travelled += leg
        v = 0.7 * speed(state_before(result, meets[0]).velocities[0])
        spin = {"angular_velocity": (0.0, 0.0, 0.0)}
    printed((travelled + result.rest_positions[0, 0]) / FOOT, feet, 3)


@pytest.mark.parametrize(
    ("v", "cut", "cue_speed", "object_speed", "cue_angle", "object_angle", "digits"),
    [
        (1.539, 33.83, 0.914, 0.831, 31.93, 32.20, 3),
        (1.032, 26.36, 0.520, 0.599, 32.45, 25.07, 3),
        (1.364, 40.52, 0.917, 0.676, 29.91, 38.62, 3),
        (1.731, 46.50, 1.28, 0.780, 27.32, 44.38, 2),
        (0.942, 18.05, 0.383, 0.579, 29.47, 17.15, 3),
    ],
)
def test_frictional_impacts_on_the_cloth(
    v, cut, cue_speed, object_speed, cue_angle, object_angle, digits
):
    """[M14], tables 1 and 2: a rolling snooker ball onto a resting one, once both roll.

    The object ball's angle tells whether the lifted ball's vertical velocity counts in the slip
    during the impact, as in the paper: without, it is 0.02 degrees larger. What is printed of the
    cue ball differs from what ever smaller steps of the impulse converge to, by up to 0.0006 m/s
    and 0.016 degrees: as much as steps of 1/4000 of the impulse still change it.
    """
    scene = cut_shot(
        math.radians(cut),
        v=v,
        radius=0.02625,
        rolling_friction=0.0,  # so that the cue ball arrives with just that speed
        sliding_friction=0.21,
        ball_impact="mathavan2014",
        ball_restitution=0.89,
        ball_friction=0.05,
        t_max=2.0,
    )
    result = simulate(scene, record="events")
    cue, struck = (v * velocity for velocity in rolling_velocities(result))
    printed(speed(struck), object_speed, 3)
    printed(direction(struck), object_angle, 2)
    assert abs(speed(cue) - cue_speed) <= max(6e-4, HALF_A_DIGIT * 10.0**-digits)
    assert abs(-direction(cue) - cue_angle) <= 0.016


@pytest.mark.parametrize(("digits", "count"), [(1, 3), (2, 31), (3, 314)])
def test_galperin_counts_pi_on_a_cloth_without_friction_too(digits, count):
    scene = scene_of(
        ball((1.0, 0.5), mass=1.0),
        ball((2.0, 0.5), (-1.0, 0.0), mass=100.0 ** (digits - 1)),
        table=Table(length=9.0, width=1.0, cushions=("left",)),
        motion="sliding",
        rolling_friction=0.0,
        sliding_friction=0.0,
        t_max=1e9,
    )
    assert sum(simulate(scene).collision_counts.values()) == count


class TestThreeBallHit:
    """A cue ball into two touching balls, at 30 degrees to either side; over its own speed."""

    @staticmethod
    def velocities_after(**physics) -> np.ndarray:
        place = math.sqrt(3) * R
        scene = scene_of(
            ball((-0.25, 0.0), (1.0, 0.0)),
            ball((place, R)),
            ball((place, -R)),
            **{"rolling_friction": 0.0, "t_max": 1.0, **physics},
        )
        result = simulate(scene, record="events")
        return state_at(result, times_of(result, HIT)[1]).velocities[:, :2]

    @pytest.mark.parametrize("e", [1.0, 0.95, 0.5, 0.0])
    @pytest.mark.parametrize("motion", ["rolling", "sliding"])
    def test_simultaneous(self, e, motion):
        cue, *struck = self.velocities_after(ball_restitution=e, motion=motion)
        assert cue == pytest.approx([(2 - 3 * e) / 5, 0.0], abs=1e-13)
        for velocity, side in zip(struck, (1, -1), strict=True):
            each = math.sqrt(3) / 5 * (1 + e)
            along = [each * math.sqrt(3) / 2, side * each / 2]
            assert velocity == pytest.approx(along, abs=1e-13)

    @pytest.mark.parametrize("motion", ["rolling", "sliding"])
    def test_sequential(self, motion):
        cue, *struck = self.velocities_after(impacts="sequential", motion=motion)
        first, second = sorted(struck, key=speed, reverse=True)
        side = math.copysign(1.0, first[1])  # which of the two is hit first is not published
        r = math.sqrt(3) / 8
        assert cue == pytest.approx([-1 / 8, -side * r], abs=1e-13)
        assert first == pytest.approx([3 / 4, side * 2 * r], abs=1e-13)
        assert second == pytest.approx([3 / 8, -side * r], abs=1e-13)


class TestStunDrawAndFollow:
    @pytest.mark.parametrize("v", [0.1, 1.0, 7.0])
    @pytest.mark.parametrize("friction", [0.15, 0.2, 0.4])
    def test_a_stunned_ball_keeps_five_sevenths(self, v, friction):
        scene = scene_of(
            ball((0, 0), (v, 0.0), angular_velocity=(0.0, 0.0, 0.0)),
            **{**CLOTH, "sliding_friction": friction},
        )
        result = simulate(scene, record="events")
        t, velocity = once_rolling(result, 0)
        g = scene.physics.gravity
        assert t == pytest.approx(2 * v / (7 * friction * g), rel=1e-14)
        assert velocity == pytest.approx([5 / 7 * v, 0.0], rel=1e-14)
        place = state_at(result, t).positions[0, 0]
        assert place == pytest.approx(12 * v**2 / (49 * friction * g), rel=1e-14)

    @pytest.mark.parametrize("surface", [2.0, 1.0, 0.3, -0.7, -2.5])
    @pytest.mark.parametrize(("rolling", "sliding"), [(0.01, 0.2), (0.005, 0.4)])
    def test_how_far_a_full_hit_draws_or_follows(self, surface, rolling, sliding):
        # Touching: the cue ball hits with just the spin that it was given, and stops dead.
        scene = scene_of(
            ball((0.0, 0.0), (2.5, 0.0), angular_velocity=(0.0, surface / R, 0.0)),
            ball((2 * R, 0.0)),
            motion="sliding",
            rolling_friction=rolling,
            sliding_friction=sliding,
        )
        result = simulate(scene, record="events")
        assert times_of(result, HIT) == [0.0]
        travel = 2 * surface**2 / (49 * scene.physics.gravity) * (1 / sliding + 1 / rolling)
        assert result.rest_positions[0, 0] == pytest.approx(
            math.copysign(travel, surface), rel=1e-13
        )
        assert result.status is Status.REST


def alciatore(slip: float) -> float:
    """Ball-ball friction at this speed of slip [m/s], Alciatore's fit of Marlow's data."""
    return 9.951e-3 + 0.108 * math.exp(-1.088 * slip)


class TestThrow:
    @staticmethod
    def hit(cut: float, v: float, side: float) -> Result:
        """Play a stunned hit of touching balls, with the surface speed `side` from side spin."""
        scene = scene_of(
            ball((0.0, 0.0), (v, 0.0), angular_velocity=(0.0, 0.0, side / R)),
            ball((2 * R * math.cos(cut), 2 * R * math.sin(cut))),
            ball_friction="alciatore",
            **CLOTH,
        )
        return simulate(scene, record="events")

    @pytest.mark.parametrize("cut", [5, 20, 40, 60, 80])
    @pytest.mark.parametrize("v", [0.3, 1.0, 3.0])
    @pytest.mark.parametrize("side", [0.0, 0.4, -0.8])
    def test_throw_of_a_stunned_hit(self, cut, v, side):
        # [A.14] tan th = min(mu v cos / vrel, 1/7) (v sin - R wz) / (v cos)
        phi = math.radians(cut)
        result = self.hit(phi, v, side * v)
        velocity = state_at(result, impact_time(result)).velocities[1]
        slip = v * math.sin(phi) - side * v
        along = v * math.cos(phi)
        tangent = min(alciatore(abs(slip)) * along / abs(slip), 1 / 7) * slip / along
        thrown = phi - math.atan2(velocity[1], velocity[0])
        assert math.tan(thrown) == pytest.approx(tangent, rel=1e-10, abs=1e-13)

    @pytest.mark.parametrize("cut", [10, 30, 50])
    def test_gearing_spin_neither_throws_nor_turns_the_object_ball(self, cut):
        phi = math.radians(cut)
        result = self.hit(phi, 1.5, 1.5 * math.sin(phi))
        after = state_at(result, impact_time(result))
        assert direction(after.velocities[1]) == pytest.approx(cut, abs=1e-11)
        assert np.max(np.abs(R * after.angular_velocities[1])) <= 64 * EPS

    @pytest.mark.parametrize("e", [1.0, 0.9, 0.5])
    @pytest.mark.parametrize("friction", [0.0, 0.06, "alciatore", 5.0])
    @pytest.mark.parametrize("masses", [(0.17, 0.17), (0.2, 0.1)])
    @pytest.mark.parametrize("spin", [(0, 0, 0), (0, 0, 60), (-30, 20, -40), (10, 90, 5)])
    def test_what_an_impact_costs(self, e, friction, masses, spin):
        """The loss to restitution and to friction, and what would have lifted the balls.

        m_r (1 - e^2) v_n^2 / 2, and P U - (7/4) P^2 / m_r with P = min(mu J, (2/7) m_r U): that is
        m_r U^2 / 7 where it sticks. The cloth takes the vertical part of P, at P_z^2 / (2 m_r).
        """
        phi, v = math.radians(35), 1.2
        scene = scene_of(
            ball((0.0, 0.0), (v, 0.0), angular_velocity=spin, mass=masses[0]),
            ball((2 * R * math.cos(phi), 2 * R * math.sin(phi)), mass=masses[1]),
            **{**CLOTH, "ball_restitution": e, "ball_friction": friction},
        )
        result = simulate(scene, record="events")
        t, a, b = next(iter(ball_impacts(result)))
        assert (a, b) == (0, 1)
        before = kinetic_energy(scene, state_before(result, t)).sum()
        after = kinetic_energy(scene, state_at(result, t)).sum()
        reduced = masses[0] * masses[1] / sum(masses)
        approach = v * math.cos(phi)
        along = -v * math.sin(phi) + R * spin[2]
        up = R * (spin[0] * math.sin(phi) - spin[1] * math.cos(phi))
        slip = math.hypot(along, up)
        push = (1 + e) * reduced * approach
        mu = alciatore(slip) if friction == "alciatore" else friction
        rub = min(mu * push, 2 / 7 * reduced * slip)
        loss = reduced * (1 - e**2) * approach**2 / 2 + rub * slip - 7 / 4 * rub**2 / reduced
        loss += (rub * up / slip) ** 2 / (2 * reduced)
        assert before - after == pytest.approx(loss, rel=1e-10, abs=64 * EPS * before)
