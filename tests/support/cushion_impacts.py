"""Ball-cushion impacts for tests: short to write down, and solved by other means than the laws'."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import NamedTuple

from scipy.integrate import solve_ivp

from ghostball.engine.impacts.laws.interface import Cushion, CushionBounce, CushionImpact

R = 0.02625
"""Radius of a snooker ball [m], as in Mathavan's papers."""


def impact_of(
    vn: float,
    vt: float = 0.0,
    wn: float = 0.0,
    wt: float = 0.0,
    wz: float = 0.0,
    *,
    radius: float = R,
    cloth: float = 0.212,
) -> CushionImpact:
    return CushionImpact(vn, vt, wn, wt, wz, radius, 0.1406, cloth)


def rolling(vn: float, vt: float, side: float = 0.0, **fields: float) -> CushionImpact:
    """Return a ball that rolls, with `side` times the speed of approach of side spin R wz."""
    return impact_of(vn, vt, -vt / R, vn / R, side * vn / R, **fields)


def cushion_of(
    e: float = 0.98, friction: float = 0.14, height: float = 1.4 * R, tangential: float = 1.0
) -> Cushion:
    """Return a cushion with these constants; as given, those of Mathavan 2010."""
    return Cushion(e, tangential, friction, height)


def energy(ball: CushionImpact | CushionBounce, radius: float = R) -> float:
    """Return the energy over the mass: I = 2/5 m R^2."""
    turning = ball.wn**2 + ball.wt**2 + ball.wz**2
    return 0.5 * (ball.vn**2 + ball.vt**2) + 0.2 * radius**2 * turning


def outcome(ball: CushionImpact | CushionBounce, radius: float = R) -> list[float]:
    """Return the velocity and R times the angular velocity [m/s]."""
    return [ball.vn, ball.vt, radius * ball.wn, radius * ball.wt, radius * ball.wz]


def reflected(impact: CushionImpact) -> CushionImpact:
    """Return the mirror image along the cushion; an angular velocity is an axial vector."""
    return impact._replace(vt=-impact.vt, wn=-impact.wn, wz=-impact.wz)


# Mathavan's law by other means. States are (vx, vy, R wx, R wy, R wz) in the paper's frame: x along
# the cushion, y into it, z up; so x = -t and y = n.


class Setting(NamedTuple):
    """Sine and cosine of the nose's angle and the coefficients of friction of nose and cloth."""

    sine: float
    cosine: float
    nose: float
    cloth: float


def setting_of(impact: CushionImpact, cushion: Cushion) -> Setting:
    sine = (cushion.height - impact.radius) / impact.radius
    return Setting(sine, math.sqrt(1 - sine**2), cushion.friction, impact.cloth)


def published_rates(state: list[float], setting: Setting, step: float = 0.0) -> list[float]:
    """Return d(state)/dp, by the equations of the paper, p the impulse of the nose over the mass.

    The load of the cloth is at least 0. With a step, a slip that friction would reverse within it
    meets only what stops it: so a slip of 0 stays 0 to the first order of the step.
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


def followed(impact: CushionImpact, cushion: Cushion) -> list[float]:
    """Return the outcome by an adaptive method of eighth order, where no slip ends."""
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


def chattered(impact: CushionImpact, cushion: Cushion, steps: int) -> list[float]:
    """Return the outcome by uniform first-order steps, `steps` to an impulse of vn; slips may end.

    From two runs, so that the part of the error goes that is proportional to the step (Richardson).
    """
    return [
        2.0 * fine - coarse
        for coarse, fine in zip(
            _chattered(impact, cushion, steps), _chattered(impact, cushion, 2 * steps), strict=True
        )
    ]


def _chattered(impact: CushionImpact, cushion: Cushion, steps: int) -> list[float]:
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


def _to_paper(impact: CushionImpact) -> list[float]:
    r = impact.radius
    return [-impact.vt, impact.vn, -r * impact.wt, r * impact.wn, r * impact.wz]


def _from_paper(y: list[float]) -> list[float]:
    return [y[1], -y[0], y[3], -y[2], y[4]]


def in_plane(impact: CushionImpact, cushion: Cushion) -> list[float]:
    """Return the outcome of an impact without anything along the cushion, in closed form.

    Rates are constant from one instant at which a slip ends, vn = 0 or the work is returned to the
    next. What a slip of 0 does is found by trying: it stays 0 if friction can hold it, or it starts
    in a direction that its rate then agrees with.
    """
    setting = setting_of(impact, cushion)
    sine, cosine = setting.sine, setting.cosine
    vn, work = impact.vn, 0.0
    returned = None  # in the rebound: what of the work is to come back; `work` is what still is
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
    """Return the rates of vn and of the slip at the nose; those of a ball that is jammed are 0."""
    sine, cosine, nose, cloth = setting
    jam = cosine / (1.0 + sine)
    if down == skid == 0.0 and nose >= jam and cloth >= jam:
        return 0.0, 0.0
    for at_nose, on_cloth in itertools.product(_ways(down), _ways(skid)):
        drag = (2.5 - sine) * cloth * on_cloth
        f = -nose * at_nose
        if not at_nose:  # from a rate of 0 of the slip, with a load of the cloth or without
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
