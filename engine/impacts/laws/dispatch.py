"""Calls the law that a scene chose, by its place in `model.impact_laws`.

And tells contacts that last at which height a cushion's law has it touch the ball.
"""

from __future__ import annotations

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Laws
from ghostball.engine.impacts.laws.ball_frictional import frictional as frictional_balls
from ghostball.engine.impacts.laws.ball_mathavan2014 import mathavan2014
from ghostball.engine.impacts.laws.cushion_han2005 import frictional as frictional_cushion, han2005
from ghostball.engine.impacts.laws.cushion_mathavan2010 import mathavan2010
from ghostball.engine.impacts.laws.cushion_restitution import restitution
from ghostball.engine.impacts.laws.falling_restitution import restitution_at
from ghostball.engine.impacts.laws.interface import (
    BallImpact,
    BallImpulse,
    Cushion,
    CushionBounce,
    CushionImpact,
)
from ghostball.model.impact_laws import BALL_LAW_NAMES, CUSHION_LAW_NAMES, CUSHION_LAWS

_MATHAVAN2014 = BALL_LAW_NAMES.index("mathavan2014")
_FRICTIONAL_CUSHION = CUSHION_LAW_NAMES.index("frictional")
_HAN2005 = CUSHION_LAW_NAMES.index("han2005")
_MATHAVAN2010 = CUSHION_LAW_NAMES.index("mathavan2010")
_AT_THE_NOSE = tuple(k for k, law in enumerate(CUSHION_LAWS) if "cushion_height" in law.uses)

# Chains of comparisons, because a kernel can't be handed another one.


@kernel(inline=True)
def ball_law(impact: BallImpact, laws: Laws) -> BallImpulse:
    """Return what the scene's law makes of a ball-ball impact."""
    if laws.ball_law == _MATHAVAN2014:
        return mathavan2014(impact, laws)
    return frictional_balls(impact, laws)


@kernel(inline=True)
def cushion_law(impact: CushionImpact, laws: Laws, k: int) -> CushionBounce:
    """Return what the law of obstacle k makes of an impact with it."""
    row = laws.obstacles[k]
    returned = restitution_at(impact.vn, row.restitution, row.loss)
    cushion = Cushion(returned, row.tangential, row.friction, row.height)
    law = int(row.law)
    if law == _MATHAVAN2010:
        return mathavan2010(impact, cushion)
    if law == _HAN2005:
        return han2005(impact, cushion)
    if law == _FRICTIONAL_CUSHION:
        return frictional_cushion(impact, cushion)
    return restitution(impact, cushion)  # a mirror where both its factors are 1


@kernel(inline=True)
def is_ball_law_integrated(laws: Laws) -> bool:
    """Whether the law of two balls integrates over the impact."""
    return bool(laws.ball_law == _MATHAVAN2014)


@kernel(inline=True)
def is_integrated(laws: Laws, k: int) -> bool:
    """Whether the law of obstacle k integrates over the impact."""
    return bool(int(laws.obstacles[k].law) == _MATHAVAN2010)


@kernel
def nose_sine(laws: Laws, k: int, radius: float) -> float:
    """Return the sine of the angle above the horizontal at which obstacle k's law sees its nose."""
    if int(laws.obstacles[k].law) in _AT_THE_NOSE:
        height: float = laws.obstacles[k].height
        return (height - radius) / radius
    return 0.0
