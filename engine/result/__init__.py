"""What any engine returns, and the events that are in it."""

from ghostball.engine.core.events import (
    COLLISION_KINDS,
    EVENT_DTYPE,
    OBSTACLE_KINDS,
    RECORDS,
    EventKind,
    Events,
    Record,
    Status,
)
from ghostball.engine.result.result import Result, event_dict, initial_state

__all__ = [
    "COLLISION_KINDS",
    "EVENT_DTYPE",
    "OBSTACLE_KINDS",
    "RECORDS",
    "EventKind",
    "Events",
    "Record",
    "Result",
    "Status",
    "event_dict",
    "initial_state",
]
