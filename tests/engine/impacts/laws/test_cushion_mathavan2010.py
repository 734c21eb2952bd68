"""Tests of Mathavan's law: closed forms, the published equations in small steps, and limits.

They fail for a wrong sign, a slip that chatters or jumps over 0, a step that is too long, a cloth
that pulls the ball down, or a phase that ends too early.
"""

import itertools
import math
from collections.abc import Callable
from typing import NamedTuple

import pytest
from cushion_impacts import R, cushion_of, impact_of, outcome, rolling
from hypothesis import example, given, settings, strategies as st
from kernels import entry_to
from scipy.integrate import solve_ivp

from ghostball.engine.impacts.laws.cushion_mathavan2010 import mathavan2010
from ghostball.engine.impacts.laws.interface import BallInFrame, Cushion

mathavan2010 = entry_to(mathavan2010)

ACCURACY = 1e-7  # relative to the approach speed, as the law states

# Other implementations of Mathavan's law. States are (vx, vy, R wx, R wy, R wz) in the frame of the
# paper by Mathavan et al.: x along the cushion, y into it, z up; so x = -t and y = n.


class Setting(NamedTuple):
    """Sine and cosine of the nose's angle and the coefficients of friction of nose and cloth."""

    sine: float
    cosine: float
    nose: float
    cloth: float


def setting_of(impact: BallInFrame, cushion: Cushion) -> Setting:
    sine = (cushion.height - impact.radius) / impact.radius
    return Setting(sine, math.sqrt(1 - sine**2), cushion.friction, impact.cloth)


def published_rates(state: list[float], setting: Setting, step: float = 0.0) -> list[float]:
    """Return d(state)/dp by the paper's equations, with p the impulse of the nose over the mass.

    The load on the cloth is at least 0. With a step, a slip that friction would reverse within the
    step gets only the friction that stops it. So a slip of 0 stays 0 to first order in the step.
    """
    vx, vy, wx, wy, wz = state
    sine, cosine, nose, cloth = setting
    x, y = vx + wy * sine - wz * cosine, wx - vy * sine
    cos_nose, sin_nose, nose = _direction(x, y, nose, step)
    load = max(sine + nose * sin_nose * cosine, 0.0)
    cos_cloth, sin_cloth, rub = _direction(vx - wy, vy + wx, cloth * load, step)
    return [
        -(nose * cos_nose + rub * cos_cloth),
        -(cosine - nose * sine * sin_nose + rub * sin_cloth),
        -2.5 * (nose * sin_nose + rub * sin_cloth),
        -2.5 * (nose * cos_nose * sine - rub * cos_cloth),
        2.5 * nose * cos_nose * cosine,
    ]


def _direction(x: float, y: float, friction: float, step: float) -> tuple[float, float, float]:
    length = math.hypot(x, y)
    if length == 0.0:
        return 0.0, 0.0, 0.0
    if step:
        friction = min(friction, length / (3.5 * step))
    return x / length, y / length, friction


def followed(impact: BallInFrame, cushion: Cushion) -> list[float]:
    """Return the result of an adaptive method of order 8, for impacts in which no slip ends."""
    setting = setting_of(impact, cushion)

    def rates(_: float, y: list[float]) -> list[float]:
        return [*published_rates(y[:5], setting), setting.cosine * y[1]]

    def until(quantity: Callable[[list[float]], float], y: list[float]) -> list[float]:
        def falls_to_0(_: float, y: list[float]) -> float:
            return quantity(y)

        falls_to_0.terminal = True  # type: ignore[attr-defined] # so it is asked for
        most = 10.0 * impact.vn
        found = solve_ivp(
            rates, (0.0, most), y, "DOP853", rtol=1e-11, atol=1e-13, events=falls_to_0
        )
        assert found.status == 1
        end: list[float] = found.y[:, -1].tolist()
        return end

    y = [*_to_paper(impact), 0.0]
    # A slip of 0 starts in the direction of its rate.
    y = [a + 1e-12 * impact.vn * b for a, b in zip(y, rates(0.0, y), strict=True)]
    y = until(lambda y: y[1], y)
    left = (1.0 - cushion.restitution**2) * y[5]
    return _from_paper(until(lambda y: y[5] - left, y))


def chattered(impact: BallInFrame, cushion: Cushion, steps: int) -> list[float]:
    """Return the result of first-order steps, `steps` per impulse of vn; slips may end.

    Richardson extrapolation of two runs removes the part of the error proportional to the step.
    """
    return [
        2.0 * fine - coarse
        for coarse, fine in zip(
            _chattered(impact, cushion, steps), _chattered(impact, cushion, 2 * steps), strict=True
        )
    ]


def _chattered(impact: BallInFrame, cushion: Cushion, steps: int) -> list[float]:
    setting, h = setting_of(impact, cushion), impact.vn / steps
    y = _to_paper(impact)
    work = stored = 0.0
    left = 1.0 - cushion.restitution**2
    while True:
        end = [a + h * b for a, b in zip(y, published_rates(y, setting, h), strict=True)]
        done = setting.cosine * h * 0.5 * (y[1] + end[1])
        if end[1] <= 0.0 < y[1]:
            # The part of the step before vy = 0 is stored.
            stored = work + setting.cosine * h * 0.5 * y[1] * y[1] / (y[1] - end[1])
        if stored and work + done <= left * stored:
            part = (left * stored - work) / done
            return _from_paper([a + part * (b - a) for a, b in zip(y, end, strict=True)])
        y, work = end, work + done


def _to_paper(impact: BallInFrame) -> list[float]:
    r = impact.radius
    return [-impact.vt, impact.vn, -r * impact.wt, r * impact.wn, r * impact.wz]


def _from_paper(y: list[float]) -> list[float]:
    return [y[1], -y[0], y[3], -y[2], y[4]]


def in_plane(impact: BallInFrame, cushion: Cushion) -> list[float]:
    """Return the closed-form result of an impact without motion along the cushion.

    The rates are constant between the times at which a slip ends, vn = 0, or the work is returned.
    The behaviour of a slip of 0 is found by trial: it stays 0 if friction can hold it; otherwise it
    starts in a direction that agrees with its rate.
    """
    setting = setting_of(impact, cushion)
    sine, cosine = setting.sine, setting.cosine
    vn, work = impact.vn, 0.0
    returned = None  # in the rebound: the work to be returned; `work` is the remaining part
    down = sine * vn + impact.radius * impact.wt
    skid = (1.0 + sine) * vn - down
    zero = 1e-13 * (abs(vn) + abs(down) + abs(skid))
    down, skid = (0.0 if abs(x) < zero else x for x in (down, skid))
    for _ in range(50):
        vn_rate, down_rate = _rates_in_plane(down, skid, setting)
        skid_rate = (1.0 + sine) * vn_rate - down_rate
        if returned is not None and (work <= 0.0 or (vn == 0.0 and vn_rate >= 0.0)):
            return [vn, 0.0, 0.0, down - sine * vn, 0.0]
        pairs = ((vn, vn_rate), (down, down_rate), (skid, skid_rate))
        until = min((-x / rate for x, rate in pairs if x * rate < 0.0), default=math.inf)
        # work + cosine (vn p + vn_rate p^2 / 2) = 0
        square = vn * vn - 2.0 * vn_rate * work / cosine
        if returned is not None and square >= 0.0 and math.sqrt(square) > vn:
            until = min(until, 2.0 * work / cosine / (math.sqrt(square) - vn))
        work += cosine * until * (vn + 0.5 * vn_rate * until)
        vn, down, skid = (
            0.0 if abs(x + until * rate) < zero else x + until * rate for x, rate in pairs
        )
        if vn <= 0.0 and returned is None:
            work = returned = cushion.restitution**2 * work
        elif returned is not None and abs(work) < 1e-14 * returned:
            work = 0.0
    raise AssertionError("the impact doesn't end")


def _rates_in_plane(down: float, skid: float, setting: Setting) -> tuple[float, float]:
    """Return the rates of vn and of the slip at the nose; they are 0 for a jammed ball."""
    sine, cosine, nose, cloth = setting
    jam = cosine / (1.0 + sine)
    if down == skid == 0.0 and nose >= jam and cloth >= jam:
        return 0.0, 0.0
    for at_nose, on_cloth in itertools.product(_ways(down), _ways(skid)):
        drag = (2.5 - sine) * cloth * on_cloth
        f = -nose * at_nose
        if not at_nose:  # the slip starts from a rate of 0, with or without a load on the cloth
            f = sine * (cosine - drag) / (2.5 + sine**2 + drag * cosine)
            if sine + cosine * f < 0.0:
                f = sine * cosine / (2.5 + sine**2)
        load = max(sine + cosine * f, 0.0)
        g = -cloth * load * on_cloth
        if not on_cloth:
            g = (cosine + (2.5 - sine) * f) / 3.5
        vn_rate = sine * f + g - cosine
        down_rate = (2.5 + sine**2) * f - (2.5 - sine) * g - sine * cosine
        skid_rate = (1.0 + sine) * vn_rate - down_rate
        nose_agrees = down or (down_rate * at_nose > 0.0 if at_nose else abs(f) <= nose)
        cloth_agrees = skid or (skid_rate * on_cloth > 0.0 if on_cloth else abs(g) <= cloth * load)
        if nose_agrees and cloth_agrees and (at_nose or on_cloth):
            return vn_rate, down_rate
    raise AssertionError("no way to continue")


def _ways(slip: float) -> tuple[int, ...]:
    return (round(math.copysign(1.0, slip)),) if slip else (0, -1, 1)


# --- the law

height = st.one_of(st.sampled_from([1.0, 1.27, 1.4]), st.floats(0.3, 1.8))


@settings(max_examples=300)
@given(
    topspin=st.one_of(st.sampled_from([0.0, 1.0, -0.4]), st.floats(-3.0, 3.0)),
    cloth=st.one_of(st.sampled_from([0.0, 0.212]), st.floats(0.0, 0.8)),
    friction=st.one_of(st.sampled_from([0.0, 0.14]), st.floats(0.0, 0.9)),
    e=st.one_of(st.sampled_from([0.0, 0.98, 1.0]), st.floats(0.0, 1.0)),
    height=height,
)
# A slip on the cloth that ends with compression; a rebound of less than rounding.
@example(topspin=0.0, cloth=1e-20, friction=0.0, e=0.0, height=1.27)
@example(topspin=0.0, cloth=0.0, friction=0.0, e=3.4e-156, height=1.0)
# A slip at the nose that ends: with a step error of 1e-9, the error of the speed was 2.2e-7.
@example(topspin=0.5, cloth=0.5, friction=0.125, e=0.98, height=1.0)
def test_a_ball_in_one_plane_follows_the_closed_form(topspin, cloth, friction, e, height):
    # In some of these impacts, slips end, stick and start again at both contacts, or the ball jams.
    impact = impact_of(1.0, wt=topspin / R, cloth=cloth)
    cushion = cushion_of(e, friction, height * R)
    after = outcome(mathavan2010(impact, cushion))
    assert after == pytest.approx(in_plane(impact, cushion), abs=ACCURACY)
    assert (after[1], after[2], after[4]) == (0.0, 0.0, 0.0)


def test_a_head_on_ball_without_friction_keeps_e_of_its_speed():
    for e in (0.0, 1e-6, 0.5, 1.0):
        after = mathavan2010(impact_of(1.0, cloth=0.0), cushion_of(e=e, friction=0.0))
        assert outcome(after) == pytest.approx((-e, 0.0, 0.0, 0.0, 0.0), abs=ACCURACY)


def test_a_rolling_ball_that_slips_throughout():
    # Head on at mid-ball with e = 1: the nose lifts the ball, so the cloth doesn't act. The
    # friction mu of the nose reduces the topspin R wt by 5/2 mu (1 + e) vn, and doesn't change vn.
    after = mathavan2010(rolling(1.0, 0.0), cushion_of(e=1.0, friction=0.14, height=R))
    assert after.vn == pytest.approx(-1.0, abs=ACCURACY)
    assert R * after.wt == pytest.approx(1.0 - 2.5 * 0.14 * 2.0, abs=ACCURACY)


@pytest.mark.parametrize(
    ("impact", "cushion"),
    [
        (rolling(1.0, 1.0), cushion_of()),
        (rolling(1.0, -0.4, 1.5), cushion_of()),
        (rolling(1.0, 2.0, 0.5), cushion_of(e=1.0)),
        (rolling(1.0, 2.0, 0.5), cushion_of(e=0.0)),
        (rolling(1.0, 0.7), cushion_of(0.8, 0.2, 0.9 * R)),
        (impact_of(1.0, 1.0), cushion_of()),
        (impact_of(1.0, 0.5, 3.0, 20.0, 30.0), cushion_of(0.9, 0.2)),
    ],
)
def test_slips_that_turn_follow_the_published_equations(impact, cushion):
    # No slip ends, so the law is more accurate than it states: as long as all its steps are smooth.
    expected = followed(impact, cushion)
    assert outcome(mathavan2010(impact, cushion)) == pytest.approx(expected, abs=1e-9)


@pytest.mark.compiled
@pytest.mark.parametrize(
    ("impact", "cushion"),
    [
        # The slip at the nose turns, ends and sticks in compression, and slips in the rebound.
        (impact_of(1.0, 0.2), cushion_of()),
        (impact_of(1.0, 0.3, 0.7 / R, -0.5 / R, 0.2 / R), cushion_of(0.98, 0.3)),
        # Pool.
        (rolling(1.0, 0.5, -1.0), cushion_of(0.85, 0.2, 1.27 * R)),
        (impact_of(1.0, 0.4, 0.2 / R, -0.6 / R, 0.3 / R), cushion_of(0.9, 0.2, 1.27 * R)),
        # The slip on the cloth ends and sticks.
        (impact_of(1.0, 0.05, 0.0, 0.9 / R, 0.3 / R, cloth=0.5), cushion_of(0.9, 0.1, 1.5 * R)),
    ],
)
def test_slips_that_end_follow_the_published_equations(impact, cushion):
    # This takes 60 000 uniform steps in total, per approach speed.
    expected = chattered(impact, cushion, 20_000)
    assert outcome(mathavan2010(impact, cushion)) == pytest.approx(expected, abs=ACCURACY)
