"""The numbers of a segment: the motion of one ball from one event to the next.

They are the columns of `ExactTrajectory.segments`, which documents them and the columns that may
follow.
"""

from __future__ import annotations

import enum

NAMES = (
    *("epoch", "x", "y", "vx", "vy", "ax", "ay"),
    *("wx", "wy", "wz", "bx", "by", "bz"),
    "phase",
)
"""Columns for parabolic motion on the cloth; columns for other motion follow."""

COLUMNS = len(NAMES)
EPOCH, X, Y, VX, VY, AX, AY, WX, WY, WZ, BX, BY, BZ, PHASE = range(COLUMNS)


class Phase(enum.IntEnum):
    """How a ball moves: on the cloth, in flight, or not at all because it has left the table."""

    RESTING = 0
    """The centre is at rest; the ball may spin about the vertical."""
    SLIDING = 1
    """The lowest point of the ball slips on the cloth."""
    ROLLING = 2
    """The lowest point of the ball doesn't slip; the ball may also spin about the vertical."""
    GONE = 3
    """The ball was pocketed or left the table; its position stays the last one."""
    FLYING = 4
    """The ball is in the air; its angular velocity is constant."""
    COMPRESSED = 5
    """The ball belongs to a group of balls that push each other (`impacts = "compliant"`): its
    velocity is the mean over a part of the contact, and the energy of the contacts isn't in it."""
