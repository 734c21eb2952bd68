"""What can happen in a shot, how a run can end, and what can be kept of one."""

from __future__ import annotations

import enum
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Record = Literal["rest", "events", "trajectory"]
"""What to keep: the end only; every event too; whatever is needed to sample the motion, too."""

RECORDS: tuple[Record, ...] = ("rest", "events", "trajectory")

EVENT_DTYPE = np.dtype([("t", np.float64), ("kind", np.uint8), ("a", np.int32), ("b", np.int32)])
"""One event: time [s]; `EventKind`; first ball; second ball, or an obstacle's index, or -1."""

Events = NDArray[np.void]


class EventKind(enum.IntEnum):
    """What happened; `label` is the name used in files and reports."""

    BALL_BALL = 0
    BALL_CUSHION = 1
    SLIDE_TO_ROLL = 2
    ROLL_TO_REST = 3
    POCKETED = 4  # its centre entered the hole of a pocket
    BALL_CLOTH = 5  # one in the air came down, or its last bounces ended
    LEAVES_TABLE = 6  # it flew over a cushion, or over a pocket and its back

    @property
    def label(self) -> str:
        """Name in files and reports, such as "ball-ball"."""
        return self.name.lower().replace("_to_", "-to-").replace("_", "-")


COLLISION_KINDS = (EventKind.BALL_BALL, EventKind.BALL_CUSHION)
OBSTACLE_KINDS = (EventKind.BALL_CUSHION, EventKind.POCKETED, EventKind.LEAVES_TABLE)
"""Those of a ball and an obstacle, or a pocket, whose index the event names."""

LEAVING_KINDS = (EventKind.POCKETED, EventKind.LEAVES_TABLE)
"""Kinds of events after which a ball is no longer part of the shot."""


class Status(enum.Enum):
    """How a run ended; the text says what it means and what to do."""

    REST = "every ball came to rest"
    T_MAX = "stopped at the scene's `t_max`; balls may still be moving"
    EVENT_LIMIT = (
        "the event limit was reached; raise `max_events`, or look for balls in resting contact"
    )
    WORK_LIMIT = "the limit of work was reached before every ball rested; raise `max_work`"
    ENDLESS = "balls bounce without coming to rest, which no limit mends; see `reason`"
    STEP_LIMIT = "the step limit was reached before every ball rested; raise `max_time` or `dt`"
    UNPROVED = "what comes next can't be proved; the result holds what is; see `reason`"
    FAILED = "the engine failed; see `reason`"

    @property
    def complete(self) -> bool:
        """Whether the run reached its natural end."""
        return self in (Status.REST, Status.T_MAX)
