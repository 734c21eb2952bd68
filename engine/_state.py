"""The arrays that the kernels work on, grouped by role; allocated once, outside the kernels.

Named tuples of arrays, because numba can neither cache jitclasses nor keep views of a row cheap.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.scene import CUSHIONS, Scene

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


class Balls(NamedTuple):
    """State of n balls, each at its own epoch.

    The centre moves as x + vx s + ax s^2 / 2, s the time since `epoch`, until `own_time`, when the
    ball's own next event changes its motion.

    One array for all numbers, because a kernel call passes every array of a named tuple as seven
    words: with one array per number, the calls cost more than what they did.
    """

    state: FloatArray  # (10, n): rows X, Y ... MASS below
    own_kind: IntArray  # (n,) OWN_NONE, OWN_REST, OWN_CONTACT, or OWN_CUSHION + its index


# Rows of `Balls.state`.
X = 0  # [m]
Y = 1
VX = 2  # [m/s]
VY = 3
AX = 4  # [m/s^2]
AY = 5
EPOCH = 6  # [s]
OWN_TIME = 7  # next event that needs no second ball [s]; inf: none
RADIUS = 8  # [m]
MASS = 9  # [kg]


class Laws(NamedTuple):
    """Constants of the scene."""

    deceleration: float  # rolling: mu g [m/s^2]
    ball_restitution: float
    cushion_restitution: float
    cushion_tangential: float
    t_max: float  # [s]; inf: until rest
    # Lines that noses of cushions lie on, by cushion index [m]; -inf or inf: no cushion there.
    left: float
    right: float
    bottom: float
    top: float


class Pairs(NamedTuple):
    """Lower bounds of every pair's contact time; see `_pairs`."""

    bound: FloatArray  # (n, n) [s]; each pair in the row of the ball recomputed last, else inf
    row_least: FloatArray  # (n,) least bound of the row
    row_partner: IntArray  # (n,) where it stands


class Contacts(NamedTuple):
    """Clusters of balls pressed together, and room to find their forces; see `_press`.

    m is enough for every pair and cushion.
    """

    cluster: IntArray  # (n,) label of the ball's cluster, or FREE
    held: BoolArray  # (n, n) whether a contact step holds the pair together
    changed: BoolArray  # (n,) whether this event changed the ball's motion
    stopped: BoolArray  # (n,) whether a contact step's start stopped the ball
    member: IntArray  # (n,) balls of the cluster at hand
    motion: FloatArray  # (5, n): rows STEP ... NEW_AY below, by ball
    ends: IntArray  # (2, m) FIRST: a ball; SECOND: the other, or -1 minus a cushion's index
    forces: FloatArray  # (3, m): rows FORCE, NX, NY below


# Rows of `Contacts.motion`.
STEP = 0  # length that was good for the ball's last contact step [s]; 0: none since a collision
PUSH_X = 1  # contact force on a member [N]
PUSH_Y = 2
NEW_AX = 3  # acceleration of a member [m/s^2]
NEW_AY = 4

# Rows of `Contacts.ends`.
FIRST = 0
SECOND = 1

# Rows of `Contacts.forces`.
FORCE = 0  # [N], never negative
NX = 1  # normal at the middle of the step, away from the first ball
NY = 2


class Log(NamedTuple):
    """What happened: m events, and k balls whose motion changed, just after."""

    time: FloatArray  # (m,) [s]
    what: IntArray  # (3, m): rows WHAT_KIND (EventKind), WHAT_A, WHAT_B
    ball: IntArray  # (k,)
    motion: FloatArray  # (k, 7): time, x, y, vx, vy, ax, ay


WHAT_KIND = 0
WHAT_A = 1
WHAT_B = 2  # second ball, cushion index or -1


# Places in the array of counters, int64.
EVENTS = 0
BALL_BALL = 1
BALL_CUSHION = 2
REST = 3
BOUNDS = 4
ADVANCEMENTS = 5
CONTACT_STEPS = 6
UNSOLVED_STEPS = 7
LOGGED_EVENTS = 8
LOGGED_MOTIONS = 9
COUNTERS = 10

# Places in the array of instants, float64 [s].
NOW = 0
LAST_EVENT = 1
CLOCKS = 2

# Cushions, in the order of `engine.scene.CUSHIONS`.
LEFT = 0
RIGHT = 1
BOTTOM = 2
TOP = 3

OWN_NONE = 0
OWN_REST = 1
OWN_CONTACT = 2  # a contact step ends
OWN_CUSHION = 3

FREE = -1

# What the loop returns. It never raises.
RUN_RESTED = 0
RUN_T_MAX = 1
RUN_EVENT_LIMIT = 2
RUN_LOG_FULL = 3
RUN_NOT_FINITE = 4


def balls_of(scene: Scene) -> Balls:
    """Lay out the scene's balls; accelerations and own events are the kernel's to fill in."""
    n = len(scene.balls)
    state = np.zeros((10, n))
    state[[X, Y]] = scene.positions[:, :2].T
    state[[VX, VY]] = scene.velocities[:, :2].T
    state[OWN_TIME] = np.inf
    state[RADIUS] = scene.radii
    state[MASS] = scene.masses
    return Balls(state, np.zeros(n, dtype=np.int64))


def laws_of(scene: Scene) -> Laws:
    """Reduce the scene's physics and table to the numbers that the kernel uses."""
    physics, table = scene.physics, scene.table
    noses = [-np.inf, np.inf, -np.inf, np.inf]
    if table is not None:
        lines = [0.0, table.length, 0.0, table.width]
        for index, name in enumerate(CUSHIONS):
            if name in table.cushions:
                noses[index] = lines[index]
    mirror = physics.cushion == "mirror"
    return Laws(
        deceleration=physics.rolling_friction * physics.gravity,
        ball_restitution=float(physics.ball_restitution),
        cushion_restitution=1.0 if mirror else float(physics.cushion_restitution),
        cushion_tangential=1.0 if mirror else float(physics.cushion_tangential_restitution),
        t_max=np.inf if scene.t_max is None else float(scene.t_max),
        left=noses[0],
        right=noses[1],
        bottom=noses[2],
        top=noses[3],
    )


def pairs_of(n: int) -> Pairs:
    """Room for the bounds of n balls."""
    return Pairs(np.full((n, n), np.inf), np.full(n, np.inf), np.zeros(n, dtype=np.int64))


def contacts_of(n: int) -> Contacts:
    """Room for the contacts of n balls."""
    m = n * (n - 1) // 2 + len(CUSHIONS) * n
    return Contacts(
        cluster=np.full(n, FREE, dtype=np.int64),
        held=np.zeros((n, n), dtype=np.bool_),
        changed=np.zeros(n, dtype=np.bool_),
        stopped=np.zeros(n, dtype=np.bool_),
        member=np.zeros(n, dtype=np.int64),
        motion=np.zeros((5, n)),
        ends=np.zeros((2, m), dtype=np.int64),
        forces=np.zeros((3, m)),
    )


def log_of(capacity: int, n: int) -> Log:
    """Room for `capacity` events of n balls: most change two balls, one may change all."""
    motions = 2 * capacity + n if capacity else 0
    return Log(
        np.empty(capacity),
        np.empty((3, capacity), dtype=np.int64),
        np.empty(motions, dtype=np.int64),
        np.empty((motions, 7)),
    )
