"""The arrays that the kernels work on, by role; `running.from_scene` makes them from a scene.

`Balls`, the `Laws` with the obstacles, what each scheduler keeps (`Pairs`, `Cells`), `Contacts`
that act together, and the `Log`; each followed by the names of its columns and of their values.

Named tuples of arrays, because numba can neither cache jitclasses nor keep views of a row cheap.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ghostball.engine.core.rows import (
    BallRow,
    ComplianceRow,
    ContactRow,
    MemberRow,
    StageRow,
)
from ghostball.model.trajectory.polynomial import PER_POWER

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Int32Array = NDArray[np.int32]
BoolArray = NDArray[np.bool_]


class Balls(NamedTuple):
    """State of n balls, each at its own epoch; and what the event at hand does to them.

    The centre moves as x + vx s + ax s^2 / 2, s the time since `epoch`, and what `powers` add,
    until `own_time`, when the ball's own next event changes its motion. While it slides, its
    angular velocity changes at a constant rate, but for what `powers` add; while it rolls, the
    velocity gives it; about the vertical the cloth takes from it. In flight it stays as it is.
    m is enough for all pairs that can touch at once and one cushion, and for two cushions.

    One array for all numbers, because a kernel call passes every array of a named tuple as several
    words: with one array per number, the calls cost more than what they did. A ball's numbers lie
    together, so that a ball costs three cache lines however many there are.

    Python sees `state` as a matrix of numbers, (n, STATE_COLUMNS), kernels as rows with fields. How
    all of it reaches them is in `core.block`.
    """

    state: Any  # (n,) of `BallRow`
    own_kind: IntArray  # (n,) OWN_NONE ... below, OWN_CUSHION + a row, OWN_OVER + a row
    changed: BoolArray  # (n,) whether the event at hand changed the ball's motion
    touched: Int32Array  # (n + 1,) how many of those there are, then which
    touching: Int32Array  # (m, 2) as `Contacts.ends`: pairs that collide, or contacts to be held
    near: Int32Array  # (n,) room for a ball's neighbours
    counters: IntArray  # (COUNTERS,) those of the `Log`: every loop counts its turns in WORK
    powers: FloatArray | None  # (n, POWERS_COLUMNS): columns JERK_X ... below
    series: FloatArray | None  # (SERIES_ROWS, SERIES_TERMS) room for the series of a piece in air
    height: FloatArray | None  # (n, HEIGHT_COLUMNS): columns BASE ... below


# Columns of `Balls.powers`. The acceleration changes along x, along y and upwards by at most
# JERK_X, JERK_Y and JERK_UP [m/s^3] while the piece lasts; a piece where one of them isn't 0 ends.
# Then come COUNT powers of the time since `epoch`, the second power first, in the columns from
# POWERS on, with PER_POWER coefficients each: see `model.trajectory.polynomial`.
JERK_X = 0
JERK_Y = 1
JERK_UP = 2
COUNT = 3
POWERS = 4
MOST_POWERS = 24
POWERS_COLUMNS = POWERS + PER_POWER * MOST_POWERS


# Columns of `Balls.height`.
BASE = 0  # height of its centre where it lies on the cloth [m]; 0 where no ball may leave that
RISE = 1  # of a ball's lowest point above the cloth, at `epoch` [m]
UP_SPEED = 2  # its velocity upwards then [m/s]
FALL = 3  # and its acceleration downwards by gravity [m/s^2]; 0 on the cloth
LASTS = 4  # how long bounces that are too low to be followed take [s]; 0: there are none
END_VX = 5  # with which velocity [m/s] and angular velocity [rad/s] the ball continues
END_VY = 6
END_WX = 7
END_WY = 8
SLOW_IMPACTS = 9  # its slow impacts in flight since it last came down on the cloth
HELD = 10  # 1: it lies still on others, and is held there
STILL_X = 11  # where it has been for some time [m], within a tolerance
STILL_Y = 12
STILL_RISE = 13
STILL_SINCE = 14  # and since when [s]
LOADED = 15  # until when it counts as loaded by a ball that bounces on it [s]
HEIGHT_COLUMNS = 16

SERIES_TERMS = 26
SERIES_ROWS = 8


BALL_FIELDS = tuple(BallRow.__annotations__)

# The same as columns: of `Balls.state` as Python sees it, and of a motion's segments.
EPOCH = 0
X = 1
Y = 2
VX = 3
VY = 4
AX = 5
AY = 6
WX = 7
WY = 8
WZ = 9
BX = 10
BY = 11
BZ = 12
PHASE = 13
SEGMENT_COLUMNS = 14
OWN_TIME = 14
RADIUS = 15
MASS = 16
ROLL_SLOWING = 17
SLIDE_SLOWING = 18
SPIN_SLOWING = 19
CLOTH_FRICTION = 20

# Values of `PHASE`.
RESTING = 0.0  # the centre; it may spin about the vertical
SLIDING = 1.0
ROLLING = 2.0
GONE = 3.0  # it left the run where it is, and nothing meets it
FLYING = 4.0


class Laws(NamedTuple):
    """Constants of the scene."""

    slides: bool  # whether spin is a state of its own (else balls always roll)
    uniform: bool  # whether no ball is ever slowed, so that all move uniformly between events
    rubs: bool  # whether a ball's surface rubs on another's
    simultaneous: bool  # whether impacts at one instant are resolved together
    ball_law: int  # its place in `impact_laws.BALL_LAWS`
    ball_restitution: float
    ball_friction: float
    speed_dependent: bool  # whether Alciatore's curve stands for `ball_friction`
    t_max: float  # [s]; inf: until rest
    air_drag: float  # k in a = -k |v| v [1/m]
    airborne: bool  # whether balls may leave the cloth
    gravity: float  # [m/s^2]
    table_restitution: float
    roll_quadratic: float  # b of a rolling friction mu g + b v^2, beside the air [1/m]
    outer: int  # first row of `obstacles` from which on all lie outside of the frame, see below
    frame_x: float  # the frame: a rectangle from (0, 0) to here [m], along whose sides cushions lie
    frame_y: float
    # What balls bounce off, or fall into; `running.obstacle_rows` makes the rows. Python sees a
    # matrix (k, OBSTACLE_COLUMNS), kernels (k,) of `ObstacleRow`.
    obstacles: Any


TAKES_OUT = -1.0
"""In place of a law: a ball whose centre enters the obstacle leaves the run."""

# Values of `ObstacleRow.kind`.
LINE = 0.0
SEGMENT = 1.0
DISC = 2.0


class Pairs(NamedTuple):
    """Lower bounds of every pair's contact time, in a dense matrix; see `scheduling.all_pairs`."""

    bound: FloatArray  # (n n,) [s], row by row: a pair is in that of the ball recomputed last
    least: FloatArray  # (n,) least bound of the row
    next: FloatArray  # (n,) the less of that and the ball's own next event
    track: FloatArray  # copies of what bounds need: see `TRACKS`


# `Pairs.track` holds, for each block of TRACK_BALLS balls, TRACKS rows of TRACK_BALLS numbers:
# constant distances, from which the compiler sees that rows don't overlap, and that it may
# vectorise.
TRACK_BALLS = 64
TRACKS = 10
TRACK_X = 0 * TRACK_BALLS
TRACK_Y = 1 * TRACK_BALLS
TRACK_VX = 2 * TRACK_BALLS
TRACK_VY = 3 * TRACK_BALLS
TRACK_AX = 4 * TRACK_BALLS
TRACK_AY = 5 * TRACK_BALLS
TRACK_EPOCH = 6 * TRACK_BALLS
TRACK_RADIUS = 7 * TRACK_BALLS
TRACK_OWN_TIME = 8 * TRACK_BALLS
TRACK_JERK = 9 * TRACK_BALLS


class Cells(NamedTuple):
    """The cloth in cells, and the earliest bound of every ball with its neighbours.

    See `scheduling.broad_phase`, `scheduling.grid` and `scheduling.priority_queue`. Balls and cells
    have numbers of 32 bits: memory is what limits the largest scenes. What is used of a ball at
    one time is in one row.
    """

    frame: FloatArray  # (6,) the first cell's corner, x and y, a cell's side, largest diameter [m];
    # TIED_AT an instant [s] of which TIED_KIND is the least kind of own events, as far as is known:
    # whoever sets a ball's own event marks the ball, so that `broad_phase.update` enters it
    size: IntArray  # (2,) columns, rows; without the border
    first: Int32Array  # ((columns + 2) (rows + 2),) a ball in the cell, or NOWHERE
    link: Int32Array  # (n, 8): columns AFTER ... STAMP below
    slot: FloatArray  # (n, 3): columns LEAVES ... SECOND_BOUND below
    tree: FloatArray  # (2 p,) p >= n, a power of 2: leaves p + i are the balls' next instants [s]


# Columns of `Cells.frame`, after the lengths.
TIED_AT = 4
TIED_KIND = 5

# Columns of `Cells.link`.
AFTER = 0  # the next ball in the same cell, or NOWHERE
BEFORE = 1  # the one before
CELL_COLUMN = 2  # of the ball's cell, from 1 on; 0 before the run begins
CELL_ROW = 3
LEAVES_BY = 4  # on which side: 0 ... 3 is left, right, down, up; NOWHERE: look again then
SLOT_PARTNER = 5  # the other ball of the earliest bound; NOWHERE: not known any more
PARTNER_STAMP = 6  # and its stamp then
STAMP = 7  # how often the ball's motion has changed
LINK_COLUMNS = 8

# Columns of `Cells.slot`.
LEAVES = 0  # when the ball leaves its cell [s]
LEAST = 1  # its earliest bound [s]
SECOND_BOUND = 2  # [s] of all its pairs but that with SLOT_PARTNER and those in others' slots
SLOT_COLUMNS = 3


class Contacts(NamedTuple):
    """Contacts that act together: impacts of one instant, and islands of resting contact.

    See `impacts.simultaneous`, `resting_contact.step`, `resting_contact.islands` and
    `impacts.contact_solver`; m is enough for all pairs that can touch at once, and for as many
    obstacles at each ball as a table has cushions. Nothing grows with the square of n.
    """

    island: IntArray  # (n,) label of the ball's island, or FREE
    ring: IntArray  # (n,) the next member of the ball's island, round and round
    again: BoolArray  # (n,) whether the ball's island begins a new step
    waiting: IntArray  # (n + 1,) how many of those there are, then which
    stopped: BoolArray  # (n,) whether a contact step's start stopped the ball
    rolled: BoolArray  # (n,) whether a contact step's start ended the ball's slide
    member: IntArray  # (n,) balls of the island at hand
    first_held: IntArray  # (n,) the ball's first row of `held`, or NOWHERE
    held: IntArray  # (2 m, 2) PARTNER, that a contact step holds the ball to; NEXT row, or NOWHERE
    free: IntArray  # (2 m + 1,) how many rows of `held` are free, then which
    motion: Sequence[MemberRow]  # (n,)
    paths: FloatArray  # (n, 2, 6) coefficients of x and y [m], in units of the whole time
    spins: FloatArray  # (n, 3, 4) and of the angular velocity [rad/s]
    ends: IntArray  # (m, 2) FIRST: a ball; SECOND: another, or -1 minus a row of `Laws.obstacles`
    forces: Sequence[ContactRow]  # (m,)
    columns: FloatArray  # (m, CONTACT_COLUMNS) the same
    history: FloatArray  # (m, REMEMBERED + 1, PER_ROUND) the last rounds of forces
    matrix: FloatArray  # (MOST_DIRECT, MOST_DIRECT) room for the contacts' equations
    compliances: Sequence[
        ComplianceRow
    ]  # (2 MOST_DIRECT,) of each contact's first ball, and second
    stage: Sequence[StageRow]  # (MOST_DIRECT,)
    numbers: FloatArray  # (MOST_DIRECT, STAGE_COLUMNS) the same
    start: FloatArray  # (MOST_DIRECT, NUMBERS) the state at the start of the step
    slopes: FloatArray  # (MOST_DIRECT, STAGES, NUMBERS) how fast it changes at each stage
    turns: IntArray  # (1,) of loops, weighed as WORK; not counted there yet


NOWHERE = -1

# Columns of `Contacts.held`.
PARTNER = 0
NEXT = 1

MOST_OBSTACLES = 53
"""Rows of `Laws.obstacles`: `held_off` keeps a bit of a double for each."""

MOST_DIRECT = 12
"""Contacts up to which their equations are solved directly."""

# Columns of `Contacts.ends` and `Balls.touching`.
FIRST = 0
SECOND = 1


class Log(NamedTuple):
    """What happened: m events, and k balls whose motion changed, just after; m may be 0.

    `clock` and `counters` continue where a full log is followed by an empty one.
    """

    clock: FloatArray  # (CLOCKS,)
    counters: IntArray  # (COUNTERS,)
    time: FloatArray  # (m,) [s]
    what: IntArray  # (3, m): rows WHAT_KIND (EventKind), WHAT_A, WHAT_B
    ball: IntArray  # (k,)
    # (k, SEGMENT_COLUMNS ...): the first columns of `Balls.state`; RISE, UP_SPEED and FALL; and
    # those of `Balls.powers` from POWERS on.
    motion: FloatArray


class World(NamedTuple):
    """All that a run works on.

    The scheduler works with `pairs` or with `cells`; the arrays of the other one are empty. In the
    lean kernel, `powers`, `series` and `height` of `balls` are None. The compiler leaves out what
    follows `x is not None` if x is an argument whose type is None, but not if x is a field: so
    these fields are passed as arguments to the kernels that ask this. In the full kernel, laws such
    as `airborne` and `air_drag` decide at run time.
    """

    balls: Balls
    laws: Laws
    pairs: Pairs
    cells: Cells
    contacts: Contacts
    log: Log


WHAT_KIND = 0
WHAT_A = 1
WHAT_B = 2  # second ball, cushion index or -1


# Places in the array of counters, int64.
EVENTS = 0
BALL_BALL = 1
BALL_CUSHION = 2
BOUNDS = 3
ADVANCEMENTS = 4
JOINT_IMPACTS = 5
CONTACT_STEPS = 6
UNSOLVED_STEPS = 7
UNSOLVED_JOINT_IMPACTS = 8
LOGGED_EVENTS = 9
LOGGED_MOTIONS = 10
CELL_MOVES = 11
NOT_FINITE = 12  # of RUN_NOT_FINITE: the ball with it, or FREE where none is to blame
NO_ROOM = 13  # 1: more balls touch at once than `Balls.touching`, or `Contacts`, has room for
BALLS_GONE = 14
CONTACT_PIECES = 15
WORK = 16  # turns of all loops, in units of some 6 ns; what none may have without end
PAUSE_AT = 17  # WORK at which the kernel returns for a moment, so that Python hears an interrupt
STATUS = 18  # RUN_RESTED ... below: what the loop returned last
AT_ONCE = 19  # events within `ONE_INSTANT` of STOOD_SINCE: see `event_loop.loop`
ALOFT = 20  # balls that lie still on others
ENDLESS = 21  # of RUN_ENDLESS: 1 and the ball with it
COUNTERS = 22

# Places in the array of instants, float64 [s].
NOW = 0
LAST_EVENT = 1
END = 2  # when the last ball came to rest, or the run stopped
FARTHEST = 3  # largest coordinate of a ball at the end [m]
STOOD_SINCE = 4  # from when on AT_ONCE counts events
CLOCKS = 5

OWN_NONE = 0
OWN_REST = 1
OWN_ROLL = 2  # a slide ends
OWN_CONTACT = 3  # a contact step ends
OWN_PIECE = 4  # a piece ends, and another one begins
OWN_LAND = 5  # a ball in flight comes down on the cloth
OWN_BOUNCES_END = 6  # bounces that are too low to be followed end
OWN_CUSHION = 7  # + a row of `Laws.obstacles`: a ball meets that, be it a cushion or not
FIRST_HOLE = 2**17  # what an event calls a pocket that a ball flies over: this, + its place
OWN_OVER = 2**32  # + a row, above all rows: a ball flies over an obstacle, and off the table

FREE = -1

# What the loop returns. It never raises.
RUN_CONTINUES = -1
RUN_RESTED = 0
RUN_T_MAX = 1
RUN_EVENT_LIMIT = 2
RUN_LOG_FULL = 3
RUN_NOT_FINITE = 4
RUN_NO_ROOM = 5
RUN_PAUSED = 6  # it continues when called again
RUN_WORK_LIMIT = 7
RUN_STANDSTILL = 8  # events without end within `ONE_INSTANT`
RUN_ENDLESS = 9  # a ball that lies on others bounces without end
