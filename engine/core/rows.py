"""Rows of numbers with names: this module defines each field once, with its unit.

Kernels see rows as records, `rows[k].field`. In memory the columns are in the order in which the
fields are listed here. Code that loops over the numbers of a row sees the same memory as a matrix;
`column_of` gives the column of a field.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


class Row:
    """The numbers of one row of a matrix, by name.

    Interpreted kernels use this class, because the fields of numpy's records are not attributes.
    Compiled kernels see a record instead.
    """

    __slots__ = ("_numbers",)

    def __init__(self, numbers: NDArray[np.float64]) -> None:
        self._numbers: Any = memoryview(numbers.data)  # twice as fast to read as the array

    def __init_subclass__(cls) -> None:
        """Make each listed field a property that reads and writes its number in the row."""
        for column, name in enumerate(cls.__annotations__):
            setattr(cls, name, _field(column))


def _field(column: int) -> property:
    def number(row: Row) -> float:
        value: float = row._numbers[column]
        return value

    def put(row: Row, value: float) -> None:
        row._numbers[column] = value

    return property(number, put)


def column_of(row: type[Row], field: str) -> int:
    """Return the column of a field in a row."""
    return list(row.__annotations__).index(field)


def dtype_of(row: type[Row], columns: int = 0) -> Any:
    """Return the numpy type of a row as a record, padded to a number of columns."""
    fields = list(row.__annotations__)
    fields += [f"padding_{k}" for k in range(columns - len(fields))]
    return np.dtype([(name, np.float64) for name in fields])


def rows_of(matrix: NDArray[np.float64], row: type[Row]) -> list[Any]:
    """Return the rows of a matrix as objects with fields, which share its memory.

    For interpreted kernels; compiled kernels take `matrix.view(BALL)[:, 0]`.
    """
    return [row(numbers) for numbers in matrix]


class BallRow(Row):
    """One ball; the first SEGMENT_COLUMNS numbers describe its motion from `epoch` on."""

    epoch: float  # [s]
    x: float  # [m]
    y: float
    vx: float  # [m/s]
    vy: float
    ax: float  # [m/s^2]
    ay: float
    wx: float  # angular velocity [rad/s]; only used if the ball slides or flies
    wy: float
    wz: float  # always used
    bx: float  # angular acceleration [rad/s^2], as wx and wy
    by: float
    bz: float  # added to the decay of wz during a contact step
    phase: float  # RESTING, SLIDING, ROLLING, GONE or FLYING
    own_time: float  # time of the next event without a second ball [s]; inf: none
    radius: float  # [m]
    mass: float  # [kg]
    roll_slowing: float  # deceleration while rolling [m/s^2]
    slide_slowing: float  # deceleration while sliding [m/s^2]; 0 if `motion` is "rolling"
    spin_slowing: float  # deceleration of the spin about the vertical [rad/s^2]
    cloth_friction: float  # coefficient of sliding friction, for impacts with the cloth
    moved: float  # 1: it has moved since it last came to rest; very slow motion is ignored
    fastest: float  # largest size of its velocity at `epoch`, before the impulses then [m/s]
    impacts: float  # number of impacts since the ball last moved for longer than `ONE_INSTANT`


STATE_COLUMNS = 24
"""Columns of `Balls.state`; a row fills whole cache lines."""

BALL = dtype_of(BallRow, STATE_COLUMNS)


class ObstacleRow(Row):
    """An obstacle on the table that balls hit: a line, a segment or a disc."""

    kind: float  # LINE, SEGMENT or DISC
    x: float  # a point of the line, one end of the segment, or the centre of the disc [m]
    y: float
    nx: float  # line: unit normal into the table; segment: the other end [m]; disc: unit normal if
    ny: float  # balls reach it from one side only, for example a jaw, otherwise 0
    radius: float  # radius of the disc, or of the nose around a segment [m]
    law: float  # index of its law in `impact_laws.CUSHION_LAWS`, or TAKES_OUT
    index: float  # number in the recorded events, see `model.scene.obstacles`
    turns: float  # 1: its law changes the spin; see `impact_laws.LawEntry`
    restitution: float  # e in the restitution e / (1 + c sqrt(v)), v the approach speed
    loss: float  # c in that formula [sqrt(s/m)]
    tangential: float  # factor on the tangential velocity
    friction: float
    height: float  # height of its nose above the cloth [m]
    ratio: float  # frequency of the spring along the slip over the normal spring's; 0: it is rigid


OBSTACLE = dtype_of(ObstacleRow)
OBSTACLE_COLUMNS = len(OBSTACLE)


class _ContactRow(Row):
    """A row of numpy numbers: division by 0 gives infinity, as in compiled kernels."""

    def __init__(self, numbers: NDArray[np.float64]) -> None:
        super().__init__(numbers)
        self._numbers = numbers


class MemberRow(_ContactRow):
    """State of a ball that is in contact with other bodies."""

    step: float  # length of its last successful contact step [s]; 0: none since a collision
    degree: float  # number of its contacts in the current impact, otherwise 0
    slips: float  # 1: it slides during the contact step
    load_x: float  # contact force on it [N]
    load_y: float
    twist_x: float  # friction at its contacts [N]; times 5 / (2 m R): angular acceleration
    twist_y: float
    twist_z: float
    new_ax: float  # its acceleration [m/s^2]
    new_ay: float
    new_bx: float  # its angular acceleration [rad/s^2]
    new_by: float
    compliance: float  # acceleration per force on it [1/kg]; 0: the cloth holds it
    overlaps: float  # 1: it overlaps a ball or an obstacle by most of the tolerance
    effective_mass: float  # mass with which it responds to an impulse [kg]; inf: it doesn't move
    impulse_x: float  # large part of the sum of impulses [N s], or of forces [N], on it
    impulse_y: float
    small_x: float  # small part of the sum, which rounding would lose in the large part
    small_y: float
    index: float  # its index in `Contacts.member`
    pieces_left: float  # remaining pieces of its motion in `Contacts.paths`
    piece_time: float  # duration of each piece [s]
    whole_time: float  # duration of the whole motion [s]
    held_off: float  # obstacles that a contact step keeps it off, one bit each: MOST_OBSTACLES
    pieces: float  # number of pieces of the whole motion
    ahead: float  # longest duration of the next whole motion [s]


MEMBER = dtype_of(MemberRow)
MEMBER_COLUMNS = len(MEMBER)


class ContactRow(_ContactRow):
    """One contact of an island, or of simultaneous impacts."""

    force: float  # along the normal, never negative: an impulse [N s] or a force [N]
    nx: float  # normal, away from the first ball
    ny: float
    rate: float  # rate of change of the gap [m/s]
    push_x: float  # friction of an impact on the second ball; the opposite acts on the first
    push_y: float
    turn_x: float  # impulse that turns both balls; in `resting_contact.rates`, a force
    turn_y: float
    turn_z: float
    along: float  # friction of a resting contact, along t = (-ny, nx), and up
    up: float
    active: float  # 1: a contact that pushes; used by `impacts.contact_solver`
    residual: float  # this and the next five numbers: scratch of `impacts.contact_solver`
    scaled: float
    direction: float
    product: float
    term: float
    own_mass: float
    force_before: float  # the force in the previous round [N]
    kept_force: float  # force of a contact that moves no ball
    force_change: float  # changes of `force`, `along` and `up` in the last round [N]
    along_change: float
    up_change: float
    coulomb_limit: float  # largest friction by Coulomb's law [N]
    gap: float  # at the start of the step [m]


CONTACT = dtype_of(ContactRow)
CONTACT_COLUMNS = len(CONTACT)

REMEMBERED = 4
"""Rounds before the last one that `resting_contact.extrapolation` uses.

With two, a third more rounds are needed, and with three, a tenth. Six or eight need more rounds,
too: contacts that start or stop to push in between make older rounds useless.
"""

PER_ROUND = 6
"""Numbers stored per round and contact: the three forces after the round, and their changes."""


class StageRow(_ContactRow):
    """State of one ball at a stage of an integration; the first NUMBERS are integrated."""

    x: float  # [m]
    y: float
    vx: float  # [m/s]
    vy: float
    wx: float  # [rad/s]
    wy: float
    wz: float
    ax: float  # rates of change of the velocity and of the angular velocity
    ay: float
    bx: float
    by: float
    bz: float
    displacement_x: float  # in the step so far [m]; a difference of positions would be rounded
    displacement_y: float
    hold_x: float  # acceleration by the cloth that keeps it rolling [m/s^2]
    hold_y: float
    sense: float  # sign of its vertical spin, which the cloth slows: 1 or -1; 0: spin held at 0
    twist: float  # rate of change of that spin by contacts alone [rad/s^2]
    twist_from: float  # the spin at the start of the step
    is_still: float  # 1: it rests, and the cloth holds it


STAGE = dtype_of(StageRow)
STAGE_COLUMNS = len(STAGE)

NUMBERS = 7
"""Numbers of a ball's state that are integrated: position, velocity, angular velocity."""

STAGES = 7
"""Stages of one step of the integration."""


class ComplianceRow(_ContactRow):
    """Acceleration of one of the two balls of a contact by a force of 1 at the contact."""

    x: float  # [1/kg]
    y: float
    hold_x: float  # the part of it that the cloth causes
    hold_y: float


COMPLIANCE = dtype_of(ComplianceRow)
COMPLIANCE_COLUMNS = len(COMPLIANCE)
