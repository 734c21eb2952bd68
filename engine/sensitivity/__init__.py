"""How small changes of a shot grow: its tangent map, and until when it can be predicted.

`tangent_map` is what Python calls, `propagate` the kernels that carry small changes along a shot.
"""

from ghostball.engine.sensitivity.state import PARTS
from ghostball.engine.sensitivity.tangent_map import (
    LANES,
    QUALITY,
    ROUNDING,
    TangentMap,
    rounding_of,
    tangent_of,
)

__all__ = [
    "LANES",
    "PARTS",
    "QUALITY",
    "ROUNDING",
    "TangentMap",
    "rounding_of",
    "tangent_of",
]
