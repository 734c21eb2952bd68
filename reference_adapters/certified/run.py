"""One run of a problem in one precision: event after event, each proved to be the next.

Bounds in doubles, on the safe side, say which candidates need a proof at all; those that may be
first are enclosed in balls and compared. What can't be told is raised, and `certify` widens the
precision and starts again.
"""

from __future__ import annotations

import heapq
import math
import time
from itertools import count

from flint import arb

from engine import EventKind
from reference_adapters.certified.arithmetic import (
    ZERO,
    SustainedContactError,
    UndecidedError,
    Vector,
    exactly,
)
from reference_adapters.certified.certificate import Choice, Ending
from reference_adapters.certified.gaps import (
    SIDES,
    CushionGap,
    Meeting,
    PairGap,
    cushion_choice,
    meeting,
    meeting_again,
)
from reference_adapters.certified.laws import Laws, Seen, seen_along, seen_from_table
from reference_adapters.certified.motion import Body, body_at_start
from reference_adapters.certified.problem import Problem
from reference_adapters.certified.roots import NONE, Bracket

HOP = 2.0**-18
"""Height of a hop, in diameters, at which a contact counts as sustained: 2e-7 m for pool balls.

A ball that friction presses against another, or a cushion, bounces ever lower, without end in a
finite time. Where a rebound at the speed of approach would not rise higher, the contact holds from
there on; the model that is certified says so too (README, "What our engine models").
"""

LOW_HOPS = 4
"""Hops of one contact in a row, each no higher than `HOP`, that are taken for an endless series.

So it goes where friction presses only in between: a ball that rolls up to a resting one touches it
again and again, since the one that it hit stops at once.
"""

TIE_BITS = 100
"""Events of different balls that are within 2^-100 s count as simultaneous.

Either order then has the same outcome, which is proved; some are at one instant by the laws, as
when a rolling ball hits a resting one and both slides end together.
"""

_SPEED_LIMIT = 1e9  # [m/s], beyond what a scene may hold
_SAME_INSTANT = 10_000
"""Impacts at one instant after which they are taken for an endless series."""

_SLACK = 1e-9
"""By how much a bound in doubles is put earlier [s]: far more than doubles err."""


class Candidate:
    """An event that may come next; void once one of its bodies is no longer the ball's."""

    __slots__ = ("bodies", "bracket", "choice", "gap", "key", "meeting")

    def __init__(
        self,
        choice: Choice,
        bodies: tuple[Body, ...],
        gap: PairGap | CushionGap | None,
        bracket: Bracket | None,
        found: Meeting | None,
    ) -> None:
        self.choice = choice
        self.bodies = bodies
        self.gap = gap
        self.bracket = bracket
        self.meeting = found
        self.key = self._key()

    def _key(self) -> float:
        if self.meeting is not None:
            key = math.nextafter(float(self.meeting.t.lower()), -math.inf)
            # Where numbers have become too wide for anything: first of all, and undecided.
            return key if math.isfinite(key) else -math.inf
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
            self.key = self._key()
        return True

    @property
    def instant(self) -> arb:
        """When it happens; or, where that can't be told, an instant before which it doesn't [s]."""
        assert self.meeting is not None
        return self.meeting.t

    @property
    def rank(self) -> tuple[int, int, int]:
        """Its place among events of one instant: by kind, then by ball."""
        return (int(self.choice.kind), self.choice.a, self.choice.b)

    @property
    def balls(self) -> tuple[int, ...]:
        """Indices of its balls."""
        c = self.choice
        return (c.a, c.b) if c.kind is EventKind.BALL_BALL else (c.a,)


class Run:
    """One run.

    Attributes
    ----------
    bodies : list of Body
        Each ball from the last event that concerned it.
    now : arb [s]
        The last event's instant.
    events : list of (Choice, arb, bool)
        What is proved: event, instant, and whether its place is a convention.
    knots : list of (ball, Body), in order of time
    ended : bool
        Whether the run reached its natural end.
    """

    def __init__(self, problem: Problem, bits: int) -> None:
        self.bits = bits
        self.now = ZERO
        self.order = 0
        self.events: list[tuple[Choice, arb, bool]] = []
        self.ended = False
        self.rested = False
        self._problem = problem
        self._laws = Laws(problem)
        self._t_max = None if problem.t_max is None else arb(problem.t_max)
        self._heap: list[tuple[float, int, Candidate]] = []
        self._ticket = count()
        self._here = 0
        self.bodies: list[Body] = []
        self.knots: list[tuple[int, Body]] = []
        self._touching: set[tuple[int, int]] = set()
        self._railed: set[tuple[int, int]] = set()
        self._still: dict[tuple[int, int], tuple[Body, Body]] = {}  # hit without restitution
        self._hops: dict[tuple[EventKind, int, int], tuple[float, float, int]] = {}

    def go(self, max_events: int, deadline: float) -> Ending:
        """Run on until the end, `max_events` events, or `deadline` of `time.perf_counter`.

        Returns "proved", "event limit" or "time limit".

        Raises
        ------
        UndecidedError
            Where this precision can't tell what comes next.
        SustainedContactError
            Where a contact is sustained from here on.
        """
        if not self.bodies:
            self._begin()
        while True:
            if len(self.events) >= max_events:
                return "event limit"
            if time.perf_counter() > deadline:
                return "time limit"
            chosen, tie = self._next()
            if chosen is None:
                self.ended = True
                self.rested = all(body.resting for body in self.bodies)
                return "proved"
            self._resolve(chosen)
            self.events.append((chosen.choice, self.now, tie))
            for k in chosen.balls:
                self.knots.append((k, self.bodies[k]))
            self._predict_touched(chosen.balls)

    # -- what may come next ----------------------------------------------------------------------

    def _begin(self) -> None:
        balls = self._problem.balls
        for i, ball in enumerate(balls):
            self.bodies.append(body_at_start(ball, self._problem))
            self.knots.append((i, self.bodies[i]))
        self._note_contacts()
        for i in range(len(balls)):
            self._predict_alone(i)
            for j in range(i):
                self._predict_pair(j, i)

    def _note_contacts(self) -> None:
        """Note which balls touch each other, and cushions, by the scene's very numbers."""
        balls = self._problem.balls
        for i, ball in enumerate(balls):
            for j, other in enumerate(balls[:i]):
                dx, dy = ball.x - other.x, ball.y - other.y
                reach = ball.radius + other.radius
                if abs(dx * dx + dy * dy - reach * reach) > 1e-9 * reach * reach:
                    continue
                x, y = exactly(ball.x) - exactly(other.x), exactly(ball.y) - exactly(other.y)
                r = exactly(ball.radius) + exactly(other.radius)
                if x * x + y * y == r * r:
                    self._touching.add((j, i))
            for cushion, line in enumerate(self._problem.noses):
                if line is None:
                    continue
                place = exactly(ball.x) if cushion < 2 else exactly(ball.y)
                across = (place - exactly(line)) * (-1 if cushion % 2 else 1)
                if across == exactly(ball.radius):
                    self._railed.add((i, cushion))

    def _push(self, candidate: Candidate) -> None:
        heapq.heappush(self._heap, (candidate.key, next(self._ticket), candidate))

    def _predict_alone(self, i: int) -> None:
        """Predict what ball i does alone: its phase ends, it meets a cushion."""
        body = self.bodies[i]
        if body.resting:
            return
        if body.duration is not None:
            choice = Choice(body.end_kind, i, -1)
            s = body.duration
            self._push(Candidate(choice, (body,), None, None, Meeting(s, body.t + s)))
        for cushion, line in enumerate(self._problem.noses):
            if line is None:
                continue
            gap = CushionGap(body, line, cushion_choice(i, cushion))
            high = self._window(body.end, body)
            if (i, cushion) in self._railed:
                found = meeting_again(gap, high, self.bits)
                if found is not None:
                    self._push(Candidate(gap.choice, (body,), gap, None, found))
                continue
            self._push_quick(gap, (body,), high)

    def _push_quick(self, gap: PairGap | CushionGap, bodies: tuple[Body, ...], high: float) -> None:
        bracket = gap.quick(high)
        if bracket.verdict != NONE:
            self._push(Candidate(gap.choice, bodies, gap, bracket, None))

    def _predict_pair(self, i: int, j: int) -> None:
        """Predict when balls i < j meet, while both go on as they do."""
        a, b = self.bodies[i], self.bodies[j]
        if a.resting and b.resting:
            return
        gap = PairGap(a, b, Choice(EventKind.BALL_BALL, i, j))
        later = a if a.order >= b.order else b
        high = self._window(min(a.end, b.end), later)
        if (i, j) in self._touching:
            found = meeting_again(gap, high, self.bits, still=self._still.get((i, j)) == (a, b))
            if found is not None:
                self._push(Candidate(gap.choice, (a, b), gap, None, found))
            elif not (a.resting and b.resting) and self._moves_as_one(gap):
                raise SustainedContactError("they move as one", (gap.choice,), gap.t)
            return
        self._push_quick(gap, (a, b), high)

    @staticmethod
    def _moves_as_one(gap: PairGap) -> bool:
        return all(c.is_zero() for c in gap.coefficients()[1:])

    def _window(self, end: float, later: Body) -> float:
        """Return how long after the later instant motions with this end need a search [s].

        A little longer than they last: what happens at the very end has to be seen.
        """
        if self._problem.t_max is not None:
            end = min(end, self._problem.t_max)
        return max(end - float(later.t.lower()), 0.0) * (1.0 + 2.0**-20) + 2.0**-30

    # -- which comes next ------------------------------------------------------------------------

    def _next(self) -> tuple[Candidate | None, bool]:
        """Return the next event, and whether its place is a convention; None is the end."""
        group = self._first_group()
        if not group:
            return None, False
        first = group[0]
        for c in group[1:]:
            earlier, later = c.instant.mid(), first.instant.mid()
            if earlier < later or (earlier == later and c.rank < first.rank):
                first = c
        assert first.meeting is not None
        t = first.instant
        rivals = [c for c in group if c is not first and not c.instant > t]
        if self._t_max is not None:
            if t > self._t_max:
                return None, False
            if not t <= self._t_max:
                raise UndecidedError("whether it comes before `t_max`", (first.choice,), t)
        choices = (first.choice, *(c.choice for c in rivals))
        if first.meeting.s is None:
            what = "whether they touch" if len(choices) == 1 else "what comes first"
            raise UndecidedError(what, choices, t)
        if rivals:
            self._check_tie(first, rivals, choices)
        for c in group:
            if c is not first:
                self._push(c)
        return first, bool(rivals)

    def _first_group(self) -> list[Candidate]:
        """Take all candidates off the heap that may be first; each enclosed."""
        group: list[Candidate] = []
        latest = math.inf
        while self._heap and self._heap[0][0] <= latest:
            _, _, candidate = heapq.heappop(self._heap)
            if not self._valid(candidate):
                continue
            if candidate.meeting is None:
                if candidate.find(self.bits):
                    self._push(candidate)
                continue
            group.append(candidate)
            if candidate.meeting.s is not None:
                upper = float(candidate.instant.upper())
                latest = min(latest, math.nextafter(upper, math.inf))
        return group

    def _valid(self, candidate: Candidate) -> bool:
        return all(
            self.bodies[k] is body
            for k, body in zip(candidate.balls, candidate.bodies, strict=True)
        )

    def _check_tie(
        self, first: Candidate, rivals: list[Candidate], choices: tuple[Choice, ...]
    ) -> None:
        """Let events pass that can't be ordered but needn't be; raise for the others."""
        t = first.instant
        for c in rivals:
            assert c.meeting is not None
            if c.meeting.s is None or set(c.balls) & set(first.balls):
                exact = c.meeting.t is t and c.meeting.s is not None
                raise UndecidedError("what comes first", choices, t, exact=exact)
            t = t.union(c.meeting.t)
        width = float(t.rad().upper()) * 2.0
        if not width <= 2.0**-TIE_BITS:
            raise UndecidedError("what comes first", choices, t)
        if not all(self._isolated(c, t, width) for c in (first, *rivals)):
            raise UndecidedError("whether the order matters", choices, t)

    def _isolated(self, candidate: Candidate, t: arb, width: float) -> bool:
        """Whether no other ball is near enough to a candidate's to feel it within `width` [s]."""
        reach = 4.0 * _SPEED_LIMIT * width + 1e-12
        for k in candidate.balls:
            x, y = self._place(k, t)
            for m, body in enumerate(self.bodies):
                if m in candidate.balls:
                    continue
                ox, oy = self._place(m, t)
                least = self.bodies[k].constants.radius + body.constants.radius + reach
                dx, dy = x - ox, y - oy
                if not dx * dx + dy * dy > least * least:
                    return False
        return True

    def _place(self, k: int, t: arb) -> tuple[arb, arb]:
        body = self.bodies[k]
        return (body.x, body.y) if body.resting else body.position_after(t - body.t)

    # -- what it does ----------------------------------------------------------------------------

    def _resolve(self, chosen: Candidate) -> None:
        """Move the clock to an event, and its balls on from there.

        Nothing is changed where the outcome can't be told.
        """
        found, choice = chosen.meeting, chosen.choice
        assert found is not None
        assert found.s is not None
        same = found.t is self.now
        if same and self._here == _SAME_INSTANT:
            raise SustainedContactError("impacts without end at one instant", (choice,), self.now)
        order = self.order if same else self.order + 1
        try:
            if choice.kind is EventKind.BALL_BALL:
                bodies = self._collided(chosen, found, order)
            elif choice.kind is EventKind.BALL_CUSHION:
                bodies = (self._bounced(chosen, found, order),)
            else:
                bodies = (chosen.bodies[0].after_phase(found.t, order),)
        except UndecidedError as error:
            raise UndecidedError(error.what, (choice,), found.t) from None
        if same:
            self._here += 1
        else:
            self._start_instant(found.t)
        for k, body in zip(chosen.balls, bodies, strict=True):
            self.bodies[k] = body
        if choice.kind is EventKind.BALL_BALL:
            self._touching.add((choice.a, choice.b))
            if self._problem.ball_restitution == 0.0:
                self._still[choice.a, choice.b] = (bodies[0], bodies[1])
        elif choice.kind is EventKind.BALL_CUSHION:
            self._railed.add((choice.a, choice.b))

    def _predict_touched(self, balls: tuple[int, ...]) -> None:
        for k in balls:
            self._predict_alone(k)
            for m in range(len(self.bodies)):
                if m != k and not (m in balls and m > k):
                    self._predict_pair(min(k, m), max(k, m))

    def _start_instant(self, t: arb) -> None:
        """Move the clock on: contacts of balls that moved since are gone."""
        self.now = t
        self.order += 1
        self._here = 0
        bodies = self.bodies
        self._touching = {
            (i, j) for i, j in self._touching if bodies[i].resting and bodies[j].resting
        }
        self._railed = {(i, c) for i, c in self._railed if self._stays_on_rail(i, c)}

    def _stays_on_rail(self, i: int, cushion: int) -> bool:
        body = self.bodies[i]
        v, a = (body.vx, body.ax) if SIDES[cushion][0] else (body.vy, body.ay)
        return bool(v.is_zero() and a.is_zero())

    def _collided(self, chosen: Candidate, found: Meeting, order: int) -> tuple[Body, ...]:
        """Return both balls after their impact."""
        gap, s, t = chosen.gap, found.s, found.t
        assert isinstance(gap, PairGap)
        assert s is not None
        i, j = chosen.balls
        n = gap.normal(s, touching=not s.is_zero() or (i, j) in self._touching)
        (vx, vy), (ax, ay) = gap.rate(s), gap.pull()
        rate, across = n[0] * vx + n[1] * vy, n[0] * vy - n[1] * vx
        opening = across * across / gap.reach + n[0] * ax + n[1] * ay
        self._check_hop(chosen, t, rate, opening, gap.reach)
        self._count_hop(chosen, t, rate, gap.reach)
        places, seen = [], []
        for body in chosen.bodies:
            # The gap's own time is narrower than a difference of instants.
            dt = s if body.t is gap.t else (gap.t - body.t) + s
            moved = ZERO if body.resting else dt
            places.append(body.position_after(moved))
            v, u = body.velocity_after(moved), body.slip_after(moved)
            seen.append(seen_along(n, v, u, body.spin_after(dt), body.constants.radius))
        after = self._laws.collide(i, j, seen[0], seen[1])
        return tuple(
            self._sent_off(body, n, place, ball, t, order)
            for body, place, ball in zip(chosen.bodies, places, after, strict=True)
        )

    def _bounced(self, chosen: Candidate, found: Meeting, order: int) -> Body:
        """Return a ball after it met a cushion."""
        body, s, t = chosen.bodies[0], found.s, found.t
        assert s is not None
        i, cushion = chosen.choice.a, chosen.choice.b
        inward = SIDES[cushion]
        (vx, vy), u = body.velocity_after(s), body.slip_after(s)
        rate = inward[0] * vx + inward[1] * vy
        opening = inward[0] * body.ax + inward[1] * body.ay
        self._check_hop(chosen, t, rate, opening, 2 * body.constants.radius)
        self._count_hop(chosen, t, rate, 2 * body.constants.radius)
        n = (arb(-inward[0]), arb(-inward[1]))
        seen = seen_along(n, (vx, vy), u, body.spin_after(s), body.constants.radius)
        after = self._laws.bounce(i, seen)
        place = self._at_cushion(chosen, body.position_after(s), s)
        return self._sent_off(body, n, place, after, t, order)

    def _sent_off(
        self, body: Body, n: Vector, place: Vector, after: Seen, t: arb, order: int
    ) -> Body:
        velocity, slip = seen_from_table(n, after)
        if not self._problem.slides:
            slip = (ZERO, ZERO)  # a ball that always rolls has the spin of its velocity
        return Body(body.constants, place, velocity, slip, after.wz, t, order)

    def _at_cushion(self, chosen: Candidate, place: Vector, s: arb) -> Vector:
        """Return where a ball touches a cushion: across it there is no doubt.

        But where a ball begins beyond it, by the rounding of the scene's numbers.
        """
        i, cushion = chosen.choice.a, chosen.choice.b
        if s.is_zero() and (i, cushion) not in self._railed:
            return place
        line, radius = self._problem.noses[cushion], self._problem.balls[i].radius
        assert line is not None
        across = arb(exactly(line) + sum(SIDES[cushion]) * exactly(radius))
        return (across, place[1]) if SIDES[cushion][0] else (place[0], across)

    @staticmethod
    def _check_hop(chosen: Candidate, t: arb, rate: arb, opening: arb, diameter: arb) -> None:
        """Raise where a rebound would be too low to be followed: the contact is sustained."""
        square = rate * rate
        most = 2 * HOP * diameter * arb.max(-opening, ZERO)
        if square > most:
            return
        if opening < 0 and square <= most:
            raise SustainedContactError("pressed together", (chosen.choice,), t)
        raise UndecidedError("whether they bounce or stay in contact", (chosen.choice,), t)

    def _count_hop(self, chosen: Candidate, t: arb, rate: arb, diameter: arb) -> None:
        """Raise where a contact has hopped so low so often that there is no end to it.

        In doubles: where to stop is a choice, and nothing that is proved depends on it.
        """
        if all(b.constants.rolling.is_zero() for b in chosen.bodies):
            return
        choice, now, speed = chosen.choice, float(t), abs(float(rate))
        key = (choice.kind, choice.a, choice.b)
        before, was, hops = self._hops.get(key, (-math.inf, 0.0, 0))
        low = (now - before) * max(speed, was) <= HOP * float(diameter)
        hops = hops + 1 if low else 0
        if hops > LOW_HOPS:
            raise SustainedContactError("bounces that get ever lower", (choice,), t)
        self._hops[key] = (now, speed, hops)

    def end_instant(self) -> arb:
        """Return when everything is over: `t_max`, or the last centre rests and the last spin ends.

        A spin that nothing slows isn't waited for.

        Raises
        ------
        UndecidedError
            Where the last spin may end before or after `t_max`.
        """
        assert self.ended
        if not self.rested:
            assert self._t_max is not None
            return self._t_max
        t = self.now
        for body in self.bodies:
            if not (body.wz.is_zero() or body.constants.spinning.is_zero()):
                t = arb.max(t, body.t + abs(body.wz) / body.constants.spinning)
        if self._t_max is not None and not t <= self._t_max:
            if not t > self._t_max:
                raise UndecidedError("whether the last spin ends before `t_max`", (), t)
            self.rested = False
            return self._t_max
        return t
