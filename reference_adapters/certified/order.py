"""The next event among the candidates: one event, one of several that commute, or several together.

An error is raised if this can't be decided; an engine in doubles couldn't decide it either.
"""

from __future__ import annotations

import math

from flint import arb

from ghostball.model.rounding import position_rounding
from ghostball.reference_adapters.certified.arithmetic import ZERO, UndecidedError, Vector
from ghostball.reference_adapters.certified.candidates import Agenda, Candidate
from ghostball.reference_adapters.certified.certificate import Choice
from ghostball.reference_adapters.certified.contacts import TOUCHING
from ghostball.reference_adapters.certified.gaps import (
    DistanceGap,
    error_in_doubles,
    motion_in_doubles,
)
from ghostball.reference_adapters.certified.meetings import Meeting
from ghostball.reference_adapters.certified.motion import Body
from ghostball.reference_adapters.certified.problem import ExactProblem
from ghostball.reference_adapters.certified.ties import are_at_once, commute, first_of_instant

TIE_BITS = 100
"""Events of different balls that are within 2^-100 s count as simultaneous.

It is proved that either order has the same outcome. Some events are exactly simultaneous by the
laws: if a rolling ball hits a resting ball, both slides end together.
"""


def largest_speeds(problem: ExactProblem) -> list[float]:
    """Return an upper bound on the speed of each ball [m/s]: its speed with all the energy.

    Neither impacts nor the cloth add energy: m v^2 / 2 is at most the sum of m v^2 / 2
    + m R^2 w^2 / 5, and of m g z if balls start at a height z above the cloth.
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


class EventOrder:
    """The order of the events of one run.

    `agenda`: the candidates; `bodies`: the balls in their present state, the run's own list.
    `act_at_once`: True if a law exists for simultaneous impacts that share balls.
    """

    def __init__(
        self, problem: ExactProblem, agenda: Agenda, bodies: list[Body], *, act_at_once: bool
    ) -> None:
        self._problem = problem
        self._agenda = agenda
        self._bodies = bodies
        self._act_at_once = act_at_once
        self._t_max = None if problem.t_max is None else arb(problem.t_max)
        self._speeds = largest_speeds(problem)

    def take(self) -> tuple[tuple[Candidate, ...], bool]:
        """Return the next event, or the impacts that act together; () is the end.

        Also return True if the order of the event is a convention.
        """
        group = self._agenda.take_first(self._bodies)
        if not group:
            return (), False
        first = group[0]
        for c in group[1:]:
            earlier, later = c.instant.mid(), first.instant.mid()
            if earlier < later or (earlier == later and c.rank < first.rank):
                first = c
        t = first.instant
        if self._t_max is not None:
            if all(c.instant > self._t_max for c in group):
                return (), False
            if not t <= self._t_max:
                raise UndecidedError("whether it comes before `t_max`", (first.choice,), t)
        rivals = [c for c in group if c is not first and not c.instant > t]
        # Sorted by rank, because the order of the midpoints in a tie changes with the precision.
        ranked = sorted((first, *rivals), key=lambda c: c.rank)
        choices = tuple(c.choice for c in ranked)
        if not first.known:
            what = "whether they touch" if len(choices) == 1 else "what comes first"
            raise UndecidedError(what, choices, t)
        together: tuple[Candidate, ...] = (first,)
        if rivals and (error := self._tie_error(first, rivals, choices)) is not None:
            at_once = all(c.known and are_at_once(first, c) for c in rivals)
            if not (at_once and self._act_at_once):
                raise error
            for c in rivals:
                c.meeting = Meeting(c.age, t)
            together = first_of_instant((first, *rivals))
        for c in group:
            if c not in together:
                self._agenda.add(c)
        for c in together:
            self._check_order(c)
        return together, bool(rivals)

    def _check_order(self, first: Candidate) -> None:
        """Raise an error if another contact of a ball closes, too, within the touching tolerance.

        An engine in doubles can't decide their order then, unless both orders are the same.
        """
        if first.gap is None:
            return
        now = float(first.instant)
        for other in self._agenda.sharing(first, self._bodies):
            if other.gap is None or _far_apart(other, now):
                continue
            if other.known and other.instant is first.instant:
                continue  # simultaneous, and later by the rule for simultaneous impacts
            if commute(self._problem, first, other):
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

    def _tie_error(
        self, first: Candidate, rivals: list[Candidate], choices: tuple[Choice, ...]
    ) -> UndecidedError | None:
        """Return the error if the order of undecided events matters; None if it doesn't."""
        t = first.instant
        for c in rivals:
            if not c.known or set(c.balls) & set(first.balls):
                exact = c.known and c.instant is first.instant
                return UndecidedError("what comes first", choices, first.instant, exact=exact)
            t = t.union(c.instant)
        width = float(t.rad().upper()) * 2.0
        if not width <= 2.0**-TIE_BITS:
            return UndecidedError("what comes first", choices, t)
        if not all(self._isolated(c, t, width) for c in (first, *rivals)):
            return UndecidedError("whether the order matters", choices, t)
        return None

    def _isolated(self, candidate: Candidate, t: arb, width: float) -> bool:
        """Return True if no other ball can be affected by a candidate within `width` [s]."""
        for k in candidate.balls:
            x, y = self._place(k, t)
            for m, body in enumerate(self._bodies):
                if m in candidate.balls:
                    continue
                ox, oy = self._place(m, t)
                reach = 2.0 * (self._speeds[k] + self._speeds[m]) * width + 1e-12
                least = self._bodies[k].constants.radius + body.constants.radius + reach
                dx, dy = x - ox, y - oy
                if not dx * dx + dy * dy > least * least:
                    return False
        return True

    def _place(self, k: int, t: arb) -> Vector:
        body = self._bodies[k]
        return (body.x, body.y) if body.resting else body.position_after(t - body.t)


def _far_apart(candidate: Candidate, t: float) -> bool:
    """Return True if two balls are certainly apart at a time [s], by doubles; False if undecided.

    The distance is at least a thousandth of their radii, far more than the error of doubles.
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
