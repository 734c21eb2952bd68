"""Ball-cushion impacts for tests: short to write down."""

from __future__ import annotations

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
