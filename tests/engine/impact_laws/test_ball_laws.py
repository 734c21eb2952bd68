"""The laws of ball-ball impacts: closed forms, published numbers, a naive oracle, properties.

What a law returns is judged by what it does to the balls, as `BallImpulse` says it acts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st
from shots import R, ball, scene_of

from engine._state import Laws, laws_of
from engine.impact_laws.ball_frictional import frictional
from engine.impact_laws.ball_mathavan2014 import HIGHEST_CLOTH, HIGHEST_FRICTION, mathavan2014
from engine.impact_laws.friction_curve import alciatore_friction
from engine.impact_laws.interface import BallImpact, BallImpulse

EPS = 2.0**-52
POOL_BALL = (R, 0.17, 0.2)
SNOOKER_BALL = (0.02625, 0.1406, 0.21)
REST = (0.0, 0.0, 0.0, 0.0, 0.0)

Law = Callable[[BallImpact, Laws], BallImpulse]
both_laws = pytest.mark.parametrize("law", [frictional, mathavan2014])


def laws(restitution: float, friction: float | str) -> Laws:
    scene = scene_of(
        ball((0.0, 0.0)),
        motion="sliding",
        ball_restitution=restitution,
        ball_friction=friction,
    )
    return laws_of(scene)


def impact_of(
    a: Sequence[float],
    b: Sequence[float] = REST,
    ball_a: Sequence[float] = POOL_BALL,
    ball_b: Sequence[float] = POOL_BALL,
) -> BallImpact:
    """Return the impact of motions (vn, vt, wn, wt, wz) and balls (radius, mass, cloth)."""
    return BallImpact(*map(float, (*a, *ball_a, *b, *ball_b)))


def shot(cut: float, speed: float, roll: float = 0.0, side: float = 0.0, radius: float = R):
    """Return a's motion, `cut` off the line of centres; roll 1 rolls; side is R wz over speed."""
    n, t = speed * math.cos(cut), speed * math.sin(cut)
    return (n, t, -roll * t / radius, roll * n / radius, side * speed / radius)


class Motion(NamedTuple):
    vn: float
    vt: float
    wn: float
    wt: float
    wz: float

    def rolling(self, radius: float) -> tuple[float, float]:
        """Return the velocity that is left when the ball has stopped sliding."""
        slip_n, slip_t = self.vn - radius * self.wt, self.vt + radius * self.wn
        return self.vn - 2.0 / 7.0 * slip_n, self.vt - 2.0 / 7.0 * slip_t


def after(i: BallImpact, p: BallImpulse) -> tuple[Motion, Motion]:
    """Return both motions after: impulses on spheres, at the contact and at the lowest point."""
    to_a = i.b_mass / (i.a_mass + i.b_mass)
    to_b = i.a_mass / (i.a_mass + i.b_mass)
    turn_a, turn_b = 2.5 / i.a_radius, 2.5 / i.b_radius
    a = Motion(
        i.a_vn - to_a * p.normal + p.a_cloth_n,
        i.a_vt - to_a * p.along + p.a_cloth_t,
        i.a_wn + turn_a * p.a_cloth_t,
        i.a_wt + turn_a * (to_a * p.up - p.a_cloth_n),
        i.a_wz - turn_a * to_a * p.along,
    )
    b = Motion(
        i.b_vn + to_b * p.normal + p.b_cloth_n,
        i.b_vt + to_b * p.along + p.b_cloth_t,
        i.b_wn + turn_b * p.b_cloth_t,
        i.b_wt + turn_b * (to_b * p.up - p.b_cloth_n),
        i.b_wz - turn_b * to_b * p.along,
    )
    return a, b


def energy(i: BallImpact, a: Sequence[float], b: Sequence[float]) -> float:
    total = 0.0
    for radius, mass, motion in ((i.a_radius, i.a_mass, a), (i.b_radius, i.b_mass, b)):
        vn, vt, wn, wt, wz = motion
        turning = 0.4 * radius * radius * (wn * wn + wt * wt + wz * wz)
        total += 0.5 * mass * (vn * vn + vt * vt + turning)
    return total


def gained(i: BallImpact, p: BallImpulse) -> float:
    return energy(i, *after(i, p)) - energy(i, i[:5], i[8:13])


def mirrored(i: BallImpact) -> BallImpact:
    """Return the mirror image in the plane of n and z: t turns, and every spin but that about t."""
    signs = (1, -1, -1, 1, -1, 1, 1, 1)
    return BallImpact(*(sign * x for sign, x in zip(2 * signs, i, strict=True)))


def exchanged(i: BallImpact) -> BallImpact:
    """Call a b and b a: the frame turns by half a turn about the vertical."""
    signs = (-1, -1, -1, -1, 1, 1, 1, 1)
    return BallImpact(*(sign * x for sign, x in zip(2 * signs, i[8:] + i[:8], strict=True)))


# --- closed forms -------------------------------------------------------------------------------


@both_laws
@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.95, 1.0])
def test_without_friction_only_the_normal_impulse_acts(law: Law, restitution: float):
    """Bit for bit: scenes without ball friction must not change when friction exists."""
    i = impact_of(shot(0.7, 1.3, 1.0, 0.4), (-0.2, 0.1, 3.0, -2.0, 5.0))
    normal = (1.0 + restitution) * (i.a_vn - i.b_vn)
    assert law(i, laws(restitution, 0.0)) == (normal, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@both_laws
@pytest.mark.parametrize("cut", [0.05, 0.3, 0.7, 1.2])
@pytest.mark.parametrize("side", [-0.5, 0.0, 0.4, 0.8])
@pytest.mark.parametrize("friction", [0.06, "alciatore"])
def test_a_stunned_ball_throws_as_published(law: Law, cut: float, side: float, friction):
    """Alciatore's proof A.14; fails if a sign, the stick limit or the curve's slip is wrong."""
    v = 1.7
    i = impact_of(shot(cut, v, side=side))
    _, b = after(i, law(i, laws(1.0, friction)))
    slip = v * math.sin(cut) + v * side
    mu = alciatore_friction(abs(slip)) if friction == "alciatore" else friction
    part = min(mu * v * math.cos(cut) / abs(slip), 1.0 / 7.0)
    throw = part * slip / (v * math.cos(cut))
    assert b.vt / b.vn == pytest.approx(throw, rel=1e-14)


@both_laws
def test_gearing_spin_throws_nothing(law: Law):
    """R wz = -v sin(cut) in this frame: the surfaces meet without slip."""
    vn, vt = 1.0, 0.75
    i = impact_of((vn, vt, 0.0, 0.0, -vt / 0.03125), ball_a=(0.03125, 0.17, 0.2))
    assert law(i, laws(0.95, 0.06)) == (1.95, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@both_laws
@pytest.mark.parametrize("ball_b", [POOL_BALL, (0.02, 0.05, 0.2)])
@pytest.mark.parametrize("vt", [0.05, 2.0])
def test_the_energy_lost_to_a_sideways_slip_is_the_closed_form(law: Law, ball_b, vt: float):
    """Sticking loses m U^2/7, slipping mu J U - (7/4)(mu J)^2 / m, m the reduced mass."""
    e, mu, vn = 0.9, 0.06, 1.0
    i = impact_of((vn, vt, 0.0, 0.0, 0.0), ball_b=ball_b)
    mass = i.a_mass * i.b_mass / (i.a_mass + i.b_mass)
    friction = mu * mass * (1.0 + e) * vn
    slips = vt > 3.5 * (1.0 + e) * mu * vn
    assert slips == (vt == 2.0)
    loss = friction * vt - 1.75 * friction**2 / mass if slips else mass * vt**2 / 7.0
    loss += 0.5 * mass * (1.0 - e * e) * vn * vn
    assert -gained(i, law(i, laws(e, mu))) == pytest.approx(loss, rel=1e-13)


@both_laws
def test_a_slip_that_friction_can_end_ends(law: Law):
    i = impact_of((1.0, 0.1, 0.0, 2.0, 1.0), (0.0, 0.0, 0.0, -1.0, 2.0), ball_b=(0.02, 0.05, 0.2))
    a, b = after(i, law(i, laws(0.95, 0.2)))
    assert a.vt - b.vt + i.a_radius * a.wz + i.b_radius * b.wz == pytest.approx(0.0, abs=1e-15)
    up = -(i.a_radius * a.wt + i.b_radius * b.wt)
    before = -(i.a_radius * i.a_wt + i.b_radius * i.b_wt)
    # Vertical velocities are dropped after the impact, or held down during it.
    left = 2.0 / 7.0 * before if law is frictional else 0.0
    assert up == pytest.approx(left, abs=1e-15)


def test_friction_acts_along_the_slip_with_the_coefficient():
    """Fails if the two parts of friction are limited one by one."""
    i = impact_of(shot(0.6, 2.0, 1.0, 0.3))
    p = frictional(i, laws(0.9, 0.05))
    along, up = i.a_vt + R * i.a_wz, -R * i.a_wt
    assert math.hypot(p.along, p.up) == pytest.approx(0.05 * p.normal, rel=1e-15)
    assert p.along * up == pytest.approx(p.up * along, rel=1e-15)
    assert p.along > 0.0
    assert p.up < 0.0  # a rolling ball's front goes down, and takes b's surface with it


@pytest.mark.parametrize("scale", [2.0**-600, 2.0**-40, 2.0**500])
@both_laws
def test_the_scale_of_speeds_changes_nothing_bit_for_bit(law: Law, scale: float):
    """Fails if a square over- or underflows, or a tolerance has a unit."""
    i = impact_of(shot(0.4, 1.1, 1.0, 0.2), (0.1, -0.2, 3.0, 1.0, -4.0))
    scaled = impact_of([scale * x for x in i[:5]], [scale * x for x in i[8:13]])
    p = law(i, laws(0.9, 0.06))
    assert law(scaled, laws(0.9, 0.06)) == tuple(scale * x for x in p)


@both_laws
def test_slip_too_small_to_square_is_still_ended(law: Law):
    i = impact_of((1.0, 1e-200, 0.0, 0.0, 0.0))
    p = law(i, laws(1.0, 0.06))
    assert p.along == pytest.approx(2.0 / 7.0 * 1e-200, rel=1e-14)


# --- the cloth's part ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("speed", "topspin", "cut", "expected"),
    [
        (1.539, 58.63, 33.83, (0.914, 0.831, 31.93, 32.20)),
        (1.032, 39.31, 26.36, (0.520, 0.599, 32.45, 25.07)),
    ],
)
def test_the_published_snooker_shots(speed: float, topspin: float, cut: float, expected):
    """Mathavan et al. (2014), tables 1 and 2: speeds and directions once both balls roll.

    They were computed in finite steps from rounded data, which moves the angles by up to 0.03
    degrees. Without the cloth's part the cue ball would be 0.2 degrees off.
    """
    radius = SNOOKER_BALL[0]
    i = impact_of(
        shot(math.radians(cut), speed, topspin * radius / speed, radius=radius),
        ball_a=SNOOKER_BALL,
        ball_b=SNOOKER_BALL,
    )
    cue, target = (m.rolling(radius) for m in after(i, mathavan2014(i, laws(0.89, 0.05))))
    angles = [math.degrees(math.atan2(t, n)) - cut for n, t in (cue, target)]
    assert math.hypot(*cue) == pytest.approx(expected[0], abs=6e-4)
    assert math.hypot(*target) == pytest.approx(expected[1], abs=6e-4)
    assert angles[0] == pytest.approx(expected[2], abs=0.03)
    assert -angles[1] == pytest.approx(expected[3], abs=0.03)


def test_follow_presses_the_object_ball_and_draw_the_cue_ball():
    """The cloth then rubs against the pressed ball's own slip, and leaves the other alone."""
    follow = mathavan2014(impact_of(shot(0.0, 1.0, 1.0)), laws(0.95, 0.06))
    assert follow.up < 0.0
    assert follow.b_cloth_n < 0.0  # it slips forward as soon as it is hit
    assert (follow.a_cloth_n, follow.a_cloth_t) == (0.0, 0.0)
    draw = mathavan2014(impact_of(shot(0.0, 1.0, -1.0)), laws(0.95, 0.06))
    assert draw.up > 0.0
    assert draw.a_cloth_n < 0.0
    assert (draw.b_cloth_n, draw.b_cloth_t) == (0.0, 0.0)


def test_the_cloth_does_not_take_part_without_vertical_slip():
    i = impact_of((1.0, 0.4, 5.0, 0.0, 3.0), (0.0, 0.2, -3.0, 0.0, 1.0))
    assert mathavan2014(i, laws(0.9, 0.06)) == frictional(i, laws(0.9, 0.06))


def test_without_the_cloth_s_friction_the_normal_impulse_is_that_of_restitution():
    smooth = (R, 0.17, 0.0)
    i = impact_of(shot(0.4, 1.0, 1.0), ball_a=smooth, ball_b=smooth)
    for e in (0.0, 0.5, 1.0):
        p = mathavan2014(i, laws(e, 0.06))
        assert p.normal == pytest.approx((1.0 + e) * i.a_vn, rel=4.0 * EPS)
        assert p[3:] == (0.0, 0.0, 0.0, 0.0)


def test_a_speed_dependent_coefficient_is_that_of_the_slip_before():
    i = impact_of(shot(0.4, 1.0, 1.0))
    slip = math.hypot(i.a_vt, R * i.a_wt)
    constant = mathavan2014(i, laws(0.95, alciatore_friction(slip)))
    assert mathavan2014(i, laws(0.95, "alciatore")) == pytest.approx(constant, rel=1e-12)


def test_coefficients_above_any_cloth_s_count_as_the_highest():
    def with_cloth(cloth: float) -> BallImpact:
        rough = (R, 0.17, cloth)
        return impact_of(shot(0.4, 1.0, 1.0), ball_a=rough, ball_b=rough)

    highest = mathavan2014(with_cloth(HIGHEST_CLOTH), laws(0.95, HIGHEST_FRICTION))
    assert mathavan2014(with_cloth(50.0), laws(0.95, 30.0)) == highest


# --- a naive oracle -----------------------------------------------------------------------------


def naive(i: BallImpact, e: float, mu: float) -> list[float]:
    """Integrate the equations in all ten speeds, by small Runge-Kutta steps of the normal impulse.

    The steps shrink towards the ends of slips, where the equations are singular.
    """
    to_a, to_b = i.b_mass / (i.a_mass + i.b_mass), i.a_mass / (i.a_mass + i.b_mass)
    approach = i.a_vn - i.b_vn

    def slips(s):
        a, b = Motion(*s[:5]), Motion(*s[5:10])
        along = a.vt - b.vt + i.a_radius * a.wz + i.b_radius * b.wz
        up = -(i.a_radius * a.wt + i.b_radius * b.wt)
        cloth_a = (a.vn - i.a_radius * a.wt, a.vt + i.a_radius * a.wn)
        cloth_b = (b.vn - i.b_radius * b.wt, b.vt + i.b_radius * b.wn)
        return along, up, cloth_a, cloth_b

    def rub(limit, slip, push):
        if math.hypot(*slip) < 1e-13 * approach:
            slip = push
        return tuple(-limit * x / math.hypot(*slip) for x in slip)

    def rates(s, stuck):
        along, up, cloth_a, cloth_b = slips(s)
        ft = fz = 0.0
        ca = cb = (0.0, 0.0)
        if not stuck:
            ft, fz = (mu * x / math.hypot(along, up) for x in (along, up))
            if fz < 0.0:
                cb = rub(-i.b_cloth * to_b * fz, cloth_b, (1.0 - 2.5 * fz, ft))
            if fz > 0.0:
                ca = rub(i.a_cloth * to_a * fz, cloth_a, (-1.0 - 2.5 * fz, -ft))
        ka, kb = 2.5 / i.a_radius, 2.5 / i.b_radius
        return (
            *(-to_a + ca[0], -to_a * ft + ca[1]),
            *(ka * ca[1], ka * (to_a * fz - ca[0]), -ka * to_a * ft),
            *(to_b + cb[0], to_b * ft + cb[1]),
            *(kb * cb[1], kb * (to_b * fz - cb[0]), -kb * to_b * ft),
            s[0] - s[5],  # work
            *(1.0, ft, fz, *ca, *cb),
        )

    def step(s, h, stuck):
        k1 = rates(s, stuck)
        k2 = rates([x + h / 2 * k for x, k in zip(s, k1, strict=True)], stuck)
        k3 = rates([x + h / 2 * k for x, k in zip(s, k2, strict=True)], stuck)
        k4 = rates([x + h * k for x, k in zip(s, k3, strict=True)], stuck)
        zipped = zip(s, k1, k2, k3, k4, strict=True)
        return [x + h / 6 * (p + 2 * q + 2 * r + t) for x, p, q, r, t in zipped]

    def phase(s, left):
        stuck = False
        while True:
            along, up, cloth_a, cloth_b = slips(s)
            slip = math.hypot(along, up)
            stuck = stuck or slip < 1e-11 * approach
            h = approach / 1000
            if not stuck:
                cloth = math.hypot(*(cloth_a if up > 0.0 else cloth_b))
                h = min(h, 0.03 * slip / mu, max(0.03 * cloth, 1e-9 * approach))
            following = step(s, h, stuck)
            if left(following) <= 0.0:
                low, high = 0.0, h
                for _ in range(55):
                    middle = (low + high) / 2
                    low, high = (
                        (middle, high) if left(step(s, middle, stuck)) > 0.0 else (low, middle)
                    )
                return step(s, low, stuck)
            s = following

    s = phase([*i[:5], *i[8:13], *[0.0] * 8], lambda s: s[0] - s[5])
    stored = s[10]
    if e > 0.0:
        s = phase(s, lambda s: s[10] - stored * (1.0 - e * e))
    return s[11:]


ODD_BALL = (0.02, 0.4, 0.35)


@pytest.mark.parametrize(
    ("i", "e", "mu"),
    [
        (impact_of(shot(0.3, 2.0, 1.0)), 0.95, 0.06),  # the ordinary shot
        (impact_of(shot(1.4, 2.0, -1.0, 0.3)), 0.95, 0.06),  # thin, with draw
        (impact_of(shot(0.0, 1.0, 1.0)), 1.0, 0.06),  # along a line: all turns on signs
        (impact_of(shot(0.0, 1.0, 0.3)), 0.95, 0.06),  # slip ends in restitution
        (impact_of(shot(0.0, 1.0, -0.1)), 0.95, 0.06),  # slip ends in compression
        (impact_of(shot(0.3, 1.0, 0.1)), 0.5, 0.06),  # the same, sideways too
        (impact_of(shot(0.2, 1.0, 1.0), (0.0, 0.0, 0.0, 9.0, 0.0)), 0.9, 0.06),  # cloth slip
        (impact_of(shot(0.0, 1.0, 1.0), (0.0, 0.0, 0.0, 9.0, 0.0)), 0.9, 0.06),  # ... through 0
        (impact_of(shot(0.3, 1.0, 1.0), ball_b=ODD_BALL), 0.9, 0.06),
        (impact_of(shot(0.3, 1.0, -1.0), (0.1, 0.2, 1.0, 2.0, 3.0), ODD_BALL), 0.9, 0.06),
        (impact_of(shot(0.3, 1.0, 1.0, -0.3), ball_b=ODD_BALL), 0.0, 0.5),  # much friction
        (impact_of(shot(1.55, 1.0, 1.0)), 1e-3, 0.01),  # hardly any
    ],
)
def test_the_integration_agrees_with_the_naive_one(i: BallImpact, e: float, mu: float):
    """Fails if an equation differs, or the integration is less accurate than it says."""
    p = mathavan2014(i, laws(e, mu))
    assert p == pytest.approx(naive(i, e, mu), abs=1e-9 * (i.a_vn - i.b_vn), rel=0.0)


# --- properties ---------------------------------------------------------------------------------

signed = st.floats(-3.0, 3.0)
motions = st.one_of(
    st.just(REST),
    st.tuples(signed, signed, *[st.floats(-150.0, 150.0)] * 3),
    st.tuples(signed, signed).map(lambda v: (*v, -v[1] / R, v[0] / R, 0.0)),  # rolls
)
balls = st.one_of(
    st.just(POOL_BALL),
    st.tuples(st.floats(0.01, 0.1), st.floats(0.01, 1.0), st.floats(0.0, 1.0)),
)
impacts = (
    st.builds(impact_of, motions, motions, balls, balls)
    .map(lambda i: i if i.a_vn >= i.b_vn else exchanged(i))
    .map(lambda i: i if i.a_vn >= i.b_vn else i._replace(a_vn=i.b_vn, b_vn=i.a_vn))
    .filter(lambda i: i.a_vn > i.b_vn)
)
restitutions = st.sampled_from([0.0, 1e-3, 0.5, 0.95, 1.0])
frictions = st.sampled_from([0.0, 1e-6, 0.03, 0.06, 0.5, 5.0, "alciatore"])


@both_laws
@given(i=impacts, e=restitutions, mu=frictions)
def test_energy_never_rises(law: Law, i: BallImpact, e: float, mu: float | str):
    assert gained(i, law(i, laws(e, mu))) <= 8.0 * EPS * energy(i, i[:5], i[8:13])


@both_laws
@given(i=impacts, e=restitutions, mu=frictions)
def test_the_balls_never_approach_afterwards(law: Law, i: BallImpact, e: float, mu: float | str):
    p = law(i, laws(e, mu))
    a, b = after(i, p)
    assert p.normal >= 0.0
    assert a.vn - b.vn <= 4.0 * EPS * (abs(i.a_vn) + abs(i.b_vn))


@both_laws
@given(i=impacts, e=restitutions, mu=frictions)
def test_a_mirror_image_behaves_as_one_bit_for_bit(law: Law, i: BallImpact, e: float, mu):
    p, image = law(i, laws(e, mu)), law(mirrored(i), laws(e, mu))
    signs = (1, -1, 1, 1, -1, 1, -1)
    assert image == tuple(sign * x for sign, x in zip(signs, p, strict=True))


@both_laws
@given(i=impacts, e=restitutions, mu=frictions)
def test_it_does_not_matter_which_ball_is_called_a(law: Law, i: BallImpact, e: float, mu):
    """Bit for bit; fails if only one of the balls can be the pressed one."""
    p, other = law(i, laws(e, mu)), law(exchanged(i), laws(e, mu))
    cloth = (-p.b_cloth_n, -p.b_cloth_t, -p.a_cloth_n, -p.a_cloth_t)
    assert other == (p.normal, p.along, -p.up, *cloth)


@given(i=impacts, e=restitutions, mu=frictions)
def test_the_cloth_rubs_one_ball_no_more_than_it_is_pressed(i: BallImpact, e: float, mu):
    """The total is bounded by the coefficient times the vertical impulse on that ball."""
    p = mathavan2014(i, laws(e, mu))
    rounding = 1e-9 * (i.a_vn - i.b_vn) + 8.0 * EPS * (abs(p.up) + R * (abs(i.a_wt) + abs(i.b_wt)))
    on_a, on_b = math.hypot(p.a_cloth_n, p.a_cloth_t), math.hypot(p.b_cloth_n, p.b_cloth_t)
    share_b = i.a_mass / (i.a_mass + i.b_mass)
    assert on_a <= i.a_cloth * (1.0 - share_b) * max(p.up, 0.0) + rounding
    assert on_b <= i.b_cloth * share_b * max(-p.up, 0.0) + rounding
