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


class Balls(NamedTuple):
    """State of n balls, each at its own epoch; arrays (n,).

    The centre moves as x + vx s + ax s^2 / 2, s the time since `epoch`, until `own_time`, when the
    ball's own next event changes its motion.
    """

    x: FloatArray  # [m]
    y: FloatArray
    vx: FloatArray  # [m/s]
    vy: FloatArray
    ax: FloatArray  # [m/s^2]
    ay: FloatArray
    epoch: FloatArray  # [s]
    own_time: FloatArray  # next event that needs no second ball [s]; inf: none
    own_kind: IntArray  # OWN_NONE, OWN_REST, or OWN_CUSHION + the cushion's index
    radius: FloatArray  # [m]
    mass: FloatArray  # [kg]


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

    Arrays over balls (n,), or over contacts (m,), m enough for every pair and cushion.
    """

    cluster: IntArray  # (n,) label of the ball's cluster, or FREE
    held: NDArray[np.bool_]  # (n, n) whether a contact step holds the pair together
    changed: NDArray[np.bool_]  # (n,) whether this event changed the ball's motion
    step: FloatArray  # (n,) length of the ball's last contact step [s], 0 for none
    member: IntArray  # (n,) balls of the cluster at hand
    fx: FloatArray  # (n,) contact force on a member [N]
    fy: FloatArray
    ax: FloatArray  # (n,) acceleration of a member [m/s^2]
    ay: FloatArray
    first: IntArray  # (m,) a ball
    second: IntArray  # (m,) the other ball, or -1 minus the index of a cushion
    force: FloatArray  # (m,) [N], never negative
    nx: FloatArray  # (m,) normal at the middle of the step, away from the first ball
    ny: FloatArray


class Log(NamedTuple):
    """What happened: m events, and k balls whose motion changed, just after."""

    time: FloatArray  # (m,) [s]
    kind: IntArray  # (m,) EventKind
    a: IntArray  # (m,)
    b: IntArray  # (m,) second ball, cushion index or -1
    ball: IntArray  # (k,)
    motion: FloatArray  # (k, 7): time, x, y, vx, vy, ax, ay


# Columns of `Counters`, an int64 array.
EVENTS = 0
BALL_BALL = 1
BALL_CUSHION = 2
REST = 3
BOUNDS = 4
ADVANCEMENTS = 5
CONTACT_STEPS = 6
LOGGED_EVENTS = 7
LOGGED_MOTIONS = 8
COUNTERS = 9

# Columns of `Clock`, a float64 array.
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
    position, velocity = scene.positions, scene.velocities
    return Balls(
        x=position[:, 0].copy(),
        y=position[:, 1].copy(),
        vx=velocity[:, 0].copy(),
        vy=velocity[:, 1].copy(),
        ax=np.zeros(n),
        ay=np.zeros(n),
        epoch=np.zeros(n),
        own_time=np.full(n, np.inf),
        own_kind=np.zeros(n, dtype=np.int64),
        radius=scene.radii,
        mass=scene.masses,
    )


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
        step=np.zeros(n),
        member=np.zeros(n, dtype=np.int64),
        fx=np.zeros(n),
        fy=np.zeros(n),
        ax=np.zeros(n),
        ay=np.zeros(n),
        first=np.zeros(m, dtype=np.int64),
        second=np.zeros(m, dtype=np.int64),
        force=np.zeros(m),
        nx=np.zeros(m),
        ny=np.zeros(m),
    )


def log_of(capacity: int, n: int) -> Log:
    """Room for `capacity` events of n balls: most change two balls, one may change all."""
    motions = 2 * capacity + n if capacity else 0
    return Log(
        np.empty(capacity),
        np.empty(capacity, dtype=np.int64),
        np.empty(capacity, dtype=np.int64),
        np.empty(capacity, dtype=np.int64),
        np.empty(motions, dtype=np.int64),
        np.empty((motions, 7)),
    )
