"""The effect of each event of a certified shot on changes of its balls (`certified_growth`)."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ghostball.model import COLLISION_KINDS, EventKind, Scene, Table
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.certified import Certificate
from ghostball.reference_adapters.certified.laws import (
    ImpactLaws,
    InContactFrame,
    from_contact_frame,
    to_contact_frame,
)
from ghostball.reference_adapters.certified.problem import problem_of
from ghostball.validation.grading.certified_flow import PARTS, PLACE, SLIP, VELOCITY, CertifiedBall
from ghostball.validation.grading.event_logs import events_of_certificate
from ghostball.validation.grading.slope import Slope

_OLD, _OLD_SURFACE, _LATE = -3, -2, -1
"""Columns of `_Passage.change` after those of the state of the balls."""

_MORE = 3
"""The number of these columns."""


class Approach(NamedTuple):
    """How a ball approaches another ball, or an obstacle, just before contact.

    `normal` (2,) float64: unit vector from the ball to the other body.
    `parting` (2,) float64 [m/s]: velocity of the other body minus that of the ball.
    `depth` [m]: displacement of the path that would make the ball miss a round body; inf for a
        straight side.
    `stops` [m]: further approach before friction would end it; inf: friction doesn't.
    """

    normal: FloatArray
    parting: FloatArray
    depth: float
    stops: float


class EventChange(NamedTuple):
    """The effect of an event on changes of its balls, and the effect of rounding at the event.

    If the event has no derivative, only the first four fields are set.
    """

    kind: EventKind
    t: float
    balls: tuple[int, ...]
    segments: tuple[int, ...]  # of each ball after the event
    matrix: FloatArray | None = None  # (7 b, 7 b) derivative by the state at the segments before
    late: FloatArray | None = None  # (7 b,) change of the state per second of late detection
    # (2, 7 b) change per second of older velocities, and older surface velocities
    stale: FloatArray | None = None
    # (7 b,) delay of the event by changes of the segments before
    later: FloatArray | None = None
    approach: float = 0.0  # [m/s] along the normal; 0 without a collision
    meets: Approach | None = None  # None without a collision
    rounded: float = 0.0  # [s] delay of the event by one rounding of its gap, over 2^-53
    # (7, 7) of each ball: covariance of one rounding of its state
    noise: tuple[FloatArray, ...] = ()


def event_changes(
    scene: Scene, certificate: Certificate, balls: tuple[CertifiedBall, ...]
) -> Iterator[EventChange]:
    """Yield the effect of each event; simultaneous collisions of a ball have no derivative.

    If balls may fly, no event has a derivative.
    """
    laws = ImpactLaws(problem_of(scene))
    at = [0] * len(balls)
    events = events_of_certificate(certificate)
    here: Counter[tuple[int, float]] = Counter()
    tied = [certified.tie for certified in certificate.events]
    collisions = (event for event in events if event.kind in COLLISION_KINDS)
    due = Counter((ball, event.t) for event in collisions for ball in event.balls)
    for event in events:
        t, involved = event.t, event.balls
        mine = tuple(balls[i] for i in involved)
        before = tuple(balls[i].starts[at[i]] for i in involved)
        for i in involved:
            at[i] += 1
        after = tuple(balls[i].starts[at[i]] for i in involved)
        twice = False
        if event.kind in COLLISION_KINDS:
            # Of simultaneous collisions, none counts as the first.
            twice = any(here[i, t] or (tied[event.index] and due[i, t] > 1) for i in involved)
            here.update((i, t) for i in involved)
        if twice or certificate.lifts:
            yield EventChange(event.kind, t, involved, after)
            continue
        passes = _Passage(mine, before, after, t, slides=scene.physics.motion == "sliding")
        if event.kind is EventKind.BALL_BALL:
            passes.collide(laws, event.a, event.b)
        elif event.kind is EventKind.BALL_CUSHION:
            assert scene.table is not None
            passes.bounce(laws, event.a, event.b, scene.table)
        elif event.kind is EventKind.POCKETED:
            assert scene.table is not None
            passes.fall(event.b, scene.table)
        else:
            passes.end_phase()
        yield EventChange(event.kind, t, involved, after, *passes.found())


class _Passage:
    """Carries changes of the balls of one event from the segments before it to those after it.

    `states` (7,) float64 each: of the balls, just before.
    `change` (7 b, 7 b + 3) float64: derivatives of the balls by the state at the segments before.
        The last three columns are derivatives by the age of the velocities that a solver uses, by
        the age of the surface velocities, and by the delay of the detection. A solver may use old
        velocities, old surface velocities, or both.
    `later` (7 b + 3,) float64: derivatives of the event time.
    `approach` [m/s]: approach speed of a collision.
    `meets`: see `Approach`.
    `rounded` [s]: delay of the contact by one rounding of the distance, over 2^-53.
    """

    def __init__(
        self,
        balls: tuple[CertifiedBall, ...],
        before: tuple[int, ...],
        after: tuple[int, ...],
        t: float,
        *,
        slides: bool,
    ) -> None:
        self._balls, self._before, self._after, self._slides = balls, before, after, slides
        spans = [float(t - ball.segments[k, 0]) for ball, k in zip(balls, before, strict=True)]
        self._spans = spans
        moving = [ball.rates(k, s) for ball, k, s in zip(balls, before, spans, strict=True)]
        self.states = tuple(state for state, _ in moving)
        self._rates = tuple(rate for _, rate in moving)
        size = PARTS * len(balls)
        self.change = np.zeros((size, size + _MORE))
        self.later = np.zeros(size + _MORE)
        self.approach, self.rounded = 0.0, 0.0
        self.meets: Approach | None = None
        for m, (ball, k, s) in enumerate(zip(balls, before, spans, strict=True)):
            here = slice(PARTS * m, PARTS * (m + 1))
            self.change[here, here] = ball.flow(k, s)
            old, surface = np.zeros((2, PARTS))
            old[VELOCITY] = -self._rates[m][VELOCITY]
            surface[PLACE.stop :] = -self._rates[m][PLACE.stop :] - old[PLACE.stop :]
            if slides:  # slip is the velocity minus the surface velocity
                old[SLIP] = old[VELOCITY]
                surface[SLIP] -= old[VELOCITY]
            self.change[here, _OLD], self.change[here, _OLD_SURFACE] = old, surface

    def collide(self, laws: ImpactLaws, a: int, b: int) -> None:
        """Apply a collision of two balls."""
        between = self.states[1][PLACE] - self.states[0][PLACE]
        normal = between / np.hypot(*between)
        parting = self.states[1][VELOCITY] - self.states[0][VELOCITY]
        opening = float(normal @ parting)
        gap = normal @ (self.change[PARTS : PARTS + 2] - self.change[PLACE])
        self.approach = -opening
        distance = float(np.hypot(*between))
        self.rounded = float(np.divide(distance, self.approach))
        pull = self._rates[1][VELOCITY] - self._rates[0][VELOCITY]
        self.meets = _meets(normal, parting, distance, pull)
        self._come_later(-gap / opening)
        first, second = self._slopes(0), self._slopes(1)
        x, y = (q - p for p, q in zip(first[:2], second[:2], strict=True))
        size = (x * x + y * y).sqrt()
        n = (x / size, y / size)
        seen = [self._seen(n, slopes, m) for m, slopes in enumerate((first, second))]
        for m, one in enumerate(laws.collide(a, b, *seen)):
            self._send_off(m, n, one)
        self._leave()

    def bounce(self, laws: ImpactLaws, ball: int, obstacle: int, table: Table) -> None:
        """Apply a collision of a ball with an obstacle."""
        x, y = self.states[0][PLACE]
        inward, _ = table.facing(obstacle, x, y)
        centre = table.turns_about(obstacle, x, y)
        # The distance from an axis-parallel line is one coordinate; its rounding is part of the
        # noise.
        size = 0.0 if 0.0 in inward else abs(x) + abs(y)
        distance = math.inf if centre is None else math.dist(centre, (x, y))
        self._meet(np.array(inward), size if centre is None else distance, distance)
        n: Any = (-inward[0], -inward[1])
        if centre is not None:
            here = self._slopes(0)
            dx, dy = centre[0] - here[0], centre[1] - here[1]
            size = (dx * dx + dy * dy).sqrt()
            n = (dx / size, dy / size)
        self._send_off(0, n, laws.bounce(ball, self._seen(n, self._slopes(0), 0)))
        self._leave()

    def fall(self, pocket: int, table: Table) -> None:
        """Apply a fall: the ball stays where its centre enters the hole."""
        (hole,) = (one for one in table.holes if one.pocket == pocket)
        away = self.states[0][PLACE] - hole.centre
        distance = float(np.hypot(*away))
        self._meet(away / distance, distance, distance)
        self.change[PLACE.stop :] = 0.0
        self._leave()

    def _meet(self, inward: FloatArray, distance: float, reach: float) -> None:
        """Shift the contact of a ball with an obstacle, whose normal points to the ball.

        The gap is computed from a `distance` [m]. The normal turns about a point at a distance
        `reach` [m].
        """
        velocity = self.states[0][VELOCITY]
        opening = float(inward @ velocity)
        self.approach = -opening
        self.rounded = float(np.divide(distance, self.approach))
        self.meets = _meets(-inward, -velocity, reach, -self._rates[0][VELOCITY])
        self._come_later(-(inward @ self.change[PLACE]) / opening)

    def end_phase(self) -> None:
        """Apply the end of a slide or of a roll."""
        ball, k = self._balls[0], self._before[0]
        self.change[:, [_OLD, _OLD_SURFACE]] = 0.0
        self.change[:, :-_MORE], later = ball.end_of_phase(k, self._spans[0])
        self._come_later(np.append(later, np.zeros(_MORE)))
        # An engine that detects the end of a slide late lets the ball roll from there, at its
        # speed.
        self.change[SLIP, _LATE] = 0.0
        self._leave()

    def found(self) -> tuple[Any, ...]:
        """Return the fields of an `EventChange` from `matrix` on."""
        # The additional columns: velocities 1 s older, surface velocities 1 s older, detection 1 s
        # late.
        matrix, more = self.change[:, :-_MORE].copy(), self.change[:, -_MORE:].T.copy()
        stale, later = more[[_OLD, _OLD_SURFACE]], self.later[:-_MORE].copy()
        after = zip(self._balls, self._after, strict=True)
        noise = tuple(ball.noise(k, self.states) for ball, k in after)
        return matrix, more[_LATE], stale, later, self.approach, self.meets, self.rounded, noise

    def _come_later(self, later: FloatArray) -> None:
        """Shift changes from the time of the event to the changed time of the event."""
        later[_LATE] = 1.0
        self.later = later
        self.change += np.outer(np.concatenate(self._rates), later)

    def _slopes(self, m: int) -> list[Slope]:
        rows = self.change[PARTS * m : PARTS * (m + 1)]
        return [Slope(float(v), row) for v, row in zip(self.states[m], rows, strict=True)]

    def _seen(self, n: Any, slopes: list[Slope], m: int) -> InContactFrame:
        velocity, slip = (slopes[2], slopes[3]), (slopes[4], slopes[5])
        radius: Any = self._balls[m].radius
        return to_contact_frame(n, velocity, slip, slopes[6], radius)  # type: ignore[arg-type]

    def _send_off(self, m: int, n: Any, seen: InContactFrame) -> None:
        velocity, slip = from_contact_frame(n, seen)
        for part, one in enumerate((*velocity, *slip, seen.wz)):
            slope: Any = one
            row = slope.slope if isinstance(slope, Slope) else 0.0
            self.change[PARTS * m + 2 + part] = row

    def _leave(self) -> None:
        """Shift changes back to the time of the event, along the motion after it."""
        for m, (ball, k) in enumerate(zip(self._balls, self._after, strict=True)):
            rows = self.change[PARTS * m : PARTS * (m + 1)]
            if not self._slides:  # a rolling ball's velocity determines its spin
                rows[SLIP] = 0.0
            ball.hold(k, rows)
            _, rate = ball.rates(k, 0.0)
            rows -= np.outer(rate, self.later)


def _meets(normal: FloatArray, parting: FloatArray, reach: float, pull: FloatArray) -> Approach:
    """Return how a ball approaches a body; `pull` [m/s^2] is the rate of change of `parting`."""
    approach, slowing = -float(normal @ parting), float(normal @ pull)
    across = abs(float(normal[0] * parting[1] - normal[1] * parting[0])) / np.hypot(*parting)
    depth = reach * (1.0 - float(across)) if math.isfinite(reach) else math.inf
    return Approach(
        normal, parting, depth, 0.5 * approach**2 / slowing if slowing > 0.0 else math.inf
    )
