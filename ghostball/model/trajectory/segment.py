"""The numbers of a segment of a ball's motion, which hold from an instant on until the next one.

They are the columns of `ExactTrajectory.segments`, which says what each is and what may follow.
"""

from __future__ import annotations

import enum

NAMES = (
    *("epoch", "x", "y", "vx", "vy", "ax", "ay"),
    *("wx", "wy", "wz", "bx", "by", "bz"),
    "phase",
)
"""Of a motion on the cloth along a parabola; what there is beyond that follows."""

COLUMNS = len(NAMES)
EPOCH, X, Y, VX, VY, AX, AY, WX, WY, WZ, BX, BY, BZ, PHASE = range(COLUMNS)


class Phase(enum.IntEnum):
    """How a ball moves: on the cloth, in the air, or no more."""

    RESTING = 0
    """Its centre rests; it may spin about the vertical."""
    SLIDING = 1
    """Its lowest point slips over the cloth."""
    ROLLING = 2
    """Its lowest point does not slip; it may spin about the vertical, too."""
    GONE = 3
    """It left the run, and stays where it did."""
    FLYING = 4
    """It is in the air; its angular velocity stays as it is."""
