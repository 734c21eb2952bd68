"""Compare the ends of slides and rolls of a run with the certified ones.

    >>> found = events_in(result.events, ALL_KINDS)
    >>> phase_ends(events_of_certificate(certificate), found, result.rest_time)

The log of each ball is cut at its collisions, whose order both logs share. Between two collisions a
ball ends at most one slide and one roll, so each end that a run reports there is compared; in
flight there may be more, and each is compared with the nearest one. A time-stepping engine may omit
a phase that is shorter than its step, or report a phase that the certified motion doesn't have. So
if a run lacks an end, the end is taken at the ball's collision before it or after it in the run,
whichever is nearer in time; the end of the run counts as the collision after the last one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

from ghostball.model import COLLISION_KINDS, EventKind
from ghostball.model.events import LEAVING_KINDS
from ghostball.validation.grading.event_logs import Event, compare_logs

PHASE_ENDS = (EventKind.SLIDE_TO_ROLL, EventKind.ROLL_TO_REST)
"""Kinds of events that end a slide or a roll without a contact."""

_CUTS = (*COLLISION_KINDS, *LEAVING_KINDS)
"""Kinds of events that interrupt a phase."""


class PhaseEnd(NamedTuple):
    """The certified end of a slide or of a roll, and the time error of a run.

    `true`: the certified event.
    `late_by` [s]: absolute value of the time error.
    """

    true: Event
    late_by: float


class _Leg(NamedTuple):
    """The motion of a ball between two of its collisions.

    `first`, `last`: certified indices of the two collisions; inf: there is no further collision.
    `begins`, `ends` [s]: times of the two collisions in the run.
    """

    first: int
    last: float
    begins: float
    ends: float


def phase_ends(certified: Sequence[Event], found: Sequence[Event], end: float) -> list[PhaseEnd]:
    """Compare the ends of slides and rolls of a run with the certified ones.

    `certified`, `found`: all events of the certified motion and of the run, in order of time.
    `end` [s]: time at which the run ends.

    A kind of end that the run never reports isn't compared. Nothing is compared after a collision
    that only one of the two logs has.
    """
    reported = {one.kind for one in found} & set(PHASE_ENDS)
    legs = _legs(certified, found, end)
    ends = []
    for true in certified:
        if true.kind not in reported:
            continue
        leg = next((one for one in legs.get(true.a, ()) if one.first < true.index < one.last), None)
        if leg is not None:
            same = [one.t for one in certified if _is_same_kind_in(one, true, leg)]
            ends.append(PhaseEnd(true, _late_by(true, _times(leg, true, found), same)))
    return ends


def _is_same_kind_in(one: Event, true: Event, leg: _Leg) -> bool:
    """Return True if a certified end has the kind, ball and leg of `true`."""
    return (one.kind, one.a) == (true.kind, true.a) and leg.first < one.index < leg.last


def _late_by(true: Event, times: Sequence[float], same: Sequence[float]) -> float:
    """Return the largest time error of the ends that a run reports for a certified end [s].

    `times`: reported ends in this leg; `same`: certified ends in it. A reported end belongs to the
    nearest certified end. If none belongs to `true`, the nearest reported end is compared.
    """
    own = [t for t in times if min(same, key=lambda one: abs(one - t)) == true.t]
    return max((abs(t - true.t) for t in own), default=min(abs(t - true.t) for t in times))


def first_contact(events: Sequence[Event], end: float) -> float:
    """Return the time of the first contact, or of the first ball that leaves; else `end` [s]."""
    return next((one.t for one in events if one.kind not in PHASE_ENDS), end)


def _times(leg: _Leg, true: Event, found: Sequence[Event]) -> list[float]:
    """Return the times at which a run has the end of a phase, or may have it [s]."""
    kinds = PHASE_ENDS[PHASE_ENDS.index(true.kind) :]
    for kind in kinds:  # if a ball stops as its slide ends, a run may report only the rest
        times = [
            one.t
            for one in found
            if one.kind is kind and one.a == true.a and leg.begins <= one.t <= leg.ends
        ]
        if times:
            return times
    return [min(leg.begins, leg.ends, key=lambda t: abs(t - true.t))]


def _legs(certified: Sequence[Event], found: Sequence[Event], end: float) -> dict[int, list[_Leg]]:
    """Return the legs of each ball that both logs have."""
    cuts, found_cuts = ([one for one in log if one.kind in _CUTS] for log in (certified, found))
    agreement = compare_logs(cuts, found_cuts)
    parted = {ball for i in agreement.missing for ball in cuts[i].balls}
    parted |= {ball for j in agreement.invented for ball in found_cuts[j].balls}
    marks = {ball: [(-1, 0.0)] for one in certified for ball in one.balls}
    for true, other in agreement.pairs:
        for ball in true.balls:
            marks[ball].append((true.index, other.t))
    return {ball: list(_between(own, ball in parted, end)) for ball, own in marks.items()}


def _between(marks: Sequence[tuple[int, float]], parted: bool, end: float) -> Iterator[_Leg]:
    """Yield the legs between a ball's collisions; the last leg only if no later one is missing."""
    for (first, begins), (last, ends) in pairwise(marks):
        yield _Leg(first, last, begins, ends)
    if not parted:
        yield _Leg(marks[-1][0], math.inf, marks[-1][1], end)
