"""A record of a run, with the events for comparisons."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from ghostball.model import Events, GhostballError
from ghostball.model.hashes import sequence_hash
from ghostball.validation.results.records import CaseRecord, Motion
from ghostball.validation.results.store import Results


class MotionNotKeptError(GhostballError):
    """The events of a run are not known, because its motion was not kept."""


@dataclass(frozen=True, eq=False)
class EventLog:
    """The events of a shot.

    `events`, a structured array (`EVENT_DTYPE`): all `count` events, or the first of them, as in a
        baseline.
    `sequence`: hash of the order of all events, without times.
    """

    events: Events
    count: int
    sequence: str

    @classmethod
    def of(cls, events: Events) -> EventLog:
        """Return a log of all events."""
        return cls(events, len(events), sequence_hash(events))

    @property
    def until(self) -> float:
        """Time before which the log holds all events [s]; inf if it holds all events."""
        return math.inf if len(self.events) == self.count else float(self.events["t"][-1])


@dataclass(frozen=True, eq=False)
class ComparedRun:
    """A record, and a function that returns its events, called only if the hashes differ."""

    record: CaseRecord
    log: Callable[[], EventLog]

    @classmethod
    def of(cls, record: CaseRecord, motion: Motion | None) -> ComparedRun:
        """Return a record with its stored motion."""
        return cls(record, lambda: _log_in(record, motion))

    @classmethod
    def stored(cls, results: Results, record: CaseRecord) -> ComparedRun:
        """Return a record of a results folder."""
        return cls(record, cache(lambda: _log_in(record, results.motion(record))))


def _log_in(record: CaseRecord, motion: Motion | None) -> EventLog:
    if motion is None:
        raise MotionNotKeptError(
            f'scene "{record.scene}" on `{record.label}`: its motion was not kept, so its events '
            "can't be compared. Run the scene again"
        )
    return EventLog.of(motion.events)
