"""Kinds of events, states in which a run can end, and levels of recording."""

from __future__ import annotations

import enum
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Record = Literal["rest", "events", "trajectory"]
"""What to record: the final state; the final state and all events; or, in addition, the motion."""

RECORDS: tuple[Record, ...] = ("rest", "events", "trajectory")

EVENT_DTYPE = np.dtype([("t", np.float64), ("kind", np.uint8), ("a", np.int32), ("b", np.int32)])
"""One event: time [s]; `EventKind`; first ball; second ball, or index of an obstacle, or -1."""

Events = NDArray[np.void]


class EventKind(enum.IntEnum):
    """Kind of an event; `label` is its name in files and reports."""

    BALL_BALL = 0
    BALL_CUSHION = 1
    SLIDE_TO_ROLL = 2
    ROLL_TO_REST = 3
    POCKETED = 4  # the centre of a ball entered the hole of a pocket
    BALL_CLOTH = 5  # an airborne ball landed, or its last bounces ended
    LEAVES_TABLE = 6  # a ball flew over a cushion, or over a pocket and its back

    @property
    def label(self) -> str:
        """Name in files and reports, such as "ball-ball"."""
        return self.name.lower().replace("_to_", "-to-").replace("_", "-")


COLLISION_KINDS = (EventKind.BALL_BALL, EventKind.BALL_CUSHION)
OBSTACLE_KINDS = (EventKind.BALL_CUSHION, EventKind.POCKETED, EventKind.LEAVES_TABLE)
"""Kinds of events of a ball with an obstacle or a pocket, whose index is `b`."""

LEAVING_KINDS = (EventKind.POCKETED, EventKind.LEAVES_TABLE)
"""Kinds of events after which a ball is no longer part of the shot."""


class Status(enum.Enum):
    """How a run ended; the value explains the status and names a remedy."""

    REST = "every ball came to rest"
    T_MAX = "reached the scene's `t_max`; balls may still be moving"
    EVENT_LIMIT = (
        "reached the event limit; raise `max_events`, or check for balls in resting contact"
    )
    WORK_LIMIT = "reached the work limit before all balls came to rest; raise `max_work`"
    ENDLESS = "balls bounce endlessly; raising a limit won't help; see `reason`"
    STEP_LIMIT = "reached the step limit before all balls came to rest; raise `max_time` or `dt`"
    UNPROVED = (
        "the next event can't be certified; the result contains everything before it; see `reason`"
    )
    FAILED = "the engine failed; see `reason`"

    @property
    def complete(self) -> bool:
        """Whether the run reached its normal end."""
        return self in (Status.REST, Status.T_MAX)
