"""Growth of small changes of a shot: its tangent map, and its horizon of predictability.

`tangent_map` is the interface; everything is computed from a recorded shot. On the cloth, `carried`
propagates changes from event to event: `motion` has the propagation between events, `passages` the
effect of an event, `laws` the effect of an impact, and `rounding` the changes by rounding. In air
and in flight, `replayed` lets the kernel of shots simulate changed states, with `replay`.
"""

from ghostball.engine.sensitivity.motion import PARTS
from ghostball.engine.sensitivity.tangent_map import (
    QUALITY,
    ROUNDING,
    EngineTangentMap,
    rounding_of,
    tangent_of,
)

__all__ = [
    "PARTS",
    "QUALITY",
    "ROUNDING",
    "EngineTangentMap",
    "rounding_of",
    "tangent_of",
]
