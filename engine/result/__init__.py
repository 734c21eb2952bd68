"""What any engine returns, and the events that are in it."""

from engine.core.events import (
    COLLISION_KINDS,
    EVENT_DTYPE,
    RECORDS,
    EventKind,
    Events,
    Record,
    Status,
)
from engine.result.result import Result, event_dict, initial_state

__all__ = [
    "COLLISION_KINDS",
    "EVENT_DTYPE",
    "RECORDS",
    "EventKind",
    "Events",
    "Record",
    "Result",
    "Status",
    "event_dict",
    "initial_state",
]
