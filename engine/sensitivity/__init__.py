"""How small changes of a shot grow: its tangent map, and until when it can be predicted.

`tangent_map` is what Python calls; `motion` says how a change continues between events, `passages`
what an event does to it, `laws` what an impact does, and `rounding` which changes rounding makes.
All of it is computed from a recorded shot.
"""

from ghostball.engine.sensitivity.motion import PARTS
from ghostball.engine.sensitivity.tangent_map import (
    QUALITY,
    ROUNDING,
    TangentMap,
    rounding_of,
    tangent_of,
)

__all__ = [
    "PARTS",
    "QUALITY",
    "ROUNDING",
    "TangentMap",
    "rounding_of",
    "tangent_of",
]
