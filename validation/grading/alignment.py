"""Align the events that an engine found with the proved ones: what it missed, what it invented.

An alignment pairs events that are alike (kind and balls) so that as few as possible are left over.
Pairs keep their order, but for events of one instant that share no ball: their order is a
convention, and either is right. Sequences that agree are aligned in linear time; from where they
differ on, by their longest common subsequence.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import EventKind
from ghostball.engine.result import Events
from ghostball.reference_adapters.certified import Certificate, Choice
from ghostball.validation.grading.tolerances import TIE

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

PIECE = 4096
"""Events of each log, from a difference on, that are aligned at once: the best pairs among these.

Half of them are then kept, and the search goes on from there, so that the work for one event is
bounded: sixteen million comparisons for a piece, 64 at a time.
"""

_TRIED = 4
"""Events on either side of an instant that are tried as partners of one out of order."""

ALL_KINDS = tuple(EventKind)


@dataclass(frozen=True, eq=False)
class Log:
    """Events in order of time.

    Attributes
    ----------
    choices : sequence of Choice
        What happened to whom; of two balls the lower one first.
    times : (k,) float64 [s]
    windows : (k,) int64
        Events with the same number are at one instant.
    indices : (k,) int64
        Of each event where it comes from; increasing.
    """

    choices: Sequence[Choice]
    times: FloatArray
    windows: IntArray
    indices: IntArray

    def __len__(self) -> int:
        return len(self.choices)

    def only(self, kept: NDArray[np.bool_]) -> Log:
        """Return the log of some of the events, (k,) bool."""
        chosen = np.flatnonzero(kept)
        return Log(
            [self.choices[k] for k in chosen.tolist()],
            self.times[chosen],
            self.windows[chosen],
            self.indices[chosen],
        )


@dataclass(frozen=True)
class Difference:
    """Where two logs first differ.

    Attributes
    ----------
    what : "missing" or "invented"
        Proved but not found, or found but not proved.
    index : int
        Of the event where it comes from.
    event : Choice
    t : float [s]
        When it comes.
    competitor : Choice or None
        What the other log has in its place; None where that log has ended.
    competitor_t : float [s] or None
    """

    what: Literal["missing", "invented"]
    index: int
    event: Choice
    t: float
    competitor: Choice | None
    competitor_t: float | None

    def describe(self, ids: tuple[str, ...]) -> str:
        """Return it as a sentence, with the names of the balls."""
        missing = self.what == "missing"
        fault = "is proved but was not found" if missing else "was found but is not so"
        if self.competitor is None:
            other = f"the {'found' if missing else 'proved'} events end before it"
        else:
            other = (
                f"{'found' if missing else 'proved'} in its place: "
                f"{self.competitor.describe(ids)} at t = {self.competitor_t:.17g} s"
            )
        return f"{self.event.describe(ids)} at t = {self.t:.17g} s {fault}; {other}"


@dataclass(frozen=True, eq=False)
class Alignment:
    """Two logs, event by event.

    Attributes
    ----------
    proved, found : (m,) int64
        Indices of the pairs where the events come from, in the order of the proved ones.
    missing : (k,) int64
        Indices of proved events that were not found.
    invented : (l,) int64
        Indices of found events that are not so.
    first : Difference or None
        The earliest of both; None where the logs agree.
    """

    proved: IntArray
    found: IntArray
    missing: IntArray
    invented: IntArray
    first: Difference | None


@lru_cache(maxsize=4)  # every engine's run is aligned with it, and looks its times up
def proved_log(certificate: Certificate) -> Log:
    """Return the log of a certificate's events."""
    # By the instants, not by `CertifiedEvent.tie`: they tie where the proof has no order of them,
    # 2^-100 s, and also where an engine can't have one, which is far more.
    times = np.array([float(event.t) for event in certificate.events])
    return log_of([Choice(*event.key) for event in certificate.events], times)


def found_log(events: Events) -> Log:
    """Return the log of the events of a `Result`."""
    columns = (events[name].tolist() for name in ("kind", "a", "b"))
    choices = [_lower_first(EventKind(kind), a, b) for kind, a, b in zip(*columns, strict=True)]
    return log_of(choices, events["t"].astype(np.float64))


def log_of(choices: Sequence[Choice], times: FloatArray) -> Log:
    """Return the log of events that come at `times`, (k,) [s]; those within `TIE` tie."""
    apart = np.diff(times) > TIE * times[1:]
    windows = np.concatenate(([0], np.cumsum(apart)))[: len(times)]
    return Log(choices, times, windows.astype(np.int64), np.arange(len(times)))


def align(proved: Log, found: Log) -> Alignment:
    """Align two logs: pairs of events that are alike, with as few as possible left over.

    Two pairs may cross only where their events share no ball and are at one instant in either log
    (an engine that reports one time for several says nothing of their order). Of alignments that
    are as good, events of several that are alike go with the ones nearest in time.

    Notes
    -----
    The longest common subsequence is found by bit vectors (Crochemore, Iliopoulos, Pinzon & Reid
    2001, Inf. Process. Lett. 80 279), piece by piece where logs are longer than `PIECE` events: it
    is the best of all where what follows the first difference fits into one.
    """
    codes = _codes(proved, found)
    ours, theirs = _common(codes[0].tolist(), codes[1].tolist())
    _slide(codes[0], proved.times, ours, theirs, found.times)
    _slide(codes[1], found.times, theirs, ours, proved.times)
    p, q = _cross(proved, found, codes, np.array(ours, dtype=int), np.array(theirs, dtype=int))
    missing = np.setdiff1d(np.arange(len(proved)), p)
    invented = np.setdiff1d(np.arange(len(found)), q)
    return Alignment(
        proved.indices[p],
        found.indices[q],
        proved.indices[missing],
        found.indices[invented],
        _first(proved, found, p, q, missing, invented),
    )


def _lower_first(kind: EventKind, a: int, b: int) -> Choice:
    if kind is EventKind.BALL_BALL and b < a:
        a, b = b, a
    return Choice(kind, a, b)


def _codes(proved: Log, found: Log) -> tuple[IntArray, IntArray]:
    """Return a number for each event, the same for those that are alike."""
    numbers: dict[Choice, int] = {}
    proved_codes, found_codes = (
        np.array([numbers.setdefault(c, len(numbers)) for c in log.choices], dtype=np.int64)
        for log in (proved, found)
    )
    return proved_codes, found_codes


def _common(a: list[int], b: list[int]) -> tuple[list[int], list[int]]:
    """Return indices of pairs that are alike, increasing in both."""
    first: list[int] = []
    second: list[int] = []
    i = j = 0
    while i < len(a) and j < len(b):
        if a[i] == b[j]:
            first.append(i)
            second.append(j)
            i, j = i + 1, j + 1
            continue
        last = len(a) - i <= PIECE and len(b) - j <= PIECE
        pairs = _common_subsequence(a[i : i + PIECE], b[j : j + PIECE])
        if not last:
            pairs = [(p, q) for p, q in pairs if max(p, q) < PIECE // 2]
        first += [i + p for p, _ in pairs]
        second += [j + q for _, q in pairs]
        if last:
            break
        if pairs:
            i, j = i + pairs[-1][0] + 1, j + pairs[-1][1] + 1
        elif len(a) - i > len(b) - j:  # the first halves have nothing in common
            i += PIECE // 2
        else:
            j += PIECE // 2
    return first, second


def _common_subsequence(a: list[int], b: list[int]) -> list[tuple[int, int]]:
    """Return the longest common subsequence, its pairs as early as possible."""
    places: dict[int, int] = defaultdict(int)
    for j, code in enumerate(reversed(b)):
        places[code] |= 1 << j
    full = (1 << len(b)) - 1
    # rows[i]: bit j is 0 where the common part of a[i:] grows from the last j to the last j + 1
    # of b.
    rows = [full]
    for code in reversed(a):
        row = rows[-1]
        hits = row & places.get(code, 0)
        rows.append(((row + hits) | (row - hits)) & full)
    rows.reverse()

    def length(i: int, j: int) -> int:
        left = len(b) - j
        return left - (rows[i] & ((1 << left) - 1)).bit_count()

    pairs, i, j = [], 0, 0
    while i < len(a) and j < len(b):
        if a[i] == b[j]:
            pairs.append((i, j))
            i, j = i + 1, j + 1
        elif length(i + 1, j) == length(i, j):
            i += 1
        else:
            j += 1
    return pairs


def _slide(
    codes: IntArray, times: FloatArray, own: list[int], others: list[int], other_times: FloatArray
) -> None:
    """Move runs of events without a partner to earlier ones that are alike, by the times.

    Of A A A and A A the last A has no partner, until the times say which one it is. `own` and
    `others` are indices of the pairs, and `own` is changed; both increase.
    """
    for r in range(len(own), 0, -1):
        end = own[r] if r < len(own) else len(codes)
        free = end - own[r - 1] - 1  # events between two pairs
        if free == 0:
            continue
        cost = best = 0.0
        take = 0
        for k in range(1, min(r, PIECE) + 1):
            there, moved = own[r - k], own[r - k] + free
            if k > 1 and there + 1 != own[r - k + 1]:
                break
            if codes[there] != codes[moved]:
                break
            t = other_times[others[r - k]]
            cost += abs(times[moved] - t) - abs(times[there] - t)
            if cost < best:
                best, take = cost, k
        for k in range(1, take + 1):
            own[r - k] += free


def _cross(
    proved: Log, found: Log, codes: tuple[IntArray, IntArray], p: IntArray, q: IntArray
) -> tuple[IntArray, IntArray]:
    """Add the pairs of one instant that cross others, sorted by the proved event."""
    free: dict[int, list[int]] = defaultdict(list)
    for j in np.setdiff1d(np.arange(len(found)), q).tolist():
        free[int(codes[1][j])].append(j)
    many_proved, many_found = (np.bincount(log.windows) > 1 for log in (proved, found))
    for i in np.setdiff1d(np.arange(len(proved)), p).tolist():
        alike = free.get(int(codes[0][i]), [])
        nearest = bisect_left(alike, proved.times[i], key=found.times.__getitem__)
        for j in alike[max(nearest - _TRIED, 0) : nearest + _TRIED]:
            if not (many_proved[proved.windows[i]] or many_found[found.windows[j]]):
                continue
            crossed = (p < i) != (q < j)
            tied = (proved.windows[p[crossed]] == proved.windows[i]) | (
                found.windows[q[crossed]] == found.windows[j]
            )
            if tied.all() and not any(
                _share(proved.choices[i], proved.choices[k]) for k in p[crossed]
            ):
                p, q = np.append(p, i), np.append(q, j)
                alike.remove(j)
                break
    order = np.argsort(p)
    return p[order], q[order]


def _share(a: Choice, b: Choice) -> bool:
    return not _balls(a).isdisjoint(_balls(b))


def _balls(choice: Choice) -> frozenset[int]:
    pair = choice.kind is EventKind.BALL_BALL
    return frozenset((choice.a, choice.b) if pair else (choice.a,))


def _first(
    proved: Log, found: Log, p: IntArray, q: IntArray, missing: IntArray, invented: IntArray
) -> Difference | None:
    """Return the earliest event without a partner; a missing one before an invented one."""
    candidates = []
    if len(missing):
        candidates.append(_difference("missing", int(missing[0]), proved, p, found, q))
    if len(invented):
        candidates.append(_difference("invented", int(invented[0]), found, q, proved, p))
    return min(candidates, key=lambda difference: difference.t, default=None)


def _difference(
    what: Literal["missing", "invented"],
    index: int,
    own: Log,
    own_pairs: IntArray,
    other: Log,
    other_pairs: IntArray,
) -> Difference:
    """Describe an event without a partner; before it every event has one."""
    before = other_pairs[own_pairs < index]
    place = int(before.max()) + 1 if len(before) else 0
    competitor = other.choices[place] if place < len(other) else None
    return Difference(
        what,
        int(own.indices[index]),
        own.choices[index],
        float(own.times[index]),
        competitor,
        None if competitor is None else float(other.times[place]),
    )
