"""Compare two logs of events by the order of events of each ball.

    >>> found = compare_logs(events_from(certificate.keys, times), events_in(result.events))
    >>> found.parting, found.leading

Two events without a common ball may swap in a log without effect; two events with a common ball may
not. Logs therefore agree while every ball has the same events in the same order. They differ from
the first event, in time, that the other log doesn't have at this place in the order of its balls.
(Logs that agree in this sense are equivalent as traces: Mazurkiewicz 1977.) After a difference in
its order, no further events of a ball are paired.
"""

from __future__ import annotations

import math
from collections import defaultdict, deque
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from ghostball.model import COLLISION_KINDS, CUSHIONS, EventKind, Events, Scene, partner_name
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.certified import Certificate
from ghostball.validation.grading.tolerances import TIE

Key = tuple[int, int, int]
"""Kind and bodies of an event, without its time: `EventKind` as int, first ball, second ball or
index of cushion; the ball with the lower index is first.
"""

ALL_KINDS = tuple(EventKind)


@dataclass(frozen=True, slots=True)
class Event:
    """An event of a log: `kind`, ball `a`, ball or cushion `b`, at `t` [s].

    `index` is its position in its source.
    """

    kind: EventKind
    a: int
    b: int
    t: float
    index: int = field(default=0, compare=False)

    @property
    def key(self) -> tuple[EventKind, int, int]:
        """Kind and bodies of the event, without its time."""
        return (self.kind, self.a, self.b)

    @property
    def balls(self) -> tuple[int, ...]:
        """Indices of its balls: two for a collision of balls, otherwise one."""
        return (self.a, self.b) if self.kind is EventKind.BALL_BALL else (self.a,)

    def first_ball(self, scene: Scene) -> str:
        """Return the name of its first ball, in words."""
        return f'"{scene.balls[self.a].id}"'

    def obstacle(self, scene: Scene) -> str:
        """Return the body that the ball hits, in words; "" if it hits nothing."""
        if self.kind is EventKind.BALL_BALL:
            return f'"{scene.balls[self.b].id}"'
        if self.kind is EventKind.BALL_CUSHION:
            name = partner_name(self.kind, self.b)
            return f"the {name} cushion" if self.b < len(CUSHIONS) else name
        return ""

    def describe(self, scene: Scene) -> str:
        """Return the event in words, with the names of its balls."""
        first, obstacle = self.first_ball(scene), self.obstacle(scene)
        if obstacle:
            return f"{first} hits {obstacle}"
        if self.kind is EventKind.POCKETED:
            return f'{first} falls into the pocket "{partner_name(self.kind, self.b)}"'
        if self.kind is EventKind.LEAVES_TABLE:
            return f'{first} flies off the table, over "{partner_name(self.kind, self.b)}"'
        return f"{first}: {self.kind.label}"


@dataclass(frozen=True)
class Parting:
    """The first difference of two logs.

    `true`, `other`: the event of the reference log, and that of the other log; None if a log has no
        further event for these balls. At least one of them isn't None.
    """

    true: Event | None
    other: Event | None

    @property
    def t(self) -> float:
        """Time of the difference [s]: that of the earlier event."""
        return self.first.t

    @property
    def first(self) -> Event:
        """The earlier of the two events."""
        return min((one for one in (self.true, self.other) if one), key=lambda one: one.t)

    def describe(self, scene: Scene) -> str:
        """Return a sentence about the difference of a reference and a run, with ball names."""
        missing = self.first is self.true
        instead = self.other if missing else self.true
        words = [
            f"{self.first.describe(scene)} at t = {self.first.t:.17g} s",
            "is missing from the run;" if missing else "is not in the reference;",
            "found instead:" if missing else "reference:",
            "no further event of these balls"
            if instead is None
            else f"{instead.describe(scene)} at t = {instead.t:.17g} s",
        ]
        return " ".join(words)


@dataclass(frozen=True)
class Agreement:
    """The agreement of two logs.

    `pairs`: the events that both logs have, as (reference, other), in the order of the reference.
    `index_pairs`: their indices in the two given logs.
    `missing`: indices of reference events that the other log lacks.
    `invented`: indices of events of the other log that the reference lacks.
    `parting`: the first difference; None if they agree to the end.
    """

    pairs: tuple[tuple[Event, Event], ...]
    index_pairs: tuple[tuple[int, int], ...]
    missing: tuple[int, ...]
    invented: tuple[int, ...]
    parting: Parting | None

    @property
    def leading(self) -> int:
        """Number of pairs before the first event that only one log has."""
        return len(self.before)

    def parts_at(self, *, timed: bool = True) -> float | None:
        """Return the time of the first difference [s]; inf: none; None if no log states the time.

        `timed` states whether the reference events have times: see `events_from`.
        """
        if self.parting is None:
            return math.inf
        true, other = self.parting.true, self.parting.other
        known = [one.t for one in (true if timed else None, other) if one is not None]
        return min(known, default=None)

    @property
    def before(self) -> tuple[tuple[Event, Event], ...]:
        """The pairs that come, in both logs, before every event that only one log has."""
        first_missing = min(self.missing, default=math.inf)
        first_invented = min(self.invented, default=math.inf)
        return tuple(
            pair
            for pair, (i, j) in zip(self.pairs, self.index_pairs, strict=True)
            if i < first_missing and j < first_invented
        )


def events_in(events: Events, kinds: Collection[EventKind] = COLLISION_KINDS) -> list[Event]:
    """Return the events of a `Result` of some kinds; the ball with the lower index is first."""
    kept = np.flatnonzero(np.isin(events["kind"], tuple(kinds)))
    columns = (events[name][kept].tolist() for name in ("kind", "a", "b", "t"))
    found = []
    for index, kind, a, b, t in zip(kept.tolist(), *columns, strict=True):
        number, one, other = lower_first(kind, a, b)
        found.append(Event(EventKind(number), one, other, t, index))
    return found


def collisions_of(events: Events) -> tuple[list[Key], FloatArray]:
    """Return the collisions of a `Result`, and their times (k,) [s]."""
    found = events_in(events)
    keys = [(int(one.kind), one.a, one.b) for one in found]
    return keys, np.array([one.t for one in found], dtype=np.float64)


def lower_first(kind: int, a: int, b: int) -> Key:
    """Return kind and bodies of an event; the ball with the lower index is first."""
    return (kind, b, a) if kind == EventKind.BALL_BALL and b < a else (kind, a, b)


def events_from(keys: Sequence[Key], times: FloatArray) -> list[Event]:
    """Return events with these times; without times, they get increasing integers.

    A closed form may give the order of events only; then the order is strict.
    """
    instants = times.tolist() if len(times) else range(1, len(keys) + 1)
    return [
        Event(EventKind(kind), a, b, float(t), index)
        for index, ((kind, a, b), t) in enumerate(zip(keys, instants, strict=True))
    ]


@lru_cache(maxsize=4)  # used for every engine's run
def events_of_certificate(certificate: Certificate) -> tuple[Event, ...]:
    """Return the events of a certificate, with times in double precision."""
    # Ties are found from these times, not from `CertifiedEvent.tie`. Events tie within 2^-100 s in
    # a certified result, but in an engine within much longer times.
    return tuple(Event(*event.key, float(event.t), k) for k, event in enumerate(certificate.events))


def compare_logs(
    true: Sequence[Event], other: Sequence[Event], *, strict: bool = False
) -> Agreement:
    """Compare two logs, each in order of time.

    `strict`: whether simultaneous events (within `TIE`) that share a ball have an order. An
        exact engine orders them; a time-stepping engine reports one time for all collisions of a
        step.
    """
    queues: dict[int, deque[int]] = defaultdict(deque)
    for found, one in enumerate(other):
        for ball in one.balls:
            queues[ball].append(found)
    stuck: set[int] = set()
    index_pairs: list[tuple[int, int]] = []
    missing: list[int] = []
    for at, one in enumerate(true):
        index: int | None = None
        if stuck.isdisjoint(one.balls):
            index = _next(one, other, queues)
            if index is None and not strict:
                index = _next_at_one_instant(true, at, other, queues)
        if index is None:
            stuck.update(one.balls)
            missing.append(at)
            continue
        index_pairs.append((at, index))
        for ball in one.balls:
            queues[ball].remove(index)
    invented = sorted({found for queue in queues.values() for found in queue})
    return Agreement(
        tuple((true[i], other[j]) for i, j in index_pairs),
        tuple(index_pairs),
        tuple(missing),
        tuple(invented),
        _first_parting([true[i] for i in missing], [other[j] for j in invented]),
    )


def compare_collisions(keys: Sequence[Key], times: FloatArray, events: Events) -> Agreement:
    """Compare reference collisions, with times if there are any, with those of an event log."""
    return compare_logs(events_from(keys, times), events_in(events))


def _next(one: Event, other: Sequence[Event], queues: dict[int, deque[int]]) -> int | None:
    """Return the index in the other log if the event is next for all its balls, else None."""
    heads = {queues[ball][0] if queues[ball] else None for ball in one.balls}
    index = heads.pop()
    if heads or index is None or other[index].key != one.key:
        return None
    return index


def _next_at_one_instant(
    true: Sequence[Event], at: int, other: Sequence[Event], queues: dict[int, deque[int]]
) -> int | None:
    """Return the index in the other log if only simultaneous events come before it, else None."""
    one = true[at]
    index = next((i for i in queues[one.a] if other[i].key == one.key), None)
    if index is None:
        return None
    tied = {two.key for two in _tied_with(true, at)}
    for ball in one.balls:
        for earlier in queues[ball]:
            if earlier == index:
                break
            before = other[earlier]
            if before.key not in tied and not _one_instant(before.t, other[index].t):
                return None
    return index


def _tied_with(log: Sequence[Event], at: int) -> list[Event]:
    """Return the later events of a log at the same instant as the one with the index `at`."""
    tied = []
    for one in log[at + 1 :]:
        if not _one_instant(log[at].t, one.t):
            break
        tied.append(one)
    return tied


def _one_instant(t: float, later: float) -> bool:
    return later - t <= TIE * later


def _first_parting(lost: Sequence[Event], extra: Sequence[Event]) -> Parting | None:
    """Return the first event that one log lacks, with the other log's next event of its balls."""
    if not lost and not extra:
        return None
    if not extra or (lost and lost[0].t <= extra[0].t):
        return Parting(lost[0], _sharing(extra, lost[0]))
    return Parting(_sharing(lost, extra[0]), extra[0])


def _sharing(log: Sequence[Event], one: Event) -> Event | None:
    return next((two for two in log if not set(two.balls).isdisjoint(one.balls)), None)
