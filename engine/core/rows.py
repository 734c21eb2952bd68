"""Rows of named numbers: one place where each field is named, with its unit.

Kernels see them as records, `rows[k].field`; their columns in the memory are in the order in which
the fields are listed here. Where something goes over the numbers of a row one after the other, it
sees the same memory as a matrix, and `column_of` says where in it a field is.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


class Row:
    """Numbers of one row of a matrix, by name.

    Compiled kernels see a record instead; this is what interpreted ones see, since numpy's records
    have no fields as attributes.
    """

    __slots__ = ("_numbers",)

    def __init__(self, numbers: NDArray[np.float64]) -> None:
        self._numbers: Any = memoryview(numbers.data)  # twice as fast to read as the array

    def __init_subclass__(cls) -> None:
        """Make each field that the class lists read and write its place in the row."""
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
    """Return at which place in such a row a field is."""
    return list(row.__annotations__).index(field)


def dtype_of(row: type[Row], columns: int = 0) -> Any:
    """Return the type of such a row as a record, padded to a number of columns."""
    fields = list(row.__annotations__)
    fields += [f"padding_{k}" for k in range(columns - len(fields))]
    return np.dtype([(name, np.float64) for name in fields])


def rows_of(matrix: NDArray[np.float64], row: type[Row]) -> list[Any]:
    """Return a matrix as rows with fields, in the same memory.

    For interpreted kernels; compiled ones take `matrix.view(BALL)[:, 0]`.
    """
    return [row(numbers) for numbers in matrix]


class BallRow(Row):
    """One ball; the first SEGMENT_COLUMNS of its numbers say how it moves from `epoch` on."""

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
    moved: float  # 1: the ball has moved, by more than very slow motion, since it last came to rest
    fastest: float  # largest size of its velocity at `epoch`, before impulses of then [m/s]
    impacts: float  # since the ball last moved for longer than `ONE_INSTANT`


STATE_COLUMNS = 24
"""Columns of `Balls.state`: whole cache lines."""

BALL = dtype_of(BallRow, STATE_COLUMNS)


class ObstacleRow(Row):
    """What stands still on the table: a line, a segment or a disc."""

    kind: float  # LINE, SEGMENT or DISC
    x: float  # a point of the line, an end of the segment, the disc's centre [m]
    y: float
    nx: float  # the line's unit normal into the table; the segment's other end [m]; of a disc that
    ny: float  # balls reach from one side alone, such as a jaw, the unit normal there, else 0
    radius: float  # of the disc, or of the nose around a segment [m]
    law: float  # the place of its law in `impact_laws.CUSHION_LAWS`, or TAKES_OUT
    index: float  # what events call it, see `model.scene.obstacles`
    turns: float  # 1: its law turns balls; see `impact_laws.LawEntry`
    restitution: float  # e of e / (1 + c sqrt(v)), v the speed of the approach
    loss: float  # c of that [sqrt(s/m)]
    tangential: float  # factor on the velocity along it
    friction: float
    height: float  # of its nose above the cloth [m]


OBSTACLE = dtype_of(ObstacleRow)
OBSTACLE_COLUMNS = len(OBSTACLE)


class _ContactRow(Row):
    """A row whose numbers are numpy's: a quotient by 0 is infinite, as in compiled kernels."""

    def __init__(self, numbers: NDArray[np.float64]) -> None:
        super().__init__(numbers)
        self._numbers = numbers


class MemberRow(_ContactRow):
    """What is known of a ball that is in contact with others."""

    step: float  # length that was good for its last contact step [s]; 0: none since a collision
    degree: float  # contacts that it has in the impact at hand, else 0
    slips: float  # 1: it slides over the contact step
    load_x: float  # contact force on it [N]
    load_y: float
    twist_x: float  # contact friction that turns it [N]; 5 / (2 m R) times it turns
    twist_y: float
    twist_z: float
    new_ax: float  # its acceleration [m/s^2]
    new_ay: float
    new_bx: float  # its angular acceleration [rad/s^2]
    new_by: float
    compliance: float  # its acceleration over a force on it [1/kg]; 0: the cloth holds it
    overlaps: float  # 1: it overlaps another by most of the tolerance
    effective_mass: float  # with which it responds to an impulse [kg]; inf: it stays
    impulse_x: float  # what impulses on it add up to [N s], or forces [N]: the sum of two parts
    impulse_y: float
    small_x: float  # the second part
    small_y: float
    index: float  # its index in `Contacts.member`
    pieces_left: float  # of the motion in `Contacts.paths`, which an island has found for it
    piece_time: float  # how long each is [s]
    whole_time: float  # how long the whole motion is [s]
    held_off: float  # obstacles that it is held off, one bit each: see MOST_OBSTACLES
    pieces: float  # of the whole motion
    ahead: float  # how long the next whole motion may be [s]


MEMBER = dtype_of(MemberRow)
MEMBER_COLUMNS = len(MEMBER)


class ContactRow(_ContactRow):
    """One contact of an island, or of impacts at one instant."""

    force: float  # along the normal, never negative: an impulse [N s] or a force [N]
    nx: float  # normal, away from the first ball
    ny: float
    rate: float  # of the gap [m/s]
    push_x: float  # friction of an impact, on the second ball; its opposite on the first
    push_y: float
    turn_x: float  # what turns both balls: an impulse, or a part of the force in `rates`
    turn_y: float
    turn_z: float
    along: float  # friction of a contact that lasts: along t = (-ny, nx), and up
    up: float
    active: float  # 1: a contact that pushes, while `impacts.contact_solver` is at work
    residual: float  # and what that keeps of each contact
    scaled: float
    direction: float
    product: float
    term: float
    own_mass: float
    force_before: float  # the force of the sweep before [N]
    kept_force: float  # that of a contact which moves no ball
    force_change: float  # by how much the last round changed `force`, `along` and `up` [N]
    along_change: float
    up_change: float
    coulomb_limit: float  # by Coulomb's law [N]
    gap: float  # at the start of the step [m]


CONTACT = dtype_of(ContactRow)
CONTACT_COLUMNS = len(CONTACT)

REMEMBERED = 4
"""Rounds before the last that `resting_contact.extrapolation` looks at. With two or three it takes
a third and a tenth more rounds; with six or eight, more as well: forces that begin or end to push
meanwhile spoil what is older."""

PER_ROUND = 6
"""What is remembered of a round: the three forces of a contact after it, and by how much it changed
them."""


class StageRow(_ContactRow):
    """One ball's state at a stage of an integration; the first NUMBERS are integrated."""

    x: float  # [m]
    y: float
    vx: float  # [m/s]
    vy: float
    wx: float  # [rad/s]
    wy: float
    wz: float
    ax: float  # and how fast that changes
    ay: float
    bx: float
    by: float
    bz: float
    displacement_x: float  # in the step so far [m]: its place less that of before would round
    displacement_y: float
    hold_x: float  # what the cloth does so that it continues rolling [m/s^2]
    hold_y: float
    sense: float  # 1 or -1: that of its spin about the vertical, which the cloth slows; 0: held
    twist: float  # how fast contacts alone change that spin [rad/s^2]
    twist_from: float  # the same at the start of the step
    is_still: float  # 1: it rests, and the cloth holds it


STAGE = dtype_of(StageRow)
STAGE_COLUMNS = len(STAGE)

NUMBERS = 7
"""Numbers of a ball's state that are integrated: place, velocity, angular velocity."""

STAGES = 7
"""Stages of a step of the integration."""


class ComplianceRow(_ContactRow):
    """How a force of 1 at a contact accelerates one of its balls."""

    x: float  # [1/kg]
    y: float
    hold_x: float  # and what of it is the cloth's
    hold_y: float


COMPLIANCE = dtype_of(ComplianceRow)
COMPLIANCE_COLUMNS = len(COMPLIANCE)
