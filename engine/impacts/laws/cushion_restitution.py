"""The cushion laws "restitution" and "mirror": two factors on the velocity; spin is unchanged."""

from __future__ import annotations

from ghostball.engine.core.kernel import kernel
from ghostball.engine.impacts.laws.interface import BallInFrame, Cushion, CushionBounce


@kernel
def restitution(impact: BallInFrame, cushion: Cushion) -> CushionBounce:
    """Return the bounce vn -> -e vn, vt -> f vt; both factors 1: a mirror.

    `impact`: the ball when it touches the cushion [m/s, rad/s, m, kg].
    `cushion`: `restitution` is e, `tangential` is f, both in [0, 1].

    Returns the ball after the impact [m/s, rad/s].

    Contract: no allocation. Two products and a change of sign, so a mirror is exact. The mirror is
        the law in section 4.2 of the paper (docs/paper.md).
    """
    return CushionBounce(
        -cushion.restitution * impact.vn,
        cushion.tangential * impact.vt,
        impact.wn,
        impact.wt,
        impact.wz,
        0.0,
    )
