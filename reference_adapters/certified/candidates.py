"""Candidates for the next event, ordered by guaranteed lower bounds of their times."""

from __future__ import annotations

import heapq
import math
from collections import defaultdict
from itertools import count

from flint import arb

from ghostball.reference_adapters.certified.certificate import Choice
from ghostball.reference_adapters.certified.meetings import Meeting, meeting
from ghostball.reference_adapters.certified.motion import Body
from ghostball.reference_adapters.certified.obstacle_gaps import Gap
from ghostball.reference_adapters.certified.roots import NONE, Bracket

_SLACK = 1e-9
"""Time by which a bound in doubles is moved earlier [s], far more than its error."""


class Candidate:
    """A candidate for the next event; void once one of its bodies is outdated.

    Its time is enclosed in an interval, or only bounded by a search in doubles.
    """

    __slots__ = ("bodies", "bracket", "choice", "gap", "key", "meeting")

    def __init__(
        self,
        choice: Choice,
        bodies: tuple[Body, ...],
        gap: Gap | None = None,
        *,
        bracket: Bracket | None = None,
        found: Meeting | None = None,
    ) -> None:
        self.choice = choice
        self.bodies = bodies
        self.gap = gap
        self.bracket = bracket
        self.meeting = found
        self.key = self._bound()

    def _bound(self) -> float:
        """Return a time before which the event certainly doesn't happen [s]."""
        if self.meeting is not None:
            bound = math.nextafter(float(self.meeting.t.lower()), -math.inf)
            # If the intervals are too wide, the candidate comes first and is undecided.
            return bound if math.isfinite(bound) else -math.inf
        assert self.gap is not None
        assert self.bracket is not None
        earliest = float((self.gap.t + self.bracket.low).lower())
        return earliest - _SLACK * (1.0 + abs(earliest) * 1e-3)

    def find(self, bits: int) -> bool:
        """Enclose the time of the event, if necessary; return False if it never happens."""
        if self.meeting is None:
            assert self.gap is not None
            assert self.bracket is not None
            self.meeting = meeting(self.gap, self.bracket, bits)
            if self.meeting is None:
                return False
            self.key = self._bound()
        return True

    @property
    def instant(self) -> arb:
        """Time of the event; if unknown, a time before which it doesn't happen [s]."""
        assert self.meeting is not None
        return self.meeting.t

    @property
    def age(self) -> arb:
        """Time of the event since the start of its gap or ball [s]; only for a known event."""
        assert self.meeting is not None
        assert self.meeting.s is not None
        return self.meeting.s

    @property
    def known(self) -> bool:
        """Whether the event certainly happens, at a known time."""
        return self.meeting is not None and self.meeting.s is not None

    @property
    def rank(self) -> tuple[int, int, int]:
        """Sorting key among simultaneous events: kind, then balls."""
        return (int(self.choice.kind), self.choice.a, self.choice.b)

    @property
    def balls(self) -> tuple[int, ...]:
        """Indices of the balls of the event."""
        return self.choice.balls

    def is_void(self, bodies: list[Body]) -> bool:
        """Return True if one of its bodies isn't in `bodies`, the present bodies of all balls."""
        return any(bodies[k] is not b for k, b in zip(self.balls, self.bodies, strict=True))


class Agenda:
    """All candidates, ordered by their bounds."""

    def __init__(self, bits: int) -> None:
        self._bits = bits
        self._heap: list[tuple[float, int, Candidate]] = []
        self._ticket = count()
        # Candidates by ball, in the order in which they were added. In a long shot, the heap
        # contains thousands of void candidates, which must not be searched for each event.
        self._by_ball: defaultdict[int, dict[Candidate, None]] = defaultdict(dict)

    def add(self, candidate: Candidate) -> None:
        """Add a candidate."""
        heapq.heappush(self._heap, (candidate.key, next(self._ticket), candidate))
        for k in candidate.balls:
            self._by_ball[k][candidate] = None

    def _take(self) -> Candidate:
        _, _, candidate = heapq.heappop(self._heap)
        for k in candidate.balls:
            self._by_ball[k].pop(candidate, None)
        return candidate

    def add_searched(self, gap: Gap, bodies: tuple[Body, ...], high: float) -> None:
        """Search a gap in doubles up to a time [s], and add a candidate if the gap may close."""
        bracket = gap.search_in_doubles(high)
        if bracket.verdict != NONE:
            self.add(Candidate(gap.choice, bodies, gap, bracket=bracket))

    def sharing(self, candidate: Candidate, bodies: list[Body]) -> list[Candidate]:
        """Return the valid candidates that share a ball with a removed candidate."""
        found: dict[Candidate, None] = {}
        for k in candidate.balls:
            self._by_ball[k] = {one: None for one in self._by_ball[k] if not one.is_void(bodies)}
            found |= self._by_ball[k]
        return list(found)

    def take_first(self, bodies: list[Body]) -> list[Candidate]:
        """Remove and return all valid candidates that may come first, with enclosed times.

        All remaining candidates come later than the earliest known candidate among them.
        """
        group: list[Candidate] = []
        latest = math.inf
        while self._heap and self._heap[0][0] <= latest:
            candidate = self._take()
            if candidate.is_void(bodies):
                continue
            if candidate.meeting is None:
                if candidate.find(self._bits):
                    self.add(candidate)
                continue
            group.append(candidate)
            if candidate.known:
                upper = float(candidate.instant.upper())
                latest = min(latest, math.nextafter(upper, math.inf))
        return group
