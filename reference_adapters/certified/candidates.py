"""Events that may come next, in the order of sure bounds; and which of them may be first."""

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
"""By how much a bound in doubles is put earlier [s]: far more than doubles err."""


class Candidate:
    """An event that may come next; void once one of its bodies is no longer the ball's.

    Either when it happens is known, or only a search in doubles was made of its gap, for a bound.
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
        """Return an instant before which it surely doesn't happen [s]."""
        if self.meeting is not None:
            bound = math.nextafter(float(self.meeting.t.lower()), -math.inf)
            # Where numbers have become too wide for anything: first of all, and undecided.
            return bound if math.isfinite(bound) else -math.inf
        assert self.gap is not None
        assert self.bracket is not None
        earliest = float((self.gap.t + self.bracket.low).lower())
        return earliest - _SLACK * (1.0 + abs(earliest) * 1e-3)

    def find(self, bits: int) -> bool:
        """Enclose when it happens, if that wasn't done yet; False where it never does."""
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
        """When it happens; or, where that isn't known, an instant before which it doesn't [s]."""
        assert self.meeting is not None
        return self.meeting.t

    @property
    def age(self) -> arb:
        """How long after the instant of its gap, or of its ball, it happens [s]; of a known one."""
        assert self.meeting is not None
        assert self.meeting.s is not None
        return self.meeting.s

    @property
    def known(self) -> bool:
        """Whether it is known to happen, and when."""
        return self.meeting is not None and self.meeting.s is not None

    @property
    def rank(self) -> tuple[int, int, int]:
        """Its place among events of one instant: by kind, then by ball."""
        return (int(self.choice.kind), self.choice.a, self.choice.b)

    @property
    def balls(self) -> tuple[int, ...]:
        """Indices of its balls."""
        return self.choice.balls

    def is_void(self, bodies: list[Body]) -> bool:
        """Return True if one of its bodies is no longer the ball's, in `bodies` of all balls."""
        return any(bodies[k] is not b for k, b in zip(self.balls, self.bodies, strict=True))


class Agenda:
    """All candidates, the one with the earliest bound first."""

    def __init__(self, bits: int) -> None:
        self._bits = bits
        self._heap: list[tuple[float, int, Candidate]] = []
        self._ticket = count()
        # By ball, in the order of their tickets. A long shot leaves thousands of void candidates on
        # the heap, through which no event may search.
        self._of: defaultdict[int, dict[Candidate, None]] = defaultdict(dict)

    def add(self, candidate: Candidate) -> None:
        """Put a candidate on the agenda."""
        heapq.heappush(self._heap, (candidate.key, next(self._ticket), candidate))
        for k in candidate.balls:
            self._of[k][candidate] = None

    def _take(self) -> Candidate:
        _, _, candidate = heapq.heappop(self._heap)
        for k in candidate.balls:
            self._of[k].pop(candidate, None)
        return candidate

    def add_searched(self, gap: Gap, bodies: tuple[Body, ...], high: float) -> None:
        """Search a gap in doubles up to a time [s]; note it where it may close."""
        bracket = gap.search_in_doubles(high)
        if bracket.verdict != NONE:
            self.add(Candidate(gap.choice, bodies, gap, bracket=bracket))

    def sharing(self, candidate: Candidate, bodies: list[Body]) -> list[Candidate]:
        """Return the candidates on the agenda that share a ball with one taken off; none void."""
        found: dict[Candidate, None] = {}
        for k in candidate.balls:
            self._of[k] = {one: None for one in self._of[k] if not one.is_void(bodies)}
            found |= self._of[k]
        return list(found)

    def take_first(self, bodies: list[Body]) -> list[Candidate]:
        """Take off all candidates that may be first, each enclosed; those not void.

        All that stay come later than the earliest of these that is known.
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
