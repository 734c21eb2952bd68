"""The arrays that the tangent map works on, and their columns; see `sensitivity.propagate`."""

from __future__ import annotations

from typing import NamedTuple

from ghostball.engine.core.state import FloatArray, IntArray, Laws

LANES = 8
"""Perturbations that are carried at once: two vector registers of doubles."""

# Parts of a perturbation of a ball, as offsets of their first lane in a row.
DX = 0 * LANES  # position [m]
DY = 1 * LANES
DVX = 2 * LANES  # velocity [m/s]
DVY = 3 * LANES
DWX = 4 * LANES  # angular velocity [rad/s]; of no meaning for a ball that rolls or rests
DWY = 5 * LANES
DWZ = 6 * LANES  # this one always
PARTS = 7
ROW_LENGTH = PARTS * LANES
"""Length of a row: all lanes of all parts."""

# Places in `Tangents.work`. One array, because the compiler makes vectors of a loop only where it
# sees that what is written isn't what is read: at constant distances in one array it does.
FIRST_BALL = 0 * ROW_LENGTH  # perturbation of the first ball of the event at hand
SECOND_BALL = 1 * ROW_LENGTH
TAU = 2 * ROW_LENGTH  # how much later the event comes [s]
THETA = TAU + LANES  # by what angle the normal of the contact is turned
FRAME = THETA + LANES  # perturbations of what a law is given, in the frame of the contact
GIVEN = FRAME + 10 * LANES  # and of what it gives
WORK = GIVEN + 7 * LANES

LAW_IN = 10  # numbers that a law is given: velocity and angular velocity of two balls
LAW_OUT = 7  # and gives at most: a `BallImpulse`

# What a law is given, by column of `Tangents.law`: n, t and z of velocity and angular velocity of
# the first ball, or the only one, and of the second.
A_VN = 0
A_VT = 1
A_WN = 2
A_WT = 3
A_WZ = 4
B_VN = 5
B_VT = 6
B_WN = 7
B_WT = 8
B_WZ = 9

# Columns of `Tangents.motion`: a ball just before the event at hand.
PRE_VX = 0  # [m/s]
PRE_VY = 1
PRE_AX = 2  # [m/s^2]
PRE_AY = 3
PRE_WX = 4  # [rad/s], also of a ball that rolls
PRE_WY = 5
PRE_WZ = 6
PRE_BX = 7  # [rad/s^2]
PRE_BY = 8
PRE_BZ = 9
PRE_COLUMNS = 10


class Tangents(NamedTuple):
    """Perturbations of n balls along k segments and m events; inputs, then what is written.

    `segments` and `tangent` are ball by ball, each ball's in order of time.
    """

    lanes: int  # LANES, which the compiler isn't to know: it would unroll instead of making vectors
    state: FloatArray  # (n, STATE_COLUMNS): radius, mass and decelerations are used
    laws: Laws
    segments: FloatArray  # (k, SEGMENT_COLUMNS)
    first: IntArray  # (n + 1,) row of each ball's first segment, then k
    rank: IntArray  # (n,) of each ball by its first place: what its number doesn't change
    time: FloatArray  # (m,) of the events [s]
    what: IntArray  # (m, 3): EventKind, a, b
    rounding: float  # size of the perturbation that each event adds, over the state's; 0: none
    signs: int  # which random signs that perturbation has
    tangent: FloatArray  # (k ROW_LENGTH,) as each segment starts; not finite: there is none
    shift: FloatArray  # (m LANES,) how much later each event comes [s]
    at: IntArray  # (n,) the segment that each ball has come to
    due: IntArray  # (n,) collisions that a ball has at one instant
    motion: FloatArray  # (2, PRE_COLUMNS): columns PRE_VX ... above, of the balls of the event
    work: FloatArray  # (WORK,): offsets FIRST_BALL ... above
    law: FloatArray  # (LAW_OUT, LAW_IN) derivative of the law of the impact at hand
