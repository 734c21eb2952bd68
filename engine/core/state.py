"""The arrays that kernels work on, grouped by role; `running.from_scene` makes them from a scene.

`Balls`, `Laws` with the obstacles, the arrays of each scheduler (`Pairs`, `Cells`), `Contacts` and
the `Log`; each is followed by the names of its columns and of their values.

They are named tuples of arrays, because numba can't cache jitclasses, and views of a row are slow.
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
    """State of n balls, each at its own epoch, and the changes that the current event makes.

    The centre moves as x + vx s + ax s^2 / 2 plus the terms in `powers`, where s is the time since
    `epoch`, until `own_time`, when the ball's own next event changes its motion. The angular
    velocity of a sliding ball changes at a constant rate, plus the terms in `powers`; that of a
    rolling ball follows from its velocity; that of a flying ball is constant. The cloth slows the
    vertical spin. `touching` has m rows: one for each pair that can touch at once and one for a
    cushion, but at least two, because a ball may touch two cushions.

    All numbers are in one array, because a kernel call passes every array of a named tuple as
    several words: with one array per number, calls took longer than the work. The numbers of a ball
    are adjacent, so that each ball takes three cache lines, however many balls there are.

    Python sees `state` as a matrix of numbers, (n, STATE_COLUMNS), kernels as rows with fields;
    `core.block` describes how these arrays reach the kernels.
    """

    state: Any  # (n,) of `BallRow`
    own_kind: IntArray  # (n,) see OWN_NONE ...; OWN_CUSHION + a row, OWN_OVER + a row
    changed: BoolArray  # (n,) whether the current event changed the ball's motion
    touched: Int32Array  # (n + 1,) the number of changed balls, then their indices
    touching: Int32Array  # (m, 2) as `Contacts.ends`: pairs that collide, or contacts to be held
    near: Int32Array  # (n,) scratch for the neighbours of a ball
    counters: IntArray  # the counters of the `Log`: every loop counts its iterations in WORK
    powers: FloatArray | None  # (n, POWERS_COLUMNS): columns JERK_X ...
    series: FloatArray | None  # (SERIES_ROWS, SERIES_TERMS) scratch for the series of a piece
    height: FloatArray | None  # (n, HEIGHT_COLUMNS): columns BASE ...


# Columns of `Balls.powers`. JERK_X, JERK_Y and JERK_UP [m/s^3] are bounds on the rate of change of
# the acceleration along x, along y and upwards during the piece; if one of them isn't 0, the piece
# has an end. Then come COUNT powers of the time since `epoch`, from the second power on, in the
# columns from POWERS on, with PER_POWER coefficients each: see `model.trajectory.polynomial`.
JERK_X = 0
JERK_Y = 1
JERK_UP = 2
COUNT = 3
POWERS = 4
MOST_POWERS = 24
POWERS_COLUMNS = POWERS + PER_POWER * MOST_POWERS


# Columns of `Balls.height`.
BASE = 0  # height of its centre when it lies on the cloth [m]; 0 if no ball may leave the cloth
RISE = 1  # height of its lowest point above the cloth, at `epoch` [m]
UP_SPEED = 2  # upward velocity at `epoch` [m/s]
FALL = 3  # downward acceleration by gravity [m/s^2]; 0 on the cloth
LASTS = 4  # duration of its bounces that are too low to be followed [s]; 0: none
END_VX = 5  # velocity [m/s] and angular velocity [rad/s] after these bounces
END_VY = 6
END_WX = 7
END_WY = 8
SLOW_IMPACTS = 9  # number of its slow impacts in flight since it last landed on the cloth
HELD = 10  # 1: it lies still on other balls, and is held there
STILL_X = 11  # position near which it has stayed, within a tolerance [m]
STILL_Y = 12
STILL_RISE = 13
STILL_SINCE = 14  # time since which it has stayed there [s]
LOADED = 15  # time until which it counts as loaded by a ball that bounces on it [s]
HEIGHT_COLUMNS = 16

SERIES_TERMS = 26
SERIES_ROWS = 8


BALL_FIELDS = tuple(BallRow.__annotations__)

# Columns of the same fields in `Balls.state` as Python sees it, and in the segments of a motion.
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
RESTING = 0.0  # the centre is at rest; the ball may spin about the vertical
SLIDING = 1.0
ROLLING = 2.0
GONE = 3.0  # it has left the run, and nothing hits it
FLYING = 4.0
COMPRESSED = 5.0  # only in a log, for a ball whose own event is OWN_LEG


class Laws(NamedTuple):
    """Constants of the scene."""

    slides: bool  # whether spin is independent of velocity (if not, balls always roll)
    uniform: bool  # whether no ball is ever slowed, so that all move uniformly between events
    simultaneous: bool  # whether simultaneous impacts are resolved together
    ball_law: int  # index in `impact_laws.BALL_LAWS`
    ball_restitution: float
    ball_friction: float
    speed_dependent: bool  # whether Alciatore's curve replaces `ball_friction`
    t_max: float  # [s]; inf: until rest
    air_drag: float  # k in a = -k |v| v [1/m]
    airborne: bool  # whether balls may leave the cloth
    gravity: float  # [m/s^2]
    table_restitution: float
    roll_quadratic: float  # b in a rolling friction mu g + b v^2, besides the air [1/m]
    outer: int  # first row of `obstacles` that is outside the frame; so are all rows after it
    frame_x: float  # the frame is the rectangle from (0, 0) to here [m]; cushions lie on its sides
    frame_y: float
    compliant: bool  # whether impacts last: see `impacts.compliant`
    contact_modulus: float  # E* of Hertz's law for two balls [Pa]
    contact_loss: float  # beta of `impacts.hertz`
    # Bodies that balls bounce off or fall into; `running.obstacle_rows` makes the rows. Python sees
    # a matrix (k, OBSTACLE_COLUMNS), kernels see k records `ObstacleRow`.
    obstacles: Any


TAKES_OUT = -1.0
"""Stands in place of a law: a ball whose centre enters the obstacle leaves the run."""

# Values of `ObstacleRow.kind`.
LINE = 0.0
SEGMENT = 1.0
DISC = 2.0


class Pairs(NamedTuple):
    """Lower bounds on contact times of pairs, a dense matrix; see `scheduling.all_pairs`."""

    bound: FloatArray  # (n n,) [s], row by row: a pair is in the row of the ball recomputed last
    least: FloatArray  # (n,) smallest bound of the row
    next: FloatArray  # (n,) the earlier of `least` and the ball's own next event
    track: FloatArray  # copies of the numbers that bounds need: see `TRACKS`


# For each block of TRACK_BALLS balls, `Pairs.track` holds TRACKS rows of TRACK_BALLS numbers. The
# constant distances show the compiler that the rows don't overlap, so that it can vectorise.
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
    """The cloth divided into cells, and the earliest bound of every ball with its neighbours.

    See `scheduling.broad_phase`, `scheduling.grid` and `scheduling.priority_queue`. Numbers of
    balls and cells have 32 bits, because memory limits the largest scenes. Numbers of a ball that
    are used together are in one row.
    """

    frame: FloatArray  # (6,) x and y of the first cell's corner, side of a cell, largest diameter
    # [m]; TIED_AT: a time [s]; TIED_KIND: the smallest kind of own events at that time, as far as
    # known. Code that sets a ball's own event marks the ball, so that `broad_phase.update` sees it.
    size: IntArray  # (2,) columns, rows; without the border
    first: Int32Array  # ((columns + 2) (rows + 2),) a ball in the cell, or NOWHERE
    link: Int32Array  # (n, 8): columns AFTER ... STAMP
    slot: FloatArray  # (n, 3): columns LEAVES ... SECOND_BOUND
    tree: FloatArray  # (2 p,) p >= n, a power of 2: leaves p + i are the next times of balls [s]


# Columns of `Cells.frame`, after the lengths.
TIED_AT = 4
TIED_KIND = 5

# Columns of `Cells.link`.
AFTER = 0  # the next ball in the same cell, or NOWHERE
BEFORE = 1  # the previous ball in the cell
CELL_COLUMN = 2  # of the ball's cell, from 1 on; 0 before the run starts
CELL_ROW = 3
LEAVES_BY = 4  # the side: 0 ... 3 is left, right, down, up; NOWHERE: LEAVES is only a bound
SLOT_PARTNER = 5  # the other ball of the earliest bound; NOWHERE: no longer known
PARTNER_STAMP = 6  # STAMP of that ball when the bound was computed
STAMP = 7  # how often the ball's motion has changed
LINK_COLUMNS = 8

# Columns of `Cells.slot`.
LEAVES = 0  # time at which the ball leaves its cell [s]
LEAST = 1  # its earliest bound [s]
SECOND_BOUND = 2  # earliest bound [s] of its pairs, except SLOT_PARTNER and those in other slots
SLOT_COLUMNS = 3


class Contacts(NamedTuple):
    """Contacts that act together: simultaneous impacts, and islands of resting contact.

    See `impacts.simultaneous`, `resting_contact.step`, `resting_contact.islands` and
    `impacts.contact_solver`; m is enough for all pairs that can touch at once, and for as many
    obstacles at each ball as a table has cushions. Nothing grows with the square of n.
    """

    island: IntArray  # (n,) label of the ball's island, or FREE
    ring: IntArray  # (n,) the next member of the ball's island, in a cycle
    again: BoolArray  # (n,) whether the ball's island starts a new step
    waiting: IntArray  # (n + 1,) the number of balls in `again`, then their indices
    stopped: BoolArray  # (n,) whether the start of a contact step stopped the ball
    rolled: BoolArray  # (n,) whether the start of a contact step ended the ball's slide
    member: IntArray  # (n,) balls of the current island
    first_held: IntArray  # (n,) the ball's first row of `held`, or NOWHERE
    held: IntArray  # (2 m, 2) PARTNER: ball that a contact step holds; NEXT row, or NOWHERE
    free: IntArray  # (2 m + 1,) the number of free rows of `held`, then their indices
    motion: Sequence[MemberRow]  # (n,)
    paths: FloatArray  # (n, 2, 6) coefficients of x and y [m]; the unit of time: the whole motion
    spins: FloatArray  # (n, 3, 4) coefficients of the angular velocity [rad/s]
    ends: IntArray  # (m, 2) FIRST: a ball; SECOND: a ball, or -1 minus a row of `Laws.obstacles`
    forces: Sequence[ContactRow]  # (m,)
    columns: FloatArray  # (m, CONTACT_COLUMNS) the same memory as `forces`
    history: FloatArray  # (m, REMEMBERED + 1, PER_ROUND) forces in the last rounds
    matrix: FloatArray  # (MOST_DIRECT, MOST_DIRECT) scratch for the equations of the contacts
    compliances: Sequence[
        ComplianceRow
    ]  # (2 MOST_DIRECT,) for the first ball of each contact, and the second
    stage: Sequence[StageRow]  # (MOST_DIRECT,)
    numbers: FloatArray  # (MOST_DIRECT, STAGE_COLUMNS) the same memory as `stage`
    start: FloatArray  # (MOST_DIRECT, NUMBERS) the state at the start of the step
    slopes: FloatArray  # (MOST_DIRECT, STAGES, NUMBERS) its rate of change at each stage
    turns: IntArray  # (1,) loop iterations, in the units of WORK, that WORK doesn't contain yet
    compressed: FloatArray  # (n, COMPRESSED_COLUMNS) balls of clusters: `impacts.lasting_contacts`


COMPRESSED_COLUMNS = 51

NOWHERE = -1

# Columns of `Contacts.held`.
PARTNER = 0
NEXT = 1

MOST_OBSTACLES = 53
"""Largest number of rows of `Laws.obstacles`: `held_off` has one bit of a double for each."""

MOST_DIRECT = 12
"""Largest number of contacts whose equations are solved directly."""

# Columns of `Contacts.ends` and `Balls.touching`.
FIRST = 0
SECOND = 1


class Log(NamedTuple):
    """Recorded run: m events, and k motions of balls just after their motion changed.

    m may be 0. If a log is full, the run continues with an empty log and the same `clock` and
    `counters`.
    """

    clock: FloatArray  # (CLOCKS + n,)
    counters: IntArray  # (COUNTERS + OUTCOMES n,)
    time: FloatArray  # (m,) [s]
    what: IntArray  # (3, m): rows WHAT_KIND (EventKind), WHAT_A, WHAT_B
    ball: IntArray  # (k,)
    # (k, SEGMENT_COLUMNS ...): the first columns of `Balls.state`; RISE, UP_SPEED and FALL; and
    # those of `Balls.powers` from POWERS on.
    motion: FloatArray


class World(NamedTuple):
    """All arrays of a run.

    The scheduler works with either `pairs` or `cells`; the arrays of the other are empty. In the
    lean kernel, `powers`, `series` and `height` of `balls` are None, and the compiler leaves out
    the code after `x is not None`. In the full kernel, laws such as `airborne` and `air_drag`
    decide at run time.
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


# Indices of the array of counters, int64.
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
NOT_FINITE = 12  # for RUN_NOT_FINITE: the ball with it, or FREE if there is no such ball
NO_ROOM = 13  # 1: `Balls.touching` or `Contacts` is too small for the balls that touch at once
BALLS_GONE = 14
CONTACT_PIECES = 15
WORK = 16  # iterations of all loops, in units of about 6 ns; bounded, so that every run ends
PAUSE_AT = 17  # WORK at which the kernel returns to Python, which then handles interrupts
STATUS = 18  # RUN_RESTED ...: the last return value of the loop
AT_ONCE = 19  # events within `ONE_INSTANT` of STOOD_SINCE: see `event_loop.loop`
ALOFT = 20  # balls that lie still on others
ENDLESS = 21  # for RUN_ENDLESS: 1 plus the ball with it
CLUSTERS = 22  # clusters of balls that push each other: see `event_loop.compression`
CLUSTER_LEGS = 23
COUNTERS = 24

# Outcomes of ball i: the counters from COUNTERS + OUTCOMES * i on; all are 0 at the start.
CUSHIONS = 0  # cushion collisions
FIRST_CONTACT = 1  # 1 plus the first ball that it hits; 0: none
CUSHIONS_BEFORE = 2  # cushion collisions before FIRST_CONTACT
EXIT = 3  # 1 plus the index of the pocket that it fell into; -1: it left the table; 0: neither
OUTCOMES = 4

# Indices of the array of times, float64 [s].
NOW = 0
LAST_EVENT = 1
END = 2  # when the last ball came to rest, or the run stopped
FARTHEST = 3  # largest coordinate of a ball at the end [m]
STOOD_SINCE = 4  # time from which AT_ONCE counts events
CLOCKS = 5  # then for each ball the time of its EXIT

OWN_LEG = -1  # a leg of a cluster of balls that push each other ends; the ball's PHASE is GONE
OWN_NONE = 0
OWN_REST = 1
OWN_ROLL = 2  # a slide ends
OWN_CONTACT = 3  # a contact step ends
OWN_PIECE = 4  # a piece ends, and another one starts
OWN_LAND = 5  # a flying ball lands on the cloth
OWN_BOUNCES_END = 6  # the bounces that are too low to be followed end
OWN_CUSHION = 7  # plus a row of `Laws.obstacles`: a ball reaches this obstacle of any kind
FIRST_HOLE = 2**17  # plus the index of a pocket: the number in the event of a ball flying over it
OWN_OVER = 2**32  # plus a row (above all rows): a ball flies over an obstacle, off the table

FREE = -1

# Return values of the loop, which never raises.
RUN_CONTINUES = -1
RUN_RESTED = 0
RUN_T_MAX = 1
RUN_EVENT_LIMIT = 2
RUN_LOG_FULL = 3
RUN_NOT_FINITE = 4
RUN_NO_ROOM = 5
RUN_PAUSED = 6  # it continues when called again
RUN_WORK_LIMIT = 7
RUN_STANDSTILL = 8  # endless events within `ONE_INSTANT`
RUN_ENDLESS = 9  # a ball that lies on other balls bounces endlessly
