"""Where two logs of collisions part, in the order that matters: each ball's own.

Two collisions without a ball in common may swap in a log and nothing changes; two that share one
may not. So logs agree while every ball goes through the same collisions one after another, and they
part at the first collision, in time, that the other log doesn't have at that place of its balls'
lives. (Such logs are equivalent as traces: Mazurkiewicz 1977.)
"""

from __future__ import annotations

import math
from collections import defaultdict, deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import CUSHIONS, EventKind, Scene
from ghostball.engine.result import Events
from ghostball.validation.grading.tolerances import TIE

FloatArray = NDArray[np.float64]

Key = tuple[int, int, int]
"""What met what, without when: `EventKind` as int, first ball, second ball or index of cushion."""

KINDS = (EventKind.BALL_BALL, EventKind.BALL_CUSHION)


@dataclass(frozen=True)
class Collision:
    """A collision of a log: `kind`, ball `a`, ball or cushion `b`, at `t` [s]."""

    kind: EventKind
    a: int
    b: int
    t: float

    @property
    def key(self) -> tuple[EventKind, int, int]:
        """What met what, without when."""
        return (self.kind, self.a, self.b)

    @property
    def balls(self) -> tuple[int, ...]:
        """Indices of its balls: two, or one where it is with a cushion."""
        return (self.a, self.b) if self.kind is EventKind.BALL_BALL else (self.a,)

    def describe(self, scene: Scene) -> str:
        """Return the collision in words, with the names of its balls."""
        first = f'"{scene.balls[self.a].id}"'
        if self.kind is EventKind.BALL_BALL:
            return f'{first} hits "{scene.balls[self.b].id}"'
        return f"{first} hits the {CUSHIONS[self.b]} cushion"


@dataclass(frozen=True)
class Parting:
    """Where two logs part.

    Attributes
    ----------
    true, other : Collision or None
        What the true log has there, and what the other one has instead; None where a log has
        nothing more for the balls concerned. One of them isn't None.
    """

    true: Collision | None
    other: Collision | None

    @property
    def t(self) -> float:
        """When they part [s]: the earlier of the two collisions."""
        return min(one.t for one in (self.true, self.other) if one is not None)

    @property
    def first(self) -> Collision:
        """The earlier of the two collisions."""
        both = [one for one in (self.true, self.other) if one is not None]
        return min(both, key=lambda one: one.t)


@dataclass(frozen=True)
class Agreement:
    """How far two logs agree.

    Attributes
    ----------
    pairs : tuple of (Collision, Collision)
        The collisions that both have, the true one first, in order of the true time.
    parting : Parting or None
        None where they agree to the end.
    leading : int
        How many collisions both have before the first that only one of them has.
    """

    pairs: tuple[tuple[Collision, Collision], ...]
    parting: Parting | None

    leading: int = 0

    def parts_at(self, *, timed: bool = True) -> float | None:
        """Return when the logs part [s]; inf: never; None where no log says when.

        `timed` says whether the true collisions have times of their own: see `collisions_from`.
        """
        if self.parting is None:
            return math.inf
        true, other = self.parting.true, self.parting.other
        known = [one.t for one in (true if timed else None, other) if one is not None]
        return min(known, default=None)

    @property
    def before(self) -> tuple[tuple[Collision, Collision], ...]:
        """The pairs that come before the parting, in either log; all where there is none."""
        if self.parting is None:
            return self.pairs
        t = self.parting.t
        return tuple((a, b) for a, b in self.pairs if min(a.t, b.t) <= t)


def collisions_in(events: Events) -> list[Collision]:
    """Return the collisions of an event log, the lower ball first."""
    return collisions_from(*collisions_of(events))


def collisions_of(events: Events) -> tuple[list[Key], FloatArray]:
    """Return the collisions of an event log, the lower ball first, and their times (k,) [s]."""
    kept = events[np.isin(events["kind"], KINDS)]
    columns = (kept[name].tolist() for name in ("kind", "a", "b"))
    keys = [lower_first(kind, a, b) for kind, a, b in zip(*columns, strict=True)]
    return keys, kept["t"].astype(np.float64)


def lower_first(kind: int, a: int, b: int) -> Key:
    """Return what met what, of two balls the lower one first."""
    return (kind, b, a) if kind == EventKind.BALL_BALL and b < a else (kind, a, b)


def collisions_from(keys: Sequence[Key], times: FloatArray) -> list[Collision]:
    """Return collisions of these times; without times they come one after another.

    A closed form may know the order alone, which is strict then.
    """
    instants = times.tolist() if len(times) else range(1, len(keys) + 1)
    return [
        Collision(EventKind(kind), a, b, float(t))
        for (kind, a, b), t in zip(keys, instants, strict=True)
    ]


def compare_logs(true: Sequence[Collision], other: Sequence[Collision]) -> Agreement:
    """Compare two logs, each in order of time.

    Notes
    -----
    Collisions at one instant, to within `TIE` of it, have no order, also where they share a ball:
    an engine that steps reports one time for all collisions of a step.
    """
    queues: dict[int, deque[int]] = defaultdict(deque)
    for position, one in enumerate(other):
        for ball in one.balls:
            queues[ball].append(position)
    stuck: set[int] = set()
    pairs: list[tuple[Collision, Collision]] = []
    places: list[tuple[int, int]] = []
    lost: list[Collision] = []
    first_lost = len(true)
    for place, one in enumerate(true):
        index: int | None = None
        if stuck.isdisjoint(one.balls):
            tied = {two.key for two in _tied_with(true, place)}
            index = _counterpart(one, other, queues, tied)
        if index is None:
            stuck.update(one.balls)
            lost.append(one)
            first_lost = min(first_lost, place)
            continue
        pairs.append((one, other[index]))
        places.append((place, index))
        for ball in one.balls:
            queues[ball].remove(index)
    left = sorted({position for queue in queues.values() for position in queue})
    extra = [other[position] for position in left]
    first_extra = left[0] if left else len(other)
    leading = sum(i < first_lost and j < first_extra for i, j in places)
    return Agreement(tuple(pairs), _first_parting(lost, extra), leading)


def compare_collisions(keys: Sequence[Key], times: FloatArray, events: Events) -> Agreement:
    """Compare true collisions, of these times where they have some, with those of an event log."""
    return compare_logs(collisions_from(keys, times), collisions_in(events))


def _counterpart(
    one: Collision,
    other: Sequence[Collision],
    queues: dict[int, deque[int]],
    tied: set[tuple[EventKind, int, int]],
) -> int | None:
    """Return the index in the other log of what comes next for all its balls, or None."""
    index = next((i for i in queues.get(one.a, ()) if other[i].key == one.key), None)
    if index is None:
        return None
    for ball in one.balls:
        for earlier in queues[ball]:
            if earlier == index:
                break
            swaps = other[earlier].key in tied or _one_instant(other[earlier].t, other[index].t)
            if not swaps:
                return None
    return index


def _tied_with(log: Sequence[Collision], place: int) -> list[Collision]:
    """Return the later collisions of a log at the same instant as the one at `place`."""
    tied = []
    for one in log[place + 1 :]:
        if not _one_instant(log[place].t, one.t):
            break
        tied.append(one)
    return tied


def _one_instant(t: float, later: float) -> bool:
    return later - t <= TIE * later


def _first_parting(lost: Sequence[Collision], extra: Sequence[Collision]) -> Parting | None:
    """Return the first collision that one log lacks, with what the other has for its balls."""
    if not lost and not extra:
        return None
    if not extra or (lost and lost[0].t <= extra[0].t):
        return Parting(lost[0], _sharing(extra, lost[0]))
    return Parting(_sharing(lost, extra[0]), extra[0])


def _sharing(log: Sequence[Collision], one: Collision) -> Collision | None:
    return next((two for two in log if not set(two.balls).isdisjoint(one.balls)), None)
