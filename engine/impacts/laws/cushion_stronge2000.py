"""The cushion law "stronge2000": restitution and friction at a nose that yields along the slip.

Stronge, W. J. (2000): Impact Mechanics. Cambridge University Press, chapter 5.
"""

from __future__ import annotations

from ghostball.engine.core.kernel import kernel
from ghostball.engine.impacts.laws.cushion_han2005 import bounce_off_nose
from ghostball.engine.impacts.laws.interface import Cushion, CushionBounce, CushionImpact


@kernel
def stronge2000(impact: CushionImpact, cushion: Cushion) -> CushionBounce:
    """Return the bounce off a nose at its height, by Stronge's model of a contact that yields.

    `impact`: the ball when it touches the cushion [m/s, rad/s, m, kg]; the mass cancels.
    `cushion`: `restitution` in [0, 1], `friction` >= 0, `height`, above the cloth and below the top
        of the ball [m], and `ratio` in (1, 2), the frequency of the spring along the slip over that
        of the normal spring.

    Returns the ball after the impact [m/s, rad/s].

    Contract: as for `han2005`. The only difference is the tangential impulse: the rubber stores
    energy along the slip as well, and returns it (`compliant_contact`). A stiff contact along the
    slip isn't the limit of a large ratio: for a ratio of 2 or more, the contact may slip and stick
    several times, and the formulas don't hold.
    """
    sine = (cushion.height - impact.radius) / impact.radius
    return bounce_off_nose(impact, cushion, sine)
