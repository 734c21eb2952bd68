"""One run of a problem in one precision: event after event, each proved to be the next.

Bounds in doubles, on the safe side, say which candidates need a proof at all; those that may be
first are enclosed in balls and compared. What can't be decided is raised, and `certify` widens the
precision and starts again.
"""

from __future__ import annotations

import math
import time

from flint import arb

from ghostball.model import EventKind, Phase
from ghostball.model.rounding import position_rounding
from ghostball.reference_adapters.certified.arithmetic import (
    ZERO,
    SustainedContactError,
    UndecidedError,
    Vector,
)
from ghostball.reference_adapters.certified.candidates import Agenda, Candidate
from ghostball.reference_adapters.certified.certificate import Choice, Ending
from ghostball.reference_adapters.certified.contacts import TOUCHING, Contacts
from ghostball.reference_adapters.certified.flight import (
    FlyingBody,
    body_in_space_at_start,
    gone,
)
from ghostball.reference_adapters.certified.gaps import (
    DistanceGap,
    PairGap,
    error_in_doubles,
    level_reach,
    motion_in_doubles,
)
from ghostball.reference_adapters.certified.impacts import Impacts
from ghostball.reference_adapters.certified.impacts_in_space import ImpactsInSpace
from ghostball.reference_adapters.certified.meetings import Meeting, meeting_again
from ghostball.reference_adapters.certified.motion import Body, body_at_start
from ghostball.reference_adapters.certified.obstacle_gaps import (
    NoseGap,
    ObstacleGap,
    RoundGap,
    StraightGap,
    choice_at,
    reach_to_nose,
)
from ghostball.reference_adapters.certified.obstacles import Round, Straight, obstacles_met
from ghostball.reference_adapters.certified.over_obstacles import (
    Nearness,
    hole_below,
    nearness,
    past_hole,
)
from ghostball.reference_adapters.certified.problem import Problem

TIE_BITS = 100
"""Events of different balls that are within 2^-100 s count as simultaneous.

Either order then has the same outcome, which is proved; some are at one instant by the laws, as
when a rolling ball meets a resting one and both slides end together.
"""


def largest_speeds(problem: Problem) -> list[float]:
    """Return a speed that each ball never exceeds [m/s]: with all energy of the start in it.

    No law, and no cloth, makes energy: m v^2 / 2 is at most the sum of m v^2 / 2 + m R^2 w^2 / 5,
    and of m g z where balls begin at a height z above the cloth.
    """
    twice = ZERO
    for ball in problem.balls:
        moves = arb(ball.vx) ** 2 + arb(ball.vy) ** 2
        turns = arb(ball.wx) ** 2 + arb(ball.wy) ** 2 + arb(ball.wz) ** 2
        twice += ball.mass * (moves + 2 * arb(ball.radius) ** 2 * turns / 5)
        if problem.airborne:
            falls = 2 * arb(problem.gravity) * (arb(ball.z) - ball.radius)
            twice += ball.mass * (arb(ball.vz) ** 2 + falls)
    return [float((twice / ball.mass).upper().sqrt().upper()) for ball in problem.balls]


class Run:
    """One run.

    `bodies`: each ball from the last event that concerned it.
    `now` [s]: the last event's instant.
    `events`: what is proved: event, instant, and whether its place is a convention.
    `ended`: whether the run reached its natural end.
    """

    def __init__(self, problem: Problem, bits: int) -> None:
        self.bits = bits
        self.now = ZERO
        self.order = 0
        self.events: list[tuple[Choice, arb, bool]] = []
        self.ended = False
        self.rested = False
        self.airborne = problem.airborne
        self._problem = problem
        self._t_max = None if problem.t_max is None else arb(problem.t_max)
        self._speeds = largest_speeds(problem)
        self._agenda = Agenda(bits)
        self._pieces = obstacles_met(problem)
        self._contacts = Contacts(problem, self._pieces)
        law = ImpactsInSpace if problem.airborne else Impacts
        self._impacts = law(problem, self._contacts)
        start = body_in_space_at_start if problem.airborne else body_at_start
        self.bodies = [start(ball, problem) for ball in problem.balls]
        self.segments = list(enumerate(self.bodies))

    def go(self, max_events: int, deadline: float) -> Ending:
        """Run until the end, `max_events` events, or `deadline` of `time.perf_counter`.

        Returns "proved", "event limit" or "time limit".

        Raises `UndecidedError` where this precision can't tell what comes next;
        `SustainedContactError` where a contact is sustained from here on.
        """
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
                self.segments.append((k, self.bodies[k]))
            self._predict_touched(chosen.balls)

    # -- what may come next ----------------------------------------------------------------------

    def _begin(self) -> None:
        for i in range(len(self.bodies)):
            self._predict_alone(i)
            for j in range(i):
                self._predict_pair(j, i)

    def _predict_alone(self, i: int) -> None:
        """Predict what ball i does alone: its phase ends, it meets a cushion or a pocket."""
        body = self.bodies[i]
        if body.resting:
            return
        if body.duration is not None:
            self._predict_end(i, body, body.duration)
        high = self._window(body.end, body)
        last = self._predict_holes(i, body) if isinstance(body, FlyingBody) else 0.0
        for piece in self._pieces:
            if isinstance(body, FlyingBody) and not self._predict_over(i, body, piece, last):
                continue
            gap = self._gap_to(i, piece)
            if self._contacts.touches_obstacle(i, piece.row):
                found = meeting_again(gap, high, self.bits)
                if found is not None:
                    self._agenda.add(Candidate(gap.choice, (body,), gap, found=found))
            else:
                self._agenda.add_searched(gap, (body,), high)

            if isinstance(body, FlyingBody) and isinstance(piece, Straight):
                choice = Choice(EventKind.LEAVES_TABLE, i, piece.obstacle)
                self._predict_leaving(body, piece, choice)

    def _gap_to(self, i: int, piece: Straight | Round) -> ObstacleGap:
        body, choice = self.bodies[i], choice_at(i, piece)
        if isinstance(piece, Round):
            return RoundGap(body, piece, choice, reach_to_nose(self._problem, i, piece))
        if isinstance(body, FlyingBody):
            return NoseGap(body, piece, self._problem.cushion_height, choice)
        return StraightGap(body, piece, choice, reach_to_nose(self._problem, i, piece))

    def _predict_end(self, i: int, body: Body, s: arb) -> None:
        """Predict the end of ball i's phase, a time s after its instant [s]."""
        choice, found = Choice(body.end_kind, i, -1), Meeting(s, body.t + s)
        if isinstance(body, FlyingBody):
            hole, is_known = hole_below(body, self._pieces)
            if hole is not None:
                choice = choice_at(i, hole)
                found = found if is_known else Meeting(None, body.t)
        self._agenda.add(Candidate(choice, (body,), found=found))

    def _predict_holes(self, i: int, body: FlyingBody) -> float:
        """Predict what holes do to ball i, in the air; return how long it flies at most [s]."""
        assert body.duration is not None
        last = _latest(body.duration)
        for piece in self._pieces:
            if isinstance(piece, Round) and piece.takes_out:
                for choice, found in past_hole(i, body, piece):
                    self._agenda.add(Candidate(choice, (body,), found=found))
                    last = last if found.s is None else min(last, _latest(found.s))
        return last

    def _predict_over(self, i: int, body: FlyingBody, piece: Straight | Round, last: float) -> bool:
        """Say that ball i, in the air, meets something as on the cloth, or as a line; else predict.

        It flies for `last` seconds at most.
        """
        if isinstance(piece, Round) and (piece.takes_out or piece.is_post):
            return piece.is_post
        if isinstance(piece, Straight) and piece.extent is None:
            return True
        where = nearness(body, piece, last)
        if where is Nearness.UNDECIDED:
            found = Meeting(None, body.t)
            self._agenda.add(Candidate(choice_at(i, piece), (body,), found=found))
        return where is Nearness.IN_FRONT

    def _predict_leaving(self, body: FlyingBody, piece: Straight, choice: Choice) -> None:
        """Predict when a ball in the air flies over a cushion: its centre is above the nose."""
        away, rate = piece.away((body.x, body.y)), piece.across((body.vx, body.vy))
        if not away > 0:
            raise UndecidedError("whether it is over the cushion", (choice,), body.t)
        assert body.duration is not None
        if away + rate * body.duration > 0:
            return
        found = Meeting(away / -rate, body.t + away / -rate) if rate < 0 else Meeting(None, body.t)
        self._agenda.add(Candidate(choice, (body,), found=found))

    def _predict_pair(self, i: int, j: int) -> None:
        """Predict when balls i < j meet, while both continue as they do."""
        a, b = self.bodies[i], self.bodies[j]
        if (a.resting and b.resting) or Phase.GONE in (a.phase, b.phase):
            return
        reach = level_reach(a, b) if self._problem.airborne else None
        gap = PairGap(a, b, Choice(EventKind.BALL_BALL, i, j), reach)
        later = a if a.order >= b.order else b
        high = self._window(min(a.end, b.end), later)
        if not self._contacts.touches_ball(i, j):
            self._agenda.add_searched(gap, (a, b), high)
            return
        if not gap.curved and all(c.is_zero() for c in gap.coefficients()[1:]):
            raise SustainedContactError("they move as one", (gap.choice,), gap.t)
        still = self._contacts.is_still(i, j, (a, b))
        found = meeting_again(gap, high, self.bits, still=still)
        if found is not None:
            self._agenda.add(Candidate(gap.choice, (a, b), gap, found=found))

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
        group = self._agenda.take_first(self.bodies)
        if not group:
            return None, False
        first = group[0]
        for c in group[1:]:
            earlier, later = c.instant.mid(), first.instant.mid()
            if earlier < later or (earlier == later and c.rank < first.rank):
                first = c
        t = first.instant
        if self._t_max is not None:
            if all(c.instant > self._t_max for c in group):
                return None, False
            if not t <= self._t_max:
                raise UndecidedError("whether it comes before `t_max`", (first.choice,), t)
        rivals = [c for c in group if c is not first and not c.instant > t]
        # By rank: which of a tie's middles is the first changes with the precision.
        ranked = sorted((first, *rivals), key=lambda c: c.rank)
        choices = tuple(c.choice for c in ranked)
        if not first.known:
            what = "whether they touch" if len(choices) == 1 else "what comes first"
            raise UndecidedError(what, choices, t)
        if rivals:
            self._check_tie(first, rivals, choices)
        for c in group:
            if c is not first:
                self._agenda.add(c)
        self._check_order(first)
        return first, bool(rivals)

    def _check_order(self, first: Candidate) -> None:
        """Raise where another contact of a ball closes too, within what counts as touching.

        No engine in doubles can say then which of both comes first.
        """
        if first.gap is None:
            return
        now = float(first.instant)
        for other in self._agenda.sharing(first, self.bodies):
            if other.gap is None or _far_apart(other, now):
                continue
            choices = tuple(c.choice for c in sorted((first, other), key=lambda c: c.rank))
            s = first.instant - other.gap.t
            room, rate = other.gap.value(s), other.gap.slope(s)
            least = self._touching(other)
            if room > least or rate > 0:
                continue
            surely = bool(room <= least and rate < 0)
            raise UndecidedError("what comes first", choices, first.instant, exact=surely)

    def _touching(self, candidate: Candidate) -> arb:
        """Return the value of a candidate's gap below which it counts as closed."""
        assert candidate.gap is not None
        bodies = candidate.bodies
        diameter = sum((body.constants.radius for body in bodies), ZERO) * (2 // len(bodies))
        rounding = position_rounding(*(body.doubles.place for body in bodies))
        least = TOUCHING * diameter + rounding
        if isinstance(candidate.gap, DistanceGap):  # the difference of two squares
            return least * (2 * candidate.gap.reach)
        return least

    def _check_tie(
        self, first: Candidate, rivals: list[Candidate], choices: tuple[Choice, ...]
    ) -> None:
        """Let events pass that can't be ordered but needn't be; raise for the others."""
        t = first.instant
        for c in rivals:
            if not c.known or set(c.balls) & set(first.balls):
                exact = c.known and c.instant is first.instant
                raise UndecidedError("what comes first", choices, first.instant, exact=exact)
            t = t.union(c.instant)
        width = float(t.rad().upper()) * 2.0
        if not width <= 2.0**-TIE_BITS:
            raise UndecidedError("what comes first", choices, t)
        if not all(self._isolated(c, t, width) for c in (first, *rivals)):
            raise UndecidedError("whether the order matters", choices, t)

    def _isolated(self, candidate: Candidate, t: arb, width: float) -> bool:
        """Whether no other ball is near enough to a candidate's to feel it within `width` [s]."""
        for k in candidate.balls:
            x, y = self._place(k, t)
            for m, body in enumerate(self.bodies):
                if m in candidate.balls:
                    continue
                ox, oy = self._place(m, t)
                reach = 2.0 * (self._speeds[k] + self._speeds[m]) * width + 1e-12
                least = self.bodies[k].constants.radius + body.constants.radius + reach
                dx, dy = x - ox, y - oy
                if not dx * dx + dy * dy > least * least:
                    return False
        return True

    def _place(self, k: int, t: arb) -> Vector:
        body = self.bodies[k]
        return (body.x, body.y) if body.resting else body.position_after(t - body.t)

    # -- what it does ----------------------------------------------------------------------------

    def _resolve(self, chosen: Candidate) -> None:
        """Move the clock to an event, and its balls on from there.

        Nothing is changed where the outcome can't be decided.
        """
        choice, t = chosen.choice, chosen.instant
        same = t is self.now
        order = self.order if same else self.order + 1
        overlapping = False
        try:
            if choice.kind is EventKind.BALL_BALL:
                overlapping = self._impacts.overlapping(chosen)
                bodies = self._impacts.collided(chosen, order)
            elif choice.kind is EventKind.BALL_CUSHION:
                overlapping = self._impacts.overlapping(chosen)
                bodies = (self._impacts.bounced(chosen, order),)
            elif choice.kind in (EventKind.LEAVES_TABLE, EventKind.POCKETED):
                bodies = (gone(chosen.bodies[0], chosen.age, t, order),)
            else:
                bodies = (chosen.bodies[0].after_phase(t, order),)
        except UndecidedError as error:
            raise UndecidedError(error.what, (choice,), t, exact=error.exact) from None
        if same:
            self._contacts.same_instant(choice, t)
        else:
            self._contacts.start_instant(self.bodies)
            self.now, self.order = t, order
        for k, body in zip(chosen.balls, bodies, strict=True):
            self.bodies[k] = body
        self._contacts.note(chosen, bodies, overlapping, still=self._impacts.still)

    def _predict_touched(self, balls: tuple[int, ...]) -> None:
        for k in balls:
            self._predict_alone(k)
            for m in range(len(self.bodies)):
                if m != k and not (m in balls and m > k):
                    self._predict_pair(min(k, m), max(k, m))

    def end_instant(self) -> arb:
        """Return when everything is over: `t_max`, or the last centre rests and the last spin ends.

        A spin that nothing slows isn't waited for.

        Raises `UndecidedError` where the last spin may end before or after `t_max`.
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


def _far_apart(candidate: Candidate, t: float) -> bool:
    """Whether two balls are surely apart at an instant [s], by doubles; False where they can't say.

    By a thousandth of their radii, far more than doubles err.
    """
    if len(candidate.bodies) == 1:
        return False
    places, reach, error = [], 0.0, 0.0
    for body in candidate.bodies:
        q, s = body.doubles, 0.0 if body.resting else t - float(body.t)
        if body.curved or not q.exact_enough:
            return False
        places.append(motion_in_doubles(body, s, in_space=False)[0])
        reach += float(body.constants.radius)
        error += error_in_doubles(q.place, q.speed, q.pull, s)
    return math.dist(*places) > 1.001 * reach + error


def _latest(s: arb) -> float:
    """Return a double that a time surely doesn't exceed [s]."""
    return math.nextafter(float(s.upper()), math.inf)
