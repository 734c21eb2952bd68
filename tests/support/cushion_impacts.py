"""Short functions for ball-cushion impacts in tests."""

from __future__ import annotations

from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from ghostball.engine.impacts.laws.interface import BallInFrame, Cushion, CushionBounce

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
) -> BallInFrame:
    return BallInFrame(vn, vt, wn, wt, wz, radius, 0.1406, cloth)


def rolling(vn: float, vt: float, side: float = 0.0, **fields: float) -> BallInFrame:
    """Return the impact of a rolling ball; `side`: side spin R wz over the approach speed."""
    return impact_of(vn, vt, -vt / R, vn / R, side * vn / R, **fields)


def cushion_of(
    e: float = 0.98,
    friction: float = 0.14,
    height: float = 1.4 * R,
    tangential: float = 1.0,
    ratio: float = 0.0,
) -> Cushion:
    """Return a cushion with these constants; the defaults are those of Mathavan 2010."""
    return Cushion(e, tangential, friction, height, ratio)


def energy(ball: BallInFrame | CushionBounce, radius: float = R) -> float:
    """Return the energy divided by the mass, with I = 2/5 m R^2."""
    turning = ball.wn**2 + ball.wt**2 + ball.wz**2
    return 0.5 * (ball.vn**2 + ball.vt**2) + 0.2 * radius**2 * turning


def outcome(ball: BallInFrame | CushionBounce, radius: float = R) -> list[float]:
    """Return the velocity and R times the angular velocity [m/s]."""
    return [ball.vn, ball.vt, radius * ball.wn, radius * ball.wt, radius * ball.wz]


def reflected(impact: BallInFrame) -> BallInFrame:
    """Return the mirror image along the cushion; an angular velocity is an axial vector."""
    return impact._replace(vt=-impact.vt, wn=-impact.wn, wz=-impact.wz)


def _without_tiny(numbers: SearchStrategy[float]) -> SearchStrategy[float]:
    """Return numbers large enough that scaling by powers of two is exact, without underflow."""
    return numbers.map(lambda x: x if abs(x) > 1e-100 else 0.0)


# Speeds in units of the approach speed, from far below 1 to far above 1, and 0.
_spin = _without_tiny(
    st.one_of(st.sampled_from([0.0, 1.0, -1.0]), st.floats(-1.5, 1.5), st.floats(-40.0, 40.0))
)
_coefficient = _without_tiny(st.one_of(st.sampled_from([0.0, 0.14]), st.floats(0.0, 2.0)))
_part = _without_tiny(st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.0, 1.0)))
impacts = st.builds(
    lambda vn, vt, wn, wt, wz, cloth: impact_of(
        vn, vn * vt, vn * wn / R, vn * wt / R, vn * wz / R, cloth=cloth
    ),
    st.sampled_from([1.0, 1e-3, 7.5]),
    *[_spin] * 4,
    _coefficient,
)
cushions = st.builds(
    cushion_of,
    e=_part,
    friction=_coefficient,
    height=st.one_of(st.sampled_from([1.0, 1.4]), st.floats(0.01, 1.99)).map(lambda h: h * R),
    tangential=_part,
)
