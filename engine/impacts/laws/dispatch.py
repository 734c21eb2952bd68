"""Calls of the law that a scene has chosen, by its index in `model.impact_laws`.

For resting contacts, `nose_sine` gives the height of the contact in a cushion's law.
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
    BallInFrame,
    Cushion,
    CushionBounce,
)
from ghostball.model.impact_laws import BALL_LAW_NAMES, CUSHION_LAW_NAMES, CUSHION_LAWS

_MATHAVAN2014 = BALL_LAW_NAMES.index("mathavan2014")
_FRICTIONAL_CUSHION = CUSHION_LAW_NAMES.index("frictional")
_HAN2005 = CUSHION_LAW_NAMES.index("han2005")
_STRONGE2000 = CUSHION_LAW_NAMES.index("stronge2000")
_MATHAVAN2010 = CUSHION_LAW_NAMES.index("mathavan2010")
_AT_THE_NOSE = tuple(k for k, law in enumerate(CUSHION_LAWS) if "cushion_height" in law.uses)

# These functions test for one law after another, because a kernel can't be passed as an argument.


@kernel(inline=True)
def ball_law(impact: BallImpact, laws: Laws) -> BallImpulse:
    """Return the impulse of an impact of two balls by the scene's law."""
    if laws.ball_law == _MATHAVAN2014:
        return mathavan2014(impact, laws)
    return frictional_balls(impact, laws)


@kernel(inline=True)
def cushion_law(impact: BallInFrame, laws: Laws, k: int) -> CushionBounce:
    """Return the bounce off obstacle k by its law."""
    row = laws.obstacles[k]
    returned = restitution_at(impact.vn, row.restitution, row.loss)
    cushion = Cushion(returned, row.tangential, row.friction, row.height, row.ratio)
    law = int(row.law)
    if law == _MATHAVAN2010:
        return mathavan2010(impact, cushion)
    if law in (_HAN2005, _STRONGE2000):
        return han2005(impact, cushion)
    if law == _FRICTIONAL_CUSHION:
        return frictional_cushion(impact, cushion)
    return restitution(impact, cushion)  # also "mirror", with both factors 1


@kernel(inline=True)
def is_ball_law_integrated(laws: Laws) -> bool:
    """Return whether the law of two balls integrates over the impact."""
    return bool(laws.ball_law == _MATHAVAN2014)


@kernel(inline=True)
def is_integrated(laws: Laws, k: int) -> bool:
    """Return whether the law of obstacle k integrates over the impact."""
    return bool(int(laws.obstacles[k].law) == _MATHAVAN2010)


@kernel
def nose_sine(laws: Laws, k: int, radius: float) -> float:
    """Return the sine of the angle of the contact above the horizontal, in obstacle k's law."""
    if int(laws.obstacles[k].law) in _AT_THE_NOSE:
        height: float = laws.obstacles[k].height
        return (height - radius) / radius
    return 0.0
