"""When balls begin to roll, and when they come to rest: a run compared with the proof of its shot.

    >>> found = events_in(result.events, ALL_KINDS)
    >>> phase_ends(proved_events(certificate), found, result.rest_time)

Each ball's log is cut at its collisions, which both logs share in order; between two of them a ball
ends a slide at most once, and a roll at most once. An engine that steps may leave out a phase that
is shorter than its step, or have one where the proof has none: so an end that a run lacks counts as
reported when the ball's collision before it is, or the one after it, whichever is nearer.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

from ghostball.model import COLLISION_KINDS, EventKind
from ghostball.model.events import LEAVING_KINDS
from ghostball.validation.grading.event_logs import Event, compare_logs

PHASE_ENDS = (EventKind.SLIDE_TO_ROLL, EventKind.ROLL_TO_REST)
"""Kinds of events that end what a ball does on the cloth, without a contact."""

_CUTS = (*COLLISION_KINDS, *LEAVING_KINDS)
"""Kinds of events that end a phase whatever is left of it."""


class PhaseEnd(NamedTuple):
    """The proved end of a slide or of a roll, and how far from it a run has it.

    `true`: the proved event.
    `late_by` [s]: without its sign.
    """

    true: Event
    late_by: float


class _Leg(NamedTuple):
    """What a ball does between two of its collisions.

    `first`, `last`: indices of these in the proof; inf: there is no further one.
    `begins`, `ends` [s]: when they come in the run.
    """

    first: int
    last: float
    begins: float
    ends: float


def phase_ends(proved: Sequence[Event], found: Sequence[Event], end: float) -> list[PhaseEnd]:
    """Compare the ends of slides and rolls of a run with the proved ones, in the order of balls.

    `proved`, `found`: all events, each in order of time.
    `end` [s]: of the run.

    Kinds that the run doesn't report at all are left out. So is what comes after a collision that
    only one of the two has.
    """
    reported = {one.kind for one in found} & set(PHASE_ENDS)
    legs = _legs(proved, found, end)
    ends = []
    for true in proved:
        if true.kind not in reported:
            continue
        leg = next((one for one in legs.get(true.a, ()) if one.first < true.index < one.last), None)
        if leg is not None:
            times = _times(leg, true, found)
            ends.append(PhaseEnd(true, min(abs(t - true.t) for t in times)))
    return ends


def first_contact(events: Sequence[Event], end: float) -> float:
    """Return when something first touches a ball, or it leaves the table [s]; else `end` [s]."""
    return next((one.t for one in events if one.kind not in PHASE_ENDS), end)


def _times(leg: _Leg, true: Event, found: Sequence[Event]) -> Collection[float]:
    """Return when a run may have the end of a phase [s]: at one of these times."""
    kinds = PHASE_ENDS[PHASE_ENDS.index(true.kind) :]
    for kind in kinds:  # a slide that ends as the ball stops may be reported as that alone
        times = [
            one.t
            for one in found
            if one.kind is kind and one.a == true.a and leg.begins <= one.t <= leg.ends
        ]
        if times:
            return times
    return leg.begins, max(leg.ends, true.t)


def _legs(proved: Sequence[Event], found: Sequence[Event], end: float) -> dict[int, list[_Leg]]:
    """Return the legs of each ball that both logs have."""
    cuts, found_cuts = ([one for one in log if one.kind in _CUTS] for log in (proved, found))
    agreement = compare_logs(cuts, found_cuts)
    parted = {ball for i in agreement.missing for ball in cuts[i].balls}
    parted |= {ball for j in agreement.invented for ball in found_cuts[j].balls}
    marks = {ball: [(-1, 0.0)] for one in proved for ball in one.balls}
    for true, other in agreement.pairs:
        for ball in true.balls:
            marks[ball].append((true.index, other.t))
    return {ball: list(_between(own, ball in parted, end)) for ball, own in marks.items()}


def _between(marks: Sequence[tuple[int, float]], parted: bool, end: float) -> Iterator[_Leg]:
    """Yield the legs between a ball's collisions; the last one only if none is missing after it."""
    for (first, begins), (last, ends) in pairwise(marks):
        yield _Leg(first, last, begins, ends)
    if not parted:
        yield _Leg(marks[-1][0], math.inf, marks[-1][1], end)
