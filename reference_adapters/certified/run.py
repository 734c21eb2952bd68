"""One run of a problem with one precision: event after event, each proved to be the next.

Conservative bounds in doubles select the candidates that need a proof; those that may be first are
enclosed in intervals and compared. An open decision raises an error, and `prove` increases the
precision and starts again.
"""

from __future__ import annotations

import math
import time

from flint import arb

from ghostball.model import COLLISION_KINDS, EventKind, Phase
from ghostball.reference_adapters.certified.arithmetic import (
    ZERO,
    SustainedContactError,
    UndecidedError,
)
from ghostball.reference_adapters.certified.candidates import Agenda, Candidate
from ghostball.reference_adapters.certified.certificate import Choice, Ending
from ghostball.reference_adapters.certified.contacts import RunContacts
from ghostball.reference_adapters.certified.flight import (
    FlyingBody,
    body_in_space_at_start,
    gone,
)
from ghostball.reference_adapters.certified.gaps import PairGap, level_reach
from ghostball.reference_adapters.certified.impacts import Impacts
from ghostball.reference_adapters.certified.impacts_in_space import ImpactsInSpace
from ghostball.reference_adapters.certified.integrated_slide import Integrator
from ghostball.reference_adapters.certified.joint_impacts import JointImpacts
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
from ghostball.reference_adapters.certified.obstacles import (
    RoundPiece,
    StraightPiece,
    obstacles_met,
)
from ghostball.reference_adapters.certified.order import EventOrder
from ghostball.reference_adapters.certified.over_obstacles import (
    Nearness,
    hole_below,
    nearness,
    past_hole,
)
from ghostball.reference_adapters.certified.problem import ExactProblem
from ghostball.reference_adapters.certified.ties import sharing_balls


class CertifiedRun:
    """One run.

    `bodies`: each ball since its last event.
    `now`: time of the last event [s].
    `events`: proved events: event, time, and whether the order is a convention.
    `ended`: whether the run reached its normal end.
    """

    def __init__(self, problem: ExactProblem, bits: int, slide: Integrator | None = None) -> None:
        self.bits = bits
        self.now = ZERO
        self.order = 0
        self.events: list[tuple[Choice, arb, bool]] = []
        self.ended = False
        self.rested = False
        self.airborne = problem.airborne
        self._problem = problem
        self._t_max = None if problem.t_max is None else arb(problem.t_max)
        self._agenda = Agenda(bits)
        self._pieces = obstacles_met(problem)
        self._contacts = RunContacts(problem, self._pieces)
        law = ImpactsInSpace if problem.airborne else JointImpacts
        self._impacts: Impacts = law(problem, self._contacts)
        if problem.airborne:
            self.bodies = [body_in_space_at_start(ball, problem) for ball in problem.balls]
        else:
            self.bodies = [body_at_start(ball, problem, slide) for ball in problem.balls]
        self.segments = list(enumerate(self.bodies))
        at_once = problem.simultaneous and not problem.airborne
        self._order = EventOrder(problem, self._agenda, self.bodies, act_at_once=at_once)

    def go(self, max_events: int, deadline: float) -> Ending:
        """Run to the end, to `max_events` events, or to `deadline` of `time.perf_counter`.

        Returns "proved", "event limit" or "time limit".

        Raises `UndecidedError` if this precision can't determine the next event;
        `SustainedContactError` if a contact is a resting contact from now on.
        """
        self._begin()
        while True:
            if len(self.events) >= max_events:
                return "event limit"
            if time.perf_counter() > deadline:
                return "time limit"
            chosen, tie = self._order.take()
            if not chosen:
                self.ended = True
                self.rested = all(body.resting for body in self.bodies)
                return "proved"
            for group in sharing_balls(chosen):
                for choice in self._resolve(group):
                    self.events.append((choice, self.now, tie))
                    for k in choice.balls:
                        self.segments.append((k, self.bodies[k]))
            self._predict_touched({k for one in chosen for k in one.balls})

    # -- prediction of events --------------------------------------------------------------------

    def _begin(self) -> None:
        for i in range(len(self.bodies)):
            self._predict_alone(i)
            for j in range(i):
                self._predict_pair(j, i)

    def _predict_alone(self, i: int) -> None:
        """Predict the events of ball i alone: its phase ends, or it meets a cushion or a pocket."""
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

            if isinstance(body, FlyingBody) and isinstance(piece, StraightPiece):
                choice = Choice(EventKind.LEAVES_TABLE, i, piece.obstacle)
                self._predict_leaving(body, piece, choice)

    def _gap_to(self, i: int, piece: StraightPiece | RoundPiece) -> ObstacleGap:
        body, choice = self.bodies[i], choice_at(i, piece)
        if isinstance(piece, RoundPiece):
            return RoundGap(body, piece, choice, reach_to_nose(self._problem, i, piece))
        if isinstance(body, FlyingBody):
            return NoseGap(body, piece, self._problem.cushion_height, choice)
        return StraightGap(body, piece, choice, reach_to_nose(self._problem, i, piece))

    def _predict_end(self, i: int, body: Body, s: arb) -> None:
        """Predict the end of ball i's phase, a time s after its start time [s]."""
        choice, found = Choice(body.end_kind, i, -1), Meeting(s, body.t + s)
        if isinstance(body, FlyingBody):
            hole, is_known = hole_below(body, self._pieces)
            if hole is not None:
                choice = choice_at(i, hole)
                found = found if is_known else Meeting(None, body.t)
        self._agenda.add(Candidate(choice, (body,), found=found))

    def _predict_holes(self, i: int, body: FlyingBody) -> float:
        """Predict the events of airborne ball i with holes; return its longest flight time [s]."""
        assert body.duration is not None
        last = _latest(body.duration)
        for piece in self._pieces:
            if isinstance(piece, RoundPiece) and piece.takes_out:
                for choice, found in past_hole(i, body, piece):
                    self._agenda.add(Candidate(choice, (body,), found=found))
                    last = last if found.s is None else min(last, _latest(found.s))
        return last

    def _predict_over(
        self, i: int, body: FlyingBody, piece: StraightPiece | RoundPiece, last: float
    ) -> bool:
        """Return whether the gap of airborne ball i to a post, or to a line, must be searched.

        A face counts as a line if the ball stays in front of it. If the ball may meet a jaw or an
        end of a face, predict an undecided event. The ball flies for at most `last` seconds.
        """
        if isinstance(piece, RoundPiece) and (piece.takes_out or piece.is_post):
            return piece.is_post
        if isinstance(piece, StraightPiece) and piece.extent is None:
            return True
        where = nearness(body, piece, last)
        if where is Nearness.UNDECIDED:
            found = Meeting(None, body.t)
            self._agenda.add(Candidate(choice_at(i, piece), (body,), found=found))
        return where is Nearness.IN_FRONT

    def _predict_leaving(self, body: FlyingBody, piece: StraightPiece, choice: Choice) -> None:
        """Predict when an airborne ball flies over a cushion: when its centre is above the nose."""
        away, rate = piece.away((body.x, body.y)), piece.across((body.vx, body.vy))
        if not away > 0:
            raise UndecidedError("whether it is over the cushion", (choice,), body.t)
        assert body.duration is not None
        if away + rate * body.duration > 0:
            return
        found = Meeting(away / -rate, body.t + away / -rate) if rate < 0 else Meeting(None, body.t)
        self._agenda.add(Candidate(choice, (body,), found=found))

    def _predict_pair(self, i: int, j: int) -> None:
        """Predict the contact of balls i < j with their present motions."""
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
        """Return the search time after the later start time for motions that end at `end` [s].

        It is slightly longer than the motions, to include events at the very end.
        """
        if self._problem.t_max is not None:
            end = min(end, self._problem.t_max)
        return max(end - float(later.t.lower()), 0.0) * (1.0 + 2.0**-20) + 2.0**-30

    # -- resolution of events --------------------------------------------------------------------

    def _resolve(self, group: list[Candidate]) -> tuple[Choice, ...]:
        """Resolve an event, or impacts that act together; advance the clock and the balls.

        Returns the events. If the outcome can't be decided, the run is unchanged.
        """
        first, t = group[0], group[0].instant
        same = t is self.now
        order = self.order if same else self.order + 1
        overlapping = []
        try:
            for one in group:
                collides = one.choice.kind in COLLISION_KINDS
                overlapping.append(collides and self._impacts.overlapping(one))
            if len(group) > 1:
                after, choices = self._impacts.together(group, order)
            else:
                bodies, choices = self._outcome(first, order), (first.choice,)
                after = dict(zip(first.balls, bodies, strict=True))
        except UndecidedError as error:
            named = tuple(one.choice for one in group)
            raise UndecidedError(error.what, named, t, exact=error.exact) from None
        if not same:
            self._contacts.start_instant(self.bodies)
        for choice in choices:
            self._contacts.count(choice, t)
        self.now, self.order = t, order
        for k, body in after.items():
            self.bodies[k] = body
        for one, overlaps in zip(group, overlapping, strict=True):
            bodies = tuple(after[k] for k in one.balls)
            self._contacts.note(one, bodies, overlaps, still=self._impacts.still)
        return choices

    def _outcome(self, chosen: Candidate, order: int) -> tuple[Body, ...]:
        """Return the balls of an event after it."""
        kind = chosen.choice.kind
        if kind is EventKind.BALL_BALL:
            return self._impacts.collided(chosen, order)
        if kind is EventKind.BALL_CUSHION:
            return (self._impacts.bounced(chosen, order),)
        body, t = chosen.bodies[0], chosen.instant
        if kind in (EventKind.LEAVES_TABLE, EventKind.POCKETED):
            return (gone(body, chosen.age, t, order),)
        return (body.after_phase(t, order),)

    def _predict_touched(self, balls: set[int]) -> None:
        for k in sorted(balls):
            self._predict_alone(k)
            for m in range(len(self.bodies)):
                if m != k and not (m in balls and m > k):
                    self._predict_pair(min(k, m), max(k, m))

    def end_instant(self) -> arb:
        """Return the end of the shot: `t_max`, or when the last motion and the last spin end.

        Spin that doesn't decay isn't waited for.

        Raises `UndecidedError` if the last spin may end before or after `t_max`.
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


def _latest(s: arb) -> float:
    """Return an upper bound of a time as a double [s]."""
    return math.nextafter(float(s.upper()), math.inf)
