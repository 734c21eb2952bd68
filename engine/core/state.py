"""The arrays that the kernels work on, by role; `running.from_scene` makes them from a scene.

`Balls`, the `Laws` with the obstacles, what each scheduler keeps (`Pairs`, `Cells`), `Contacts`
that act together, and the `Log`; each followed by the names of its columns and of their values.

Named tuples of arrays, because numba can neither cache jitclasses nor keep views of a row cheap.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Int32Array = NDArray[np.int32]
BoolArray = NDArray[np.bool_]


class Balls(NamedTuple):
    """State of n balls, each at its own epoch; and what the event at hand does to them.

    The centre moves as x + vx s + ax s^2 / 2, s the time since `epoch`, and what `higher` adds,
    until `own_time`, when the ball's own next event changes its motion. While it slides, its
    angular velocity changes at a constant rate, but for what `air` adds; while it rolls, the
    velocity gives it; about the vertical the cloth takes from it. In flight it stays as it is.
    m is enough for all pairs that can touch at once, and one cushion.

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
    hits: Int32Array  # (m, 2) as `Contacts.ends`: the pairs that hit now, or contacts to be held
    near: Int32Array  # (n,) room for a ball's neighbours
    counters: IntArray  # (COUNTERS,) those of the `Log`: every loop counts its turns in WORK
    higher: FloatArray | None  # (n, HIGHER + 2 k): what pieces of a degree above 2 have beyond it
    air: Air | None  # what else is needed where something slows balls by more the faster they are
    height: FloatArray | None  # (n, HEIGHT_COLUMNS): columns BASE ... below, where balls may fly


# Columns of `Balls.higher`: first how fast the acceleration may change along x and along y [m/s^3],
# as long as the piece lasts, which then has an end; how many of the powers that follow aren't 0.
# From HIGHER on, for x and for y, what goes with the third power of the time since `epoch` [m/s^3],
# with the fourth, and so on.
POWERS = 2
HIGHER = 3


class Air(NamedTuple):
    """Room for motions whose deceleration depends on the speed; see `motion.drag`."""

    turning: FloatArray  # (n, 2 k): what goes in wx, wy with the second power of the time [rad/s^3]
    series: FloatArray  # (SERIES_ROWS, SERIES_TERMS) the power series of the piece at hand


# Columns of `Balls.height`.
BASE = 0  # height of its centre where it lies on the cloth [m]; 0 where no ball may leave that
RISE = 1  # of a ball's lowest point above the cloth, at `epoch` [m]
UP_SPEED = 2  # its velocity upwards then [m/s]
FALL = 3  # and its acceleration downwards [m/s^2]; 0 on the cloth
LASTS = 4  # how long bounces that are too low to be followed take [s]; 0: there are none
END_VX = 5  # with which velocity [m/s] and angular velocity [rad/s] the ball goes on
END_VY = 6
END_WX = 7
END_WY = 8
HOPS = 9  # its slow impacts in flight since it last came down on the cloth
HELD = 10  # 1: it lies still on others, and is held there
STILL_X = 11  # where it has been for some time [m], within a tolerance
STILL_Y = 12
STILL_RISE = 13
STILL_SINCE = 14  # and since when [s]
LOADED = 15  # until when it counts as pressed by a ball that hops on it [s]
HEIGHT_COLUMNS = 16

SERIES_TERMS = 25
SERIES_ROWS = 8
MOST_POWERS = 2 * 23
"""Columns of `Air.turning`, and of the powers of `Balls.higher` there."""


class _Row:
    """Numbers of one row of a matrix, by name.

    Compiled kernels see a record instead; this is what interpreted ones see, since numpy's records
    have no fields as attributes.
    """

    __slots__ = ("_numbers",)

    def __init__(self, numbers: FloatArray) -> None:
        self._numbers: Any = memoryview(numbers.data)

    def __init_subclass__(cls) -> None:
        """Make each field that the class lists read and write its place in the row."""
        for column, name in enumerate(cls.__annotations__):
            setattr(cls, name, _field(column))


def _field(column: int) -> property:
    def number(row: _Row) -> float:
        value: float = row._numbers[column]
        return value

    def put(row: _Row, value: float) -> None:
        row._numbers[column] = value

    return property(number, put)


class BallRow(_Row):
    """One ball's numbers, by name; the first KNOT of them say how it moves from `epoch` on."""

    epoch: float  # [s]
    x: float  # [m]
    y: float
    vx: float  # [m/s]
    vy: float
    ax: float  # [m/s^2]
    ay: float
    wx: float  # angular velocity [rad/s]; of no meaning for a ball that rolls or rests
    wy: float
    wz: float  # this one always
    bx: float  # angular acceleration [rad/s^2], as wx and wy
    by: float
    bz: float  # what a contact step adds to the decay of wz
    phase: float  # RESTING, SLIDING, ROLLING, GONE or FLYING
    own_time: float  # next event that needs no second ball [s]; inf: none
    radius: float  # [m]
    mass: float  # [kg]
    roll_slowing: float  # deceleration while rolling [m/s^2]
    slide_slowing: float  # deceleration while sliding [m/s^2]; 0 where `motion` is "rolling"
    spin_slowing: float  # deceleration of the spin about the vertical [rad/s^2]
    cloth_friction: float  # coefficient of sliding friction, for impacts with the cloth
    moved: float  # 1: the ball has moved, by more than creeping, since it last came to rest


BALL_FIELDS = tuple(BallRow.__annotations__)
STATE_COLUMNS = 24  # whole cache lines: the last two are padding
_PADDING = tuple(f"padding_{k}" for k in range(STATE_COLUMNS - len(BALL_FIELDS)))
BALL = np.dtype([(name, np.float64) for name in BALL_FIELDS + _PADDING])


class ObstacleRow(_Row):
    """What stands still on the table: a line, a segment or a disc."""

    kind: float  # LINE, SEGMENT or DISC
    x: float  # a point of the line, an end of the segment, the disc's centre [m]
    y: float
    nx: float  # the line's unit normal into the table; the segment's other end [m]
    ny: float
    radius: float  # of the disc, or of the nose around a segment [m]
    law: float  # the place of its law in `impact_laws.CUSHION_LAWS`, or TAKES_OUT
    index: float  # what events call it: a cushion's in `model.scene.CUSHIONS`, or one above those


OBSTACLE_COLUMNS = len(ObstacleRow.__annotations__)
OBSTACLE = np.dtype([(name, np.float64) for name in ObstacleRow.__annotations__])


def rows_of(matrix: FloatArray, row: type[_Row]) -> list[_Row]:
    """Return a matrix as rows with fields, in the same memory.

    For interpreted kernels; compiled ones take `matrix.view(BALL)[:, 0]`.
    """
    return [row(numbers) for numbers in matrix]


# The same as columns: of `Balls.state` as Python sees it, and of a motion's knots.
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
KNOT = 14
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
    """Constants of the scene.

    `integrated` decides at compile time what the kernels contain: where it is None, the laws that
    integrate over the impact are left out, which take a third of the time to compile.
    """

    slides: bool  # whether spin is a state of its own (else balls always roll)
    uniform: bool  # whether no ball is ever slowed, so that all move uniformly between events
    rubs: bool  # whether a ball's surface rubs on another's
    simultaneous: bool  # whether impacts at one instant are resolved together
    ball_law: int  # its place in `impact_laws.BALL_LAWS`
    ball_restitution: float
    ball_friction: float
    speed_dependent: bool  # whether Alciatore's curve stands for `ball_friction`
    cushion_turns: bool  # whether the law of the cushions turns balls: see `impact_laws.LawEntry`
    cushion_restitution: float
    cushion_tangential: float
    cushion_friction: float
    cushion_height: float  # of the nose above the cloth [m]
    t_max: float  # [s]; inf: until rest
    air_drag: float  # k in a = -k |v| v [1/m]
    airborne: bool  # whether balls may leave the cloth
    gravity: float  # [m/s^2]
    table_restitution: float
    roll_quadratic: float  # b of a rolling friction mu g + b v^2, beside the air [1/m]
    # What balls bounce off, or are taken out by; `running.from_scene.obstacles_of` lists it. Python
    # sees a matrix (k, OBSTACLE_COLUMNS), kernels (k,) of `ObstacleRow`.
    obstacles: Any
    integrated: int | None  # 1 where a law needs integrating: see `impacts.laws.dispatch`


TAKES_OUT = -1.0
"""In place of a law: a ball that touches the obstacle leaves the run."""

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


# `Pairs.track` holds, for each block of LANES balls, TRACKS rows of LANES numbers: constant
# distances, from which the compiler sees that rows don't overlap, and that it may vectorise.
LANES = 64
TRACKS = 10
TRACK_X = 0 * LANES
TRACK_Y = 1 * LANES
TRACK_VX = 2 * LANES
TRACK_VY = 3 * LANES
TRACK_AX = 4 * LANES
TRACK_AY = 5 * LANES
TRACK_EPOCH = 6 * LANES
TRACK_RADIUS = 7 * LANES
TRACK_OWN_TIME = 8 * LANES
TRACK_JERK = 9 * LANES


class Cells(NamedTuple):
    """The cloth in cells, and the earliest bound of every ball with its neighbours.

    See `scheduling.broad_phase`, `scheduling.grid` and `scheduling.priority_queue`. Balls and cells
    have numbers of 32 bits: memory is what limits the largest scenes. What is used of a ball at
    one time is in one row.
    """

    frame: FloatArray  # (4,) the first cell's corner, x and y, a cell's side, largest diameter [m]
    size: IntArray  # (2,) columns, rows; without the border
    first: Int32Array  # ((columns + 2) (rows + 2),) a ball in the cell, or NOWHERE
    link: Int32Array  # (n, 8): columns AFTER ... STAMP below
    slot: FloatArray  # (n, 3): columns LEAVES ... SECOND_BOUND below
    tree: FloatArray  # (2 p,) p >= n, a power of 2: leaves p + i are the balls' next instants [s]


# Columns of `Cells.link`.
AFTER = 0  # the next ball in the same cell, or NOWHERE
BEFORE = 1  # the one before
COLUMN = 2  # of the ball's cell, from 1 on; 0 before the run begins
ROW = 3
WAY = 4  # on which side it will leave: 0 ... 3 is left, right, down, up; NOWHERE: look again then
MATE = 5  # the other ball of the earliest bound; NOWHERE: not known any more
MATE_STAMP = 6  # and its stamp then
STAMP = 7  # how often the ball's motion has changed
LINK_COLUMNS = 8

# Columns of `Cells.slot`.
LEAVES = 0  # when the ball leaves its cell [s]
LEAST = 1  # its earliest bound [s]
SECOND_BOUND = 2  # [s] lower bound of all its pairs but that with MATE and those in others' slots
SLOT_COLUMNS = 3


class Contacts(NamedTuple):
    """Contacts that act together: impacts of one instant, and clusters of balls that are pressed.

    See `impacts.simultaneous`, `resting_contact.step`, `resting_contact.islands` and
    `impacts.contact_solver`; m is enough for all pairs that can touch at once, and for as many
    obstacles at each ball as a table has cushions. Nothing grows with the square of n.
    """

    cluster: IntArray  # (n,) label of the ball's cluster, or FREE
    ring: IntArray  # (n,) the next member of the ball's cluster, round and round
    again: BoolArray  # (n,) whether the ball's cluster is to be pressed anew
    waiting: IntArray  # (n + 1,) how many of those there are, then which
    stopped: BoolArray  # (n,) whether a contact step's start stopped the ball
    rolled: BoolArray  # (n,) whether a contact step's start ended the ball's slide
    member: IntArray  # (n,) balls of the cluster at hand
    first_held: IntArray  # (n,) the ball's first row of `held`, or NOWHERE
    held: IntArray  # (2 m, 2) PARTNER, that a contact step holds the ball to; NEXT row, or NOWHERE
    free: IntArray  # (2 m + 1,) how many rows of `held` are free, then which
    motion: FloatArray  # (n, MOTION_COLUMNS): columns STEP ... below, by ball
    ends: IntArray  # (m, 2) FIRST: a ball; SECOND: another, or -1 minus a row of `Laws.obstacles`
    forces: FloatArray  # (m, FORCE_COLUMNS): columns FORCE ... below
    matrix: FloatArray  # (MOST_DIRECT, MOST_DIRECT) room for the contacts' equations
    stage: FloatArray  # (MOST_DIRECT, STAGE_COLUMNS): columns M_X ... below, by member or contact
    turns: IntArray  # (1,) of loops, weighed as WORK; not counted there yet


NOWHERE = -1

# Columns of `Contacts.held`.
PARTNER = 0
NEXT = 1

# Columns of `Contacts.motion`.
STEP = 0  # length that was good for the ball's last contact step [s]; 0: none since a collision
DEGREE = 1  # contacts that the ball has in the impact at hand, else 0
SLIPS = 2  # 1: a member slides over the contact step
LOAD_X = 3  # contact force on a member [N]
LOAD_Y = 4
TWIST_X = 5  # contact friction that turns a member [N]; 5 / (2 m R) times it turns
TWIST_Y = 6
TWIST_Z = 7
NEW_AX = 8  # acceleration of a member [m/s^2]
NEW_AY = 9
NEW_BX = 10  # angular acceleration of a member [rad/s^2]
NEW_BY = 11
YIELD = 12  # acceleration of a member over a force on it [1/kg]; 0: the cloth holds it
DEEP = 13  # 1: a member that overlaps another by most of the tolerance
ANSWERING = 14  # mass with which the ball answers to an impulse [kg]; inf: it stays
IMPULSE_X = 15  # what impulses on the ball add up to [N s], or forces [N]: the sum of two parts
IMPULSE_Y = 16
SMALL_X = 17  # the second part
SMALL_Y = 18
AT = 19  # its place in `Contacts.member`
LEFT = 20  # pieces that are left of the motion below, which an island has found for the ball
PIECE_TIME = 21  # how long each is [s]
WHOLE_TIME = 22  # how long the whole motion is [s]
PATH_X = 23  # coefficients of its x and y [m], six each, in units of the whole time
PATH_Y = 29
TURN_WX = 35  # and of its angular velocity [rad/s], four each
TURN_WY = 39
TURN_WZ = 43
HELD_OFF = 47  # obstacles that it is held off, one bit each: see MOST_OBSTACLES
PIECES = 48  # of the whole motion
AHEAD = 49  # how long the next whole motion may be [s]
MOTION_COLUMNS = 50

MOST_OBSTACLES = 53
"""Rows of `Laws.obstacles`: HELD_OFF keeps a bit of a double for each."""

MOST_DIRECT = 12
"""Contacts up to which their equations are solved directly."""

# Columns of `Contacts.stage`. Of member m:
M_X = 0  # its state at a stage of the integration [m], [m/s], [rad/s]
M_Y = 1
M_VX = 2
M_VY = 3
M_WX = 4
M_WY = 5
M_WZ = 6
M_AX = 7  # and how fast that changes
M_AY = 8
M_BX = 9
M_BY = 10
M_BZ = 11
M_HOLD_X = 12  # what the cloth does so that it goes on rolling [m/s^2]
M_HOLD_Y = 13
M_FROM = 14  # its seven numbers at the start of the step
M_SLOPE = 21  # and how fast they change, at each of seven stages
# Of contact c:
C_FIRST_X = 70  # acceleration that a force of 1 gives its first ball, x and y [1/kg]
C_FIRST_HOLD = 72  # and what of it is the cloth's
C_SECOND_X = 74
C_SECOND_HOLD = 76
C_TURN_X = 78  # what turns both, x and y [1]; 5 / (2 m R) times it turns a ball
C_TURN_Z = 80
M_SPIN = 81  # 1 or -1: the sense of its spin about the vertical, which the cloth slows; 0: held
M_TWIST = 82  # how fast contacts alone change that spin [rad/s^2]
M_TWIST_FROM = 83  # the same at the start of the step
M_STILL = 84  # 1: it rests, and the cloth holds it
M_WAY_X = 85  # how far it has come in the step [m]: its place less that of before would round
M_WAY_Y = 86
STAGE_COLUMNS = 87

# Columns of `Contacts.ends` and `Balls.hits`.
FIRST = 0
SECOND = 1

# Columns of `Contacts.forces`.
FORCE = 0  # along the normal, never negative: an impulse [N s] or a force [N]
NX = 1  # normal, away from the first ball
NY = 2
RATE = 3  # of the gap [m/s]
PUSH_X = 4  # friction of an impact, on the second ball; its opposite on the first
PUSH_Y = 5
TURN_X = 6  # on both
TURN_Y = 7
TURN_Z = 8
ALONG = 9  # friction of a pressed contact: along t = (-ny, nx), and up
UP = 10
ACTIVE = 11  # 1: a contact that pushes, while `impacts.contact_solver` is at work
LEFT_OVER = 12  # and what that keeps of each contact
SCALED = 13
DIRECTION = 14
PRODUCT = 15
TERM = 16
OWN_MASS = 17
FORCE_BEFORE = 18  # the force of the sweep before [N]
KEPT = 19  # that of a contact which moves no ball
MORE_FORCE = 20  # by how much the last round changed FORCE, ALONG and UP [N]
MORE_ALONG = 21
MORE_UP = 22
LIMIT = 23  # of its friction, by Coulomb's law [N]
GAP = 24  # at the start of the step [m]
HISTORY = 25  # forces after the last rounds, and their changes: see `resting_contact.extrapolation`
REMEMBERED = 4
"""Rounds before the last that `resting_contact.extrapolation` looks at. With two or three it takes
a third and a tenth more rounds; with six or eight, more as well: forces that begin or end to push
meanwhile spoil what is older."""
FORCE_COLUMNS = HISTORY + 6 * (REMEMBERED + 1)


def contacts_in(marks: BoolArray, places: IntArray, numbers: FloatArray) -> Contacts:
    """Return the `Contacts` whose arrays are parts of these three, quicker to hand over."""
    n = len(marks) // 3
    m = (len(places) - 5 * n - 3) // 8
    forces, direct = n * MOTION_COLUMNS, MOST_DIRECT * MOST_DIRECT
    matrix = forces + m * FORCE_COLUMNS
    held = 5 * n + 2 + 2 * m
    return Contacts(
        cluster=places[:n],
        ring=places[n : 2 * n],
        again=marks[:n],
        waiting=places[2 * n : 3 * n + 1],
        stopped=marks[n : 2 * n],
        rolled=marks[2 * n :],
        member=places[3 * n + 1 : 4 * n + 1],
        first_held=places[4 * n + 1 : 5 * n + 1],
        held=places[held : held + 4 * m].reshape(2 * m, 2),
        free=places[5 * n + 1 : held],
        motion=numbers[:forces].reshape(n, MOTION_COLUMNS),
        ends=places[held + 4 * m : held + 6 * m].reshape(m, 2),
        forces=numbers[forces:matrix].reshape(m, FORCE_COLUMNS),
        matrix=numbers[matrix : matrix + direct].reshape(MOST_DIRECT, MOST_DIRECT),
        stage=numbers[matrix + direct :].reshape(MOST_DIRECT, STAGE_COLUMNS),
        turns=places[held + 6 * m :],
    )


class Log(NamedTuple):
    """What happened: m events, and k balls whose motion changed, just after; m may be 0.

    `clock` and `counters` go on where a full log is followed by an empty one.
    """

    clock: FloatArray  # (CLOCKS,)
    counters: IntArray  # (COUNTERS,)
    time: FloatArray  # (m,) [s]
    what: IntArray  # (3, m): rows WHAT_KIND (EventKind), WHAT_A, WHAT_B
    ball: IntArray  # (k,)
    # (k, KNOT ...): the first columns of `Balls.state`; RISE, UP_SPEED and FALL; powers of
    # `higher`, and those of `turning`.
    motion: FloatArray


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
UNSOUND = 12  # of RUN_NOT_FINITE: the ball with it, or FREE where none is to blame
NO_ROOM = 13  # 1: more balls touch at once than `Balls.hits`, or `Contacts`, has room for
BALLS_GONE = 14
CONTACT_PIECES = 15
WORK = 16  # turns of all loops, in units of some 10 ns; what none may have without end
PAUSE_AT = 17  # WORK at which the kernel returns for a moment, so that Python hears an interrupt
STATUS = 18  # RUN_RESTED ... below: what the loop returned last
AT_ONCE = 19  # events since the clock last moved
ALOFT = 20  # balls that lie still on others
HOPPING = 21  # of RUN_HOPS: 1 and the ball with it
WAITS = 22  # 1: an event waits for `Contacts`; which one, the next four say, and WAITS_SINCE
WAITING_BALL = 23
WAITING_PAIRS = 24
WAITING_VERDICT = 25
WAITING_JUDGED = 26
COUNTERS = 27

# Places in the array of instants, float64 [s].
NOW = 0
LAST_EVENT = 1
END = 2  # when the last ball came to rest, or the run stopped
FARTHEST = 3  # largest coordinate of a ball at the end [m]
WAITS_SINCE = 4  # when the event is that waits for `Contacts`
CLOCKS = 5

OWN_NONE = 0
OWN_REST = 1
OWN_ROLL = 2  # a slide ends
OWN_CONTACT = 3  # a contact step ends
OWN_PIECE = 4  # a piece ends, and another one begins
OWN_LAND = 5  # a ball in flight comes down on the cloth
OWN_SETTLE = 6  # bounces that are too low to be followed end
OWN_CUSHION = 7  # + a row of `Laws.obstacles`: a ball meets that, be it a cushion or not
OWN_OVER = 2**32  # + a row, above all rows: a ball flies over an obstacle, and off the table

FREE = -1

# What the loop returns. It never raises.
RUN_GOES_ON = -1
RUN_RESTED = 0
RUN_T_MAX = 1
RUN_EVENT_LIMIT = 2
RUN_LOG_FULL = 3
RUN_NOT_FINITE = 4
RUN_CONTACTS = 5  # go on with `Contacts`, which the run was not given
RUN_NO_ROOM = 6
RUN_PAUSED = 7  # it goes on when called again
RUN_WORK_LIMIT = 8
RUN_STANDSTILL = 9  # events without end at one instant
RUN_HOPS = 10  # a ball that lies on others hops without end
