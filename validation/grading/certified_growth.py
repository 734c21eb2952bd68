"""How errors grow along a proved shot: the grader's own tangent map, which owes our engine nothing.

    >>> growth = growth_of_proof(scene, certify(scene, motion=True))
    >>> growth.sizes([1.0])     # what rounding does to each ball until then, over 2^-53: (1, n) [m]
    >>> growth.horizon(1e-3, 32 * 2.0**-53)

A small change of a ball follows the derivative of its closed form between events; an event h = 0
comes later for it by dtau = -(grad h . dz) / (grad h . f), and takes it to
dz+ = DG (dz- + f- dtau) - f+ dtau, f the rate of change before and after. DG, the derivative of
what the event does, is that of the certified engine's own laws, by automatic differentiation. The
motion is the proved one. So a bug in the tangent map of the engine that is graded changes no grade,
and one in its laws changes nothing here.

What rounding does is carried as a covariance: exact but for its own rounding, and whatever the
order of the balls.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ghostball.engine import EventKind, Scene
from ghostball.engine.result import COLLISION_KINDS
from ghostball.reference_adapters.certified import Certificate
from ghostball.reference_adapters.certified.gaps import SIDES
from ghostball.reference_adapters.certified.laws import Laws, Seen, seen_along, seen_from_table
from ghostball.reference_adapters.certified.problem import problem_of
from ghostball.validation.grading.certified_flow import PARTS, PLACE, SLIP, VELOCITY, ProvedBall
from ghostball.validation.grading.slope import Slope
from ghostball.validation.grading.tolerances import ROUNDINGS, TOLERANCE, UNIT_ROUNDOFF

FloatArray = NDArray[np.float64]

_BETWEEN = 4
"""Parts that the time between two events is cut into where growth is looked for."""

_HALVINGS = 40
"""Of the time in which a growth passes a limit, between two looks."""

GRID = 2.0**-20
"""Horizons are whole multiples of it [s]: how a matrix product rounds doesn't decide which."""


class _Event(NamedTuple):
    """What an event does to changes of its balls, and how rounding of it adds to them."""

    t: float
    balls: tuple[int, ...]
    knots: tuple[int, ...]  # that each ball comes to
    matrix: FloatArray | None  # (7 b, 7 b), from those at the knots before; None: no derivative
    later: FloatArray | None  # (7 b,) by how much later the event comes, likewise
    noise: tuple[FloatArray, ...]  # (7, 7) of each ball: covariance of one rounding of its state


@dataclass(frozen=True, eq=False)
class CertifiedGrowth:
    """How changes grow along a proved motion; made by `growth_of_proof`.

    Attributes
    ----------
    t_end : float [s]
    times : (k,) float64 [s]
        Of its events, increasing, from 0 on.
    derivative_ends : float [s]
        When a ball first has two collisions at one instant, whose order any change decides; inf
        where none has. Later there is no derivative of what follows from them.
    """

    t_end: float
    times: FloatArray
    derivative_ends: float
    _balls: tuple[ProvedBall, ...]
    _events: tuple[_Event, ...]
    _covariances: tuple[FloatArray, ...]

    def carry(self, directions: FloatArray) -> CarriedChanges:
        """Return what becomes of small changes of the first state, (m, n, 7).

        Each a change of every ball's position x, y [m], velocity x, y [m/s] and angular velocity
        x, y, z [rad/s], as `Result.tangent` has them.
        """
        m, size = len(directions), PARTS * len(self._balls)
        whole = np.zeros((size, m))
        kept = [np.full((len(ball.knots), PARTS, m), np.nan) for ball in self._balls]
        shifts = np.full((len(self._events), m), np.nan)
        for i, ball in enumerate(self._balls):
            rows = slice(PARTS * i, PARTS * (i + 1))
            whole[rows] = kept[i][0] = ball.changed(directions[:, i].T)
        with np.errstate(over="ignore", invalid="ignore"):
            for e, event in enumerate(self._events):
                rows_of = _rows(event.balls)
                if event.matrix is None or event.later is None:
                    whole[rows_of] = np.nan
                else:
                    shifts[e] = event.later @ whole[rows_of]
                    whole[rows_of] = event.matrix @ whole[rows_of]
                for i, k in zip(event.balls, event.knots, strict=True):
                    kept[i][k] = whole[PARTS * i : PARTS * (i + 1)]
        return CarriedChanges(self._balls, tuple(kept), shifts)

    def sizes(self, times: ArrayLike) -> FloatArray:
        """Return how far rounding displaces each ball, over 2^-53: (k, n) [m], root mean square.

        Of rounding each number of the state once at the start and at each event. Infinite where no
        derivative exists: once a ball has had two collisions at one instant.
        """
        t = np.atleast_1d(np.asarray(times, dtype=np.float64))
        sizes = np.empty((len(t), len(self._balls)))
        for k, (ball, kept) in enumerate(zip(self._balls, self._covariances, strict=True)):
            rows, flow = ball.displacement(t)
            with np.errstate(over="ignore", invalid="ignore"):
                variance = np.einsum("kij,kjl,kil->k", flow, kept[rows], flow)
                size = np.sqrt(np.maximum(variance, 0.0))
            sizes[:, k] = np.where(np.isfinite(variance), size, np.inf)
        return sizes

    @property
    def rounding_horizon(self) -> float:
        """Until when `ROUNDINGS` roundings at each event leave the shot predictable [s]."""
        return self.horizon(TOLERANCE, ROUNDINGS * UNIT_ROUNDOFF)

    def horizon(self, tolerance: float, error: float) -> float:
        """Return until when errors stay within a tolerance [s].

        Infinite where they do to the end, or as long as there is a derivative.

        Parameters
        ----------
        tolerance : float [m]
        error : float
            Relative size of the error that is made at the start and at each event.
        """
        limit = tolerance / error
        marks = np.append(self.times, self.t_end) if self.times[-1] < self.t_end else self.times
        parts = np.arange(_BETWEEN) / _BETWEEN
        inner = marks[:-1, np.newaxis] + np.diff(marks)[:, np.newaxis] * parts
        looks = np.append(inner.ravel(), marks[-1])
        looks = looks[looks < self.derivative_ends]
        beyond = np.flatnonzero(~(np.max(self.sizes(looks), axis=1) <= limit))
        if not len(beyond):
            return math.inf
        first = int(beyond[0])
        low, high = float(looks[max(first - 1, 0)]), float(looks[first])
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            if float(np.max(self.sizes([middle]))) <= limit:
                low = middle
            else:
                high = middle
        return math.floor(high / GRID) * GRID


@dataclass(frozen=True, eq=False)
class CarriedChanges:
    """What becomes of m small changes of a shot's first state.

    Attributes
    ----------
    event_shifts : (events, m) float64 [s]
        How much later each event comes; NaN where no derivative exists.
    """

    _balls: tuple[ProvedBall, ...]
    _kept: tuple[FloatArray, ...]
    event_shifts: FloatArray

    def sample(self, times: FloatArray) -> FloatArray:
        """Return the changes of the balls' positions at some instants, (k, m, n, 2) [m]."""
        out = np.empty((len(times), self.event_shifts.shape[1], len(self._balls), 2))
        for i, (ball, kept) in enumerate(zip(self._balls, self._kept, strict=True)):
            rows, flow = ball.displacement(times)
            with np.errstate(over="ignore", invalid="ignore"):
                out[:, :, i] = (flow @ kept[rows]).transpose(0, 2, 1)
        return out


@lru_cache(maxsize=4)  # by identity: a case that comes from another process has its own
def growth_of_proof(scene: Scene, certificate: Certificate) -> CertifiedGrowth:
    """Return how errors grow along what is proved of a shot, whose certificate has its motion."""
    assert certificate.knots is not None
    gravity = scene.physics.gravity
    slides = scene.physics.motion == "sliding"
    balls = tuple(
        ProvedBall(knots, float(radius), float(sliding), float(rolling), float(spinning))
        for knots, radius, sliding, rolling, spinning in zip(
            certificate.knots,
            scene.radii,
            scene.sliding_frictions * gravity * slides,
            scene.rolling_frictions * gravity,
            scene.spinning_friction_rates,
            strict=True,
        )
    )
    # A long chaotic motion outgrows doubles; bounces that die out meet at speeds below them.
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        events = tuple(_events(scene, certificate, balls))
    return CertifiedGrowth(
        float(certificate.t_end),
        np.unique([0.0, *(event.t for event in events)]),
        min((event.t for event in events if event.matrix is None), default=math.inf),
        balls,
        events,
        _covariances(balls, events),
    )


def _events(
    scene: Scene, certificate: Certificate, balls: tuple[ProvedBall, ...]
) -> Iterator[_Event]:
    """Yield what each event does; nothing is known from a ball's second collision at an instant."""
    laws = Laws(problem_of(scene))
    at = [0] * len(balls)
    times = [float(event.t) for event in certificate.events]
    due: dict[tuple[int, float], int] = {}
    for event, t in zip(certificate.events, times, strict=True):
        if event.kind in COLLISION_KINDS:
            for ball in _involved(event.kind, event.a, event.b):
                due[ball, t] = due.get((ball, t), 0) + 1
    for event, t in zip(certificate.events, times, strict=True):
        involved = _involved(event.kind, event.a, event.b)
        mine = tuple(balls[i] for i in involved)
        before = tuple(at[i] for i in involved)
        for i in involved:
            at[i] += 1
        after = tuple(at[i] for i in involved)
        if event.kind in COLLISION_KINDS and any(due[i, t] > 1 for i in involved):
            yield _Event(t, involved, after, None, None, ())
            continue
        passes = _Passage(mine, before, after, t, slides=scene.physics.motion == "sliding")
        if event.kind is EventKind.BALL_BALL:
            passes.collide(laws, event.a, event.b)
        elif event.kind is EventKind.BALL_CUSHION:
            passes.bounce(laws, event.a, event.b)
        else:
            passes.end_phase()
        noise = tuple(ball.noise(k, passes.states) for ball, k in zip(mine, after, strict=True))
        yield _Event(t, involved, after, passes.change, passes.later, noise)


def _involved(kind: EventKind, a: int, b: int) -> tuple[int, ...]:
    return (a, b) if kind is EventKind.BALL_BALL else (a,)


class _Passage:
    """Changes of the balls of one event, carried from their knots before it to those after it.

    Attributes
    ----------
    states : tuple of (7,) float64
        Of the balls, just before.
    change : (7 b, 7 b) float64
        Of the balls by those at the knots before.
    later : (7 b,) float64
        By how much later the event comes.
    """

    def __init__(
        self,
        balls: tuple[ProvedBall, ...],
        before: tuple[int, ...],
        after: tuple[int, ...],
        t: float,
        *,
        slides: bool,
    ) -> None:
        self._balls, self._before, self._after, self._slides = balls, before, after, slides
        spans = [t - ball.knots[k, 0] for ball, k in zip(balls, before, strict=True)]
        moving = [ball.rates(k, s) for ball, k, s in zip(balls, before, spans, strict=True)]
        self.states = tuple(state for state, _ in moving)
        self._rates = tuple(rate for _, rate in moving)
        size = PARTS * len(balls)
        self.change = np.zeros((size, size))
        self.later = np.zeros(size)
        for m, (ball, k, s) in enumerate(zip(balls, before, spans, strict=True)):
            here = slice(PARTS * m, PARTS * (m + 1))
            self.change[here, here] = ball.flow(k, s)

    def collide(self, laws: Laws, a: int, b: int) -> None:
        """Pass an impact of two balls."""
        apart = self.states[1][PLACE] - self.states[0][PLACE]
        normal = apart / np.hypot(*apart)
        opening = float(normal @ (self.states[1][VELOCITY] - self.states[0][VELOCITY]))
        gap = normal @ (self.change[PARTS : PARTS + 2] - self.change[PLACE])
        self._come_later(-gap / opening)
        first, second = self._slopes(0), self._slopes(1)
        x, y = (q - p for p, q in zip(first[:2], second[:2], strict=True))
        size = (x * x + y * y).sqrt()
        n = (x / size, y / size)
        seen = [self._seen(n, slopes, m) for m, slopes in enumerate((first, second))]
        for m, one in enumerate(laws.collide(a, b, *seen)):
            self._send_off(m, n, one)
        self._leave()

    def bounce(self, laws: Laws, ball: int, cushion: int) -> None:
        """Pass an impact of a ball with a cushion."""
        inward = np.array(SIDES[cushion], dtype=np.float64)
        self._come_later(-(inward @ self.change[PLACE]) / float(inward @ self.states[0][VELOCITY]))
        n = (-float(inward[0]), -float(inward[1]))
        self._send_off(0, n, laws.bounce(ball, self._seen(n, self._slopes(0), 0)))
        self._leave()

    def end_phase(self) -> None:
        """Pass the end of a slide, of |u| / (7/2 mu_s g), or of a roll, of |v| / (mu_r g)."""
        ball, k = self._balls[0], self._before[0]
        of, slowing = (SLIP, 3.5 * ball.slides_by) if ball.slides(k) else (VELOCITY, ball.rolls_by)
        # Against the way of the acceleration: doubles may leave nothing of a slip of rounding size.
        pull = np.array(ball.pull(k))
        later = np.zeros(PARTS)
        later[of] = -pull / (slowing * np.hypot(*pull))
        self._come_later(later)
        self._leave()

    def _come_later(self, later: FloatArray) -> None:
        """Bring changes from the event's instant to where the event is for each."""
        self.later = later
        self.change += np.outer(np.concatenate(self._rates), later)

    def _slopes(self, m: int) -> list[Slope]:
        rows = self.change[PARTS * m : PARTS * (m + 1)]
        return [Slope(float(v), row) for v, row in zip(self.states[m], rows, strict=True)]

    def _seen(self, n: Any, slopes: list[Slope], m: int) -> Seen:
        velocity, slip = (slopes[2], slopes[3]), (slopes[4], slopes[5])
        radius: Any = self._balls[m].radius
        return seen_along(n, velocity, slip, slopes[6], radius)  # type: ignore[arg-type]

    def _send_off(self, m: int, n: Any, seen: Seen) -> None:
        velocity, slip = seen_from_table(n, seen)
        for part, one in enumerate((*velocity, *slip, seen.wz)):
            slope: Any = one
            row = slope.slope if isinstance(slope, Slope) else 0.0
            self.change[PARTS * m + 2 + part] = row

    def _leave(self) -> None:
        """Bring changes back to the event's instant, on the motion after it."""
        for m, (ball, k) in enumerate(zip(self._balls, self._after, strict=True)):
            rows = self.change[PARTS * m : PARTS * (m + 1)]
            if not self._slides:  # a ball that always rolls has the spin of its velocity
                rows[SLIP] = 0.0
            ball.hold(k, rows)
            _, rate = ball.rates(k, 0.0)
            rows -= np.outer(rate, self.later)


def _rows(balls: tuple[int, ...]) -> NDArray[np.intp]:
    """Return the rows of some balls among those of all."""
    return np.concatenate([np.arange(PARTS * i, PARTS * (i + 1)) for i in balls])


def _covariances(
    balls: tuple[ProvedBall, ...], events: tuple[_Event, ...]
) -> tuple[FloatArray, ...]:
    """Return the covariance of what rounding has done to each ball at its knots, (k, 7, 7) each."""
    size = PARTS * len(balls)
    whole = np.zeros((size, size))
    kept = [np.full((len(ball.knots), PARTS, PARTS), np.nan) for ball in balls]
    for i, ball in enumerate(balls):
        here = slice(PARTS * i, PARTS * (i + 1))
        whole[here, here] = kept[i][0] = ball.noise(0, ())
    with np.errstate(over="ignore", invalid="ignore"):
        for event in events:
            rows = _rows(event.balls)
            if event.matrix is None:
                whole[rows] = whole[:, rows] = np.nan
            else:
                passed = event.matrix @ whole[rows]
                whole[rows], whole[:, rows] = passed, passed.T
                whole[np.ix_(rows, rows)] = passed[:, rows] @ event.matrix.T
            for i, k, noise in zip(event.balls, event.knots, event.noise, strict=False):
                here = slice(PARTS * i, PARTS * (i + 1))
                whole[here, here] += noise
                kept[i][k] = whole[here, here]
    return tuple(kept)
