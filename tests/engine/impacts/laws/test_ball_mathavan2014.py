"""Tests of the ball-ball impact on the cloth: published shots, and the friction of the cloth.

[M14] is Mathavan, Jackson and Parkin (2014), Sports Engineering 17, doi 10.1007/s12283-014-0158-y.
"""

from __future__ import annotations

import math

import pytest
from ball_impacts import (
    EPS,
    SNOOKER_BALL,
    after,
    energy,
    frictions,
    gained,
    impact_of,
    impacts,
    laws,
    restitutions,
    shot,
)
from hypothesis import given
from kernels import entry_to
from recorded import direction, speed
from shots import R

from ghostball.engine.impacts.laws.ball_frictional import frictional
from ghostball.engine.impacts.laws.ball_mathavan2014 import mathavan2014
from ghostball.engine.impacts.laws.friction_curve import alciatore_friction
from ghostball.engine.impacts.laws.interface import BallImpact

frictional, mathavan2014, alciatore_friction = map(
    entry_to, (frictional, mathavan2014, alciatore_friction)
)

# --- published shots ----------------------------------------------------------------------------

Plane = tuple[float, float]
RESTITUTION, BALL_FRICTION = 0.89, 0.05


def stepped(v: float, cut: float, steps: int, *, lands: bool) -> list[Plane]:
    """Return the result of [M14]'s steps for a rolling ball of speed v [m/s], `cut` [rad] off.

    The results are the velocities of both balls once they roll, along the line of centres and
    across it [m/s]. The steps are equal, `steps` of them up to the impulse of an impact without
    friction. As published, compression and restitution end with the first whole step beyond their
    end. With `lands`, they end exactly, and the remaining error is proportional to the step.

    Inside, velocities are (n, t, z), with n along the line of centres, and so are the surface
    speeds R w. The resting ball b is pressed onto the cloth throughout, because a's front moves
    down.
    """
    n, t = v * math.cos(cut), v * math.sin(cut)
    a, spin_a = [n, t, 0.0], [-t, n, 0.0]
    b, spin_b = [0.0, 0.0], [0.0, 0.0, 0.0]
    h = 0.5 * (1.0 + RESTITUTION) * n / steps
    work, wanted = 0.0, -math.inf  # the work that remains at the end, known after compression
    while True:
        along = a[1] - b[1] + spin_a[2] + spin_b[2]
        up = a[2] - spin_a[1] - spin_b[1]
        rub = BALL_FRICTION / math.hypot(along, up)
        along, up = rub * along, rub * up
        skid = (b[0] - spin_b[1], b[1] + spin_b[0])
        rubs = SNOOKER_BALL[2] * up / math.hypot(*skid) if skid != (0.0, 0.0) else 0.0
        cloth = [rubs * x for x in skid]
        falls = 2.0 + cloth[0]  # decrease of the approach speed, per impulse over the mass
        approach = a[0] - b[0]

        length, last = h, False
        if work + h * (approach - 0.5 * h * falls) <= wanted:
            length, last = _until(wanted - work, approach, falls) if lands else h, True
        elif lands and wanted < 0.0 and approach <= h * falls:
            length = approach / falls

        work += length * (approach - 0.5 * length * falls)
        a = [x - length * f for x, f in zip(a, (1.0, along, up), strict=True)]
        b = [x + length * f for x, f in zip(b, (1.0 + cloth[0], along + cloth[1]), strict=True)]
        spin_a[1] += 2.5 * length * up
        spin_a[2] -= 2.5 * length * along
        spin_b[0] += 2.5 * length * cloth[1]
        spin_b[1] += 2.5 * length * (up - cloth[0])
        spin_b[2] -= 2.5 * length * along
        if wanted < 0.0 and (a[0] <= b[0] or length < h):
            wanted = (1.0 - RESTITUTION**2) * work
        elif last:
            return [_rolling(a, spin_a), _rolling(b, spin_b)]


def _until(work: float, approach: float, falls: float) -> float:
    """Return the impulse after which `work` is done, while the balls separate."""
    return (approach + math.sqrt(approach**2 - 2.0 * falls * work)) / falls


def _rolling(velocity: list[float], spin: list[float]) -> Plane:
    """Return the velocity after the slide: 2/7 of the slip are lost."""
    slip = (velocity[0] - spin[1], velocity[1] + spin[0])
    return velocity[0] - 2.0 / 7.0 * slip[0], velocity[1] - 2.0 / 7.0 * slip[1]


def as_printed(value: float, published: str) -> None:
    """Assert that a value agrees with the printed number to its last digit."""
    unit = 10.0 ** -len(published.partition(".")[2])
    assert abs(value - float(published)) <= (0.5 + 1e-6) * unit, f"{value}, printed {published}"


@pytest.mark.parametrize(
    ("v", "cut", "cue_speed", "object_speed", "cue_angle", "object_angle"),
    [
        (1.539, 33.83, "0.914", "0.831", "31.93", "32.20"),
        (1.032, 26.36, "0.520", "0.599", "32.45", "25.07"),
        (1.364, 40.52, "0.917", "0.676", "29.91", "38.62"),
        (1.731, 46.50, "1.28", "0.780", "27.32", "44.38"),
        (0.942, 18.05, "0.383", "0.579", "29.47", "17.15"),
    ],
)
def test_a_rolling_ball_onto_a_resting_one_is_as_published(
    v, cut, cue_speed, object_speed, cue_angle, object_angle
):
    """[M14], tables 1 and 2: speeds, and angles from the cue ball's initial direction.

    The printed numbers are those of 5000 equal steps of the impulse, the last of which passes the
    end of the rebound. This turns the cue ball by up to 0.012 degrees and changes speeds by up to
    2e-4 m/s; the direction of the object ball is unaffected. Therefore the steps must agree with
    all printed digits, and the engine must agree with the limit of small steps. For the object
    ball, the engine must also agree with the printed digits if they are those of the limit.
    """
    line = math.radians(cut)
    cue, struck = stepped(v, line, 5000, lands=False)
    as_printed(speed(cue), cue_speed)
    as_printed(speed(struck), object_speed)
    as_printed(direction(cue) - cut, cue_angle)
    as_printed(cut - direction(struck), object_angle)
    radius = SNOOKER_BALL[0]
    i = impact_of(shot(line, v, 1.0, radius=radius), ball_a=SNOOKER_BALL, ball_b=SNOOKER_BALL)
    balls = [m.rolling(radius) for m in after(i, mathavan2014(i, laws(RESTITUTION, BALL_FRICTION)))]
    as_printed(speed(balls[1]), object_speed)
    as_printed(cut - direction(balls[1]), object_angle)
    coarse, fine = (stepped(v, line, steps, lands=True) for steps in (1000, 2000))
    for velocity, once, twice in zip(balls, coarse, fine, strict=True):
        limit = [2.0 * b - a for a, b in zip(once, twice, strict=True)]
        assert velocity == pytest.approx(limit, abs=1e-7)


# --- the cloth's part ---------------------------------------------------------------------------


def test_follow_pushes_down_the_object_ball_and_draw_the_cue_ball():
    """The cloth then acts against the slip of the ball pressed down, and not on the other ball."""
    follow = mathavan2014(impact_of(shot(0.0, 1.0, 1.0)), laws(0.95, 0.06))
    assert follow.up < 0.0
    assert follow.b_cloth_n < 0.0  # the ball slips forward as soon as it is hit
    assert (follow.a_cloth_n, follow.a_cloth_t) == (0.0, 0.0)
    draw = mathavan2014(impact_of(shot(0.0, 1.0, -1.0)), laws(0.95, 0.06))
    assert draw.up > 0.0
    assert draw.a_cloth_n < 0.0
    assert (draw.b_cloth_n, draw.b_cloth_t) == (0.0, 0.0)


def test_the_cloth_does_not_take_part_without_vertical_slip():
    i = impact_of((1.0, 0.4, 5.0, 0.0, 3.0), (0.0, 0.2, -3.0, 0.0, 1.0))
    assert mathavan2014(i, laws(0.9, 0.06)) == frictional(i, laws(0.9, 0.06))


@pytest.mark.parametrize("vt", [0.2, 0.4, 0.7])
@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_without_the_cloth_s_friction_the_normal_impulse_is_that_of_restitution(vt, e):
    smooth = (R, 0.17, 0.0)
    i = impact_of(shot(vt, 1.0, 1.0), ball_a=smooth, ball_b=smooth)
    p = mathavan2014(i, laws(e, 0.06))
    assert p.normal == pytest.approx((1.0 + e) * i.a.vn, rel=4.0 * EPS)
    # The law computes the cloth's impulse as a difference of two sums of up to 60 terms, each
    # rounded by up to EPS / 2: a standard deviation of 4 EPS at most, twice which is allowed.
    assert p[3:] == pytest.approx((0.0, 0.0, 0.0, 0.0), abs=8.0 * EPS)


def test_a_speed_dependent_coefficient_is_that_of_the_slip_before():
    i = impact_of(shot(0.4, 1.0, 1.0))
    slip = math.hypot(i.a.vt, R * i.a.wt)
    constant = mathavan2014(i, laws(0.95, alciatore_friction(slip)))
    assert mathavan2014(i, laws(0.95, "alciatore")) == pytest.approx(constant, rel=1e-12)


@pytest.mark.parametrize("approach", [10.0**-k for k in range(18)])
def test_an_approach_far_slower_than_the_spin_is_resolved(approach):
    """Slips that are a billion times the approach speed are only known to their rounding."""
    i = impact_of((approach, 0.3, -4.0, 7.0, 131.0), (0.0, 0.3, -4.0, 6.0, 0.0))
    p = mathavan2014(i, laws(0.4, 0.06))
    assert 1.3 * approach <= p.normal <= 1.5 * approach
    assert math.hypot(p.along, p.up) <= 0.06 * p.normal + 1e-14
    assert gained(i, p) <= 8.0 * EPS * energy(i, i.a[:5], i.b[:5])


@given(i=impacts, e=restitutions, mu=frictions)
def test_the_cloth_rubs_one_ball_no_more_than_its_load_permits(i: BallImpact, e: float, mu):
    """The total is bounded by the coefficient times the vertical impulse on that ball."""
    p = mathavan2014(i, laws(e, mu))
    rounding = 1e-7 * (i.a.vn - i.b.vn) + 8.0 * EPS * (abs(p.up) + R * (abs(i.a.wt) + abs(i.b.wt)))
    on_a, on_b = math.hypot(p.a_cloth_n, p.a_cloth_t), math.hypot(p.b_cloth_n, p.b_cloth_t)
    share_b = i.a.mass / (i.a.mass + i.b.mass)
    assert on_a <= i.a.cloth * (1.0 - share_b) * max(p.up, 0.0) + rounding
    assert on_b <= i.b.cloth * share_b * max(-p.up, 0.0) + rounding
