"""How small changes of a shot grow: its tangent map, and until when it can be predicted.

`tangent_map` is what Python calls. All of it is computed from a recorded shot. On the cloth
`carried` takes changes from event to event: `motion` says how they continue in between, `passages`
what an event does to them, `laws` what an impact does, and `rounding` which of them rounding makes.
In air and in flight `replayed` has the kernel of shots play from changed states, by `replay`.
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
