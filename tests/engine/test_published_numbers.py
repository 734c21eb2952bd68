"""Every published number that a shot on the cloth can show, from whole simulated shots.

Sources: [3.3], [A.16], [B.5], [B.6] are technical proofs of D. Alciatore
(billiards.colostate.edu/technical_proofs); [M14] is Mathavan, Jackson and Parkin (2014), Sports
Engineering 17; [WS] is Wallace and Schroeder (1988), American Journal of Physics 56, 815. What is
published without numbers is in `test_published_formulas`.

Published results that this model can't have:

- Squirt, 1.1993583313332898 degrees at a mass ratio of 20, is what a cue does to a ball. Here balls
  start with the velocity that they are given.
- The cradle of three Hertzian balls, -0.071, 0.076, 0.995, needs balls that give way, so that all
  three touch for a while. Rigid ones have 0, 0, 1: `TestCradle`.
- The hop of a cue ball that hits with ball friction, vz = mu (1 + e) v / 2 [B.5]: balls stay on the
  cloth.
- The equation of state of hard spheres (Carnahan and Starling): on a cloth balls are discs, whose
  own (Henderson) is in `ghostball stress gas`.

Nor does any law of the cushions take all of the spin, as [B.6] has it: see there.
"""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
import pytest
from invariants import EPS
from published_steps import TABLE_STEPS, stepped
from sampling import (
    direction,
    once_rolling,
    speed,
    state_at,
    state_before,
    times_of,
)
from shots import R, ball, scene_of

from ghostball.engine import EventKind, Result, Scene, Table, simulate

HIT = EventKind.BALL_BALL
FOOT, INCH, MILE_PER_HOUR = 0.3048, 0.0254, 0.44704
STANDARD_GRAVITY = 9.80665
HALF_A_DIGIT = 0.5 + 1e-6
"""In units of the last printed digit."""

CLOTH = {"motion": "sliding", "rolling_friction": 0.01, "sliding_friction": 0.2}


def printed(value: float, published: float, digits: int) -> None:
    assert abs(value - published) <= HALF_A_DIGIT * 10.0**-digits, f"{value}, printed {published}"


def as_printed(value: float, published: str) -> None:
    printed(value, float(published), len(published.partition(".")[2]))


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


class TestFrictionalImpactsOnTheCloth:
    """[M14], tables 1 and 2: a rolling snooker ball onto a resting one, once both roll.

    v [m/s], cut [degrees]; speeds of the cue ball and of the object ball, and by how much they are
    off the cue ball's old course [degrees], to as many digits as printed.

    The printed numbers are those of 5000 equal steps of the impulse, the last of which goes past
    the end of the rebound. That turns the cue ball by up to 0.012 degrees, and changes speeds by up
    to 2e-4 m/s; the object ball's direction stays. So all printed digits are required of those
    steps. Of the engine, the limit of ever smaller steps is required; and what is printed of the
    object ball, where step and limit print alike.
    """

    SHOTS = pytest.mark.parametrize(
        ("v", "cut", "cue_speed", "object_speed", "cue_angle", "object_angle"),
        [
            (1.539, 33.83, "0.914", "0.831", "31.93", "32.20"),
            (1.032, 26.36, "0.520", "0.599", "32.45", "25.07"),
            (1.364, 40.52, "0.917", "0.676", "29.91", "38.62"),
            (1.731, 46.50, "1.28", "0.780", "27.32", "44.38"),
            (0.942, 18.05, "0.383", "0.579", "29.47", "17.15"),
        ],
    )
    CONSTANTS: ClassVar = {"restitution": 0.89, "ball_friction": 0.05, "cloth_friction": 0.21}

    @SHOTS
    def test_the_published_steps_give_every_printed_digit(
        self, v, cut, cue_speed, object_speed, cue_angle, object_angle
    ):
        after = stepped(v, math.radians(cut), steps=TABLE_STEPS, lands=False, **self.CONSTANTS)
        as_printed(speed(after.cue), cue_speed)
        as_printed(speed(after.struck), object_speed)
        as_printed(direction(after.cue) - cut, cue_angle)
        as_printed(cut - direction(after.struck), object_angle)

    @SHOTS
    def test_whole_shots(self, v, cut, cue_speed, object_speed, cue_angle, object_angle):
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
        velocities = [v * w for w in rolling_velocities(simulate(scene, record="events"))]
        as_printed(speed(velocities[1]), object_speed)
        as_printed(direction(velocities[1]), object_angle)
        coarse, fine = (
            stepped(v, math.radians(cut), steps=steps, lands=True, **self.CONSTANTS)
            for steps in (1000, 2000)
        )
        for velocity, once, twice in zip(velocities, coarse, fine, strict=True):
            limit = [2 * b - a for a, b in zip(once, twice, strict=True)]
            assert speed(velocity) == pytest.approx(speed(limit), abs=1e-7)
            off = cut - direction(limit)  # the steps count from the line of centres
            assert direction(velocity) == pytest.approx(off, abs=1e-5)


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


class TestCradle:
    @pytest.mark.parametrize("motion", ["rolling", "sliding"])
    @pytest.mark.parametrize("impacts", ["simultaneous", "sequential"])
    def test_rigid_balls_hand_on_the_whole_velocity(self, motion, impacts):
        """Fails if the impacts of one instant share the velocity out, as joint ones would."""
        scene = scene_of(
            ball((-2 * R, 0.0), (1.0, 0.0)),
            ball((0.0, 0.0)),
            ball((2 * R, 0.0)),
            motion=motion,
            impacts=impacts,
            rolling_friction=0.0,
            t_max=1.0,
        )
        result = simulate(scene, record="events")
        after = state_at(result, times_of(result, HIT)[1]).velocities[:, 0]
        assert after == pytest.approx([0.0, 0.0, 1.0], abs=4 * EPS)
