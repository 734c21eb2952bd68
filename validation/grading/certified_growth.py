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
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ghostball.engine import EventKind, Scene
from ghostball.reference_adapters.certified import Certificate
from ghostball.validation.grading.certified_events import EventChange, event_changes
from ghostball.validation.grading.certified_flow import PARTS, ProvedBall
from ghostball.validation.grading.tolerances import ROUNDINGS, TOLERANCE, UNIT_ROUNDOFF

FloatArray = NDArray[np.float64]

_BETWEEN = 4
"""Parts that the time between two events is cut into where growth is looked for."""

_HALVINGS = 40
"""Of the time in which a growth passes a limit, between two looks."""

GRID = 2.0**-20
"""Horizons are whole multiples of it [s]: how a matrix product rounds doesn't decide which."""


@dataclass(frozen=True, eq=False)
class Lateness:
    """What it changes of a shot's end to see one of its events late, per second.

    Attributes
    ----------
    kinds : tuple of EventKind, one for each event
    times : (events,) float64 [s]
    balls : tuple of tuple of int
        The balls of each.
    approach : (events,) float64 [m/s]
        At which speed what collides meets; 0 for events that are no collision.
    lasts : (events,) float64 [s]
        For how long two balls that collide would overlap if they went on; inf for other events.
    places : (events, n) float64 [m/s]
        How far each ball ends from where it should; NaN where no derivative exists.
    """

    kinds: tuple[EventKind, ...]
    times: FloatArray
    balls: tuple[tuple[int, ...], ...]
    approach: FloatArray
    lasts: FloatArray
    places: FloatArray


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
        where none has. Later there is no derivative of what follows from them. 0 where balls may
        fly: nothing is known here of how errors grow then, so that `sizes` are infinite.
    """

    t_end: float
    times: FloatArray
    derivative_ends: float
    _balls: tuple[ProvedBall, ...]
    _events: tuple[EventChange, ...]
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
            _go_on(ball, kept[i], 0)
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
                    _go_on(self._balls[i], kept[i], k)
        return CarriedChanges(self._balls, tuple(kept), shifts)

    def sizes(self, times: ArrayLike) -> FloatArray:
        """Return how far rounding displaces each ball, over 2^-53: (k, n) [m], root mean square.

        Of rounding each number of the state once at the start and at each event. Infinite where no
        derivative is known: from `derivative_ends` on.
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

    def lateness(self) -> Lateness:
        """Return what it changes of the shot's end to see each of its events late.

        Backwards along the shot: how the end depends on the balls as each event leaves them, times
        what a second of delay changes there.
        """
        n, size = len(self._balls), PARTS * len(self._balls)
        end = np.zeros((2 * n, size))
        for i, ball in enumerate(self._balls):
            _, flow = ball.displacement(np.array([self.t_end]))
            end[2 * i : 2 * i + 2, PARTS * i : PARTS * (i + 1)] = flow[0]
        moved = np.full((len(self._events), 2 * n), np.nan)
        with np.errstate(over="ignore", invalid="ignore"):
            for e in reversed(range(len(self._events))):
                event, rows = self._events[e], _rows(self._events[e].balls)
                if event.matrix is None or event.late is None:
                    break  # what comes before it has no derivative at the end
                moved[e] = end[:, rows] @ event.late
                end[:, rows] = end[:, rows] @ event.matrix
        places = np.hypot(moved[:, ::2], moved[:, 1::2])
        return Lateness(
            tuple(event.kind for event in self._events),
            np.array([event.t for event in self._events]),
            tuple(event.balls for event in self._events),
            np.array([event.approach for event in self._events]),
            np.array([event.lasts for event in self._events]),
            places,
        )

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
    physics = scene.physics
    # Of the air's drag the cloth's grip takes 2/7, but none where balls always roll.
    felt = physics.air_drag * (5.0 / 7.0 if slides else 1.0)
    balls = tuple(
        ProvedBall(
            knots,
            starts,
            float(radius),
            float(sliding),
            float(rolling),
            float(spinning),
            felt + physics.rolling_friction_quadratic,
            physics.air_drag,
            certificate.lifts,
        )
        for knots, starts, radius, sliding, rolling, spinning in zip(
            certificate.knots,
            certificate.starts,
            scene.radii,
            scene.sliding_frictions * gravity * slides,
            scene.rolling_frictions * gravity,
            scene.spinning_friction_rates,
            strict=True,
        )
    )
    # A long chaotic motion outgrows doubles; bounces that die out meet at speeds below them.
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        events = tuple(event_changes(scene, certificate, balls))
    return CertifiedGrowth(
        float(certificate.t_end),
        np.unique([0.0, *(event.t for event in events)]),
        0.0
        if certificate.lifts
        else min((event.t for event in events if event.matrix is None), default=math.inf),
        balls,
        events,
        _covariances(balls, events),
    )


def _go_on(ball: ProvedBall, kept: FloatArray, k: int) -> None:
    """Carry the changes at a start, (7, m), to the knots that go on with its motion."""
    for row, flow in ball.along(k):
        kept[row] = flow @ kept[row - 1]


def _rows(balls: tuple[int, ...]) -> NDArray[np.intp]:
    """Return the rows of some balls among those of all."""
    return np.concatenate([np.arange(PARTS * i, PARTS * (i + 1)) for i in balls])


def _covariances(
    balls: tuple[ProvedBall, ...], events: tuple[EventChange, ...]
) -> tuple[FloatArray, ...]:
    """Return the covariance of what rounding has done to each ball at its knots, (k, 7, 7) each."""
    size = PARTS * len(balls)
    whole = np.zeros((size, size))
    kept = [np.full((len(ball.knots), PARTS, PARTS), np.nan) for ball in balls]
    for i, ball in enumerate(balls):
        here = slice(PARTS * i, PARTS * (i + 1))
        whole[here, here] = kept[i][0] = ball.noise(0, ())
        _spread(ball, kept[i], 0)
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
                _spread(balls[i], kept[i], k)
    return tuple(kept)


def _spread(ball: ProvedBall, kept: FloatArray, k: int) -> None:
    """Carry the covariance at a start, (7, 7), to the knots that go on with its motion."""
    for row, flow in ball.along(k):
        kept[row] = flow @ kept[row - 1] @ flow.T
