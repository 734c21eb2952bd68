"""Error growth along a certified shot: a tangent map that is independent of Ghostball's engine.

    >>> growth = growth_of_certificate(scene, certify(scene, motion=True))
    >>> growth.sizes([1.0])     # displacement of each ball by rounding, over 2^-53: (1, n) [m]

Between events, a small change of a ball follows the derivative of its closed form. A change delays
an event h = 0 by dtau = -(grad h . dz) / (grad h . f), and the event turns it into dz+ = DG (dz- +
f- dtau) - f+ dtau, where f is the rate of change before and after. DG, the derivative of the event,
is computed from the laws of the certified engine by automatic differentiation. The motion is the
certified one. An error in the tangent map of the judged engine therefore changes no grade, and an
error in its laws has no effect here.

The effect of rounding is propagated as a covariance. It is exact except for its own rounding, and
independent of the order of balls. The state is rounded at the start and at each event, and so is
the distance at which bodies touch: in a thin hit, or a slow approach, this makes the time of
contact much more uncertain than the positions are.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from ghostball.model import Scene, first_energy
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.certified import Certificate
from ghostball.validation.grading.certified_events import EventChange, event_changes
from ghostball.validation.grading.certified_flow import (
    PARTS,
    SLIP,
    SPIN,
    VELOCITY,
    CertifiedBall,
    rows_of,
)
from ghostball.validation.grading.tolerances import EPS

_CANCELLATION = 16.0 * EPS
"""Largest remainder of variance terms that cancel, in units of their sizes."""


@dataclass(frozen=True, eq=False)
class RoundingEffects:
    """The effects on a shot of rounding each number of the state at the start and at each event.

    All values are divided by 2^-53. They are rms values along a certified motion, upper bounds in
    flight, and infinite if no derivative is known.

    `events` (events,) float64 [s]: shift of the time of each certified event.
    `rest` [s]: shift of the end of the shot.
    `times`, `energies` (k,) float64 [s], [J]: change of the energy of all balls, from each time to
        the next; non-decreasing.
    `marks` (m,) float64 [s], `places` (m, n) float64 [m]: displacement of each ball, likewise.
    `speeds` (m, n) float64 [m/s]: change of the velocity of each ball and of its surface, likewise.
    """

    events: FloatArray
    rest: float
    times: FloatArray
    energies: FloatArray
    marks: FloatArray
    places: FloatArray
    speeds: FloatArray

    def energy_at(self, times: FloatArray) -> FloatArray:
        """Return the effect of rounding on the energy at some times, (k,) [J]."""
        return _since(self.times, self.energies, times)

    def places_at(self, times: FloatArray) -> FloatArray:
        """Return the displacement of each ball by rounding at some times, (k, n) [m]."""
        return _since(self.marks, self.places, times)

    def speeds_at(self, times: FloatArray) -> FloatArray:
        """Return the effect of rounding on the speeds of each ball, (k, n) [m/s]."""
        return _since(self.marks, self.speeds, times)


def _since(marks: FloatArray, values: FloatArray, times: FloatArray) -> FloatArray:
    """Return the values at some times, where each value applies from its mark to the next."""
    found: FloatArray = values[np.searchsorted(marks, times, side="right") - 1]
    return found


def places_between(
    sizes: Callable[[FloatArray], FloatArray], times: FloatArray, t_end: float
) -> tuple[FloatArray, FloatArray]:
    """Return times (m,) [s], and the largest error from each time to the next, (m, n) [m].

    `sizes`: returns the errors of each ball at some times.
    `times` (k,) float64 [s]: of the events. Between two events, the position error of a ball is a
        convex function of time, so the larger of its values at both ends is a bound.
    """
    marks = np.unique(np.append(times, t_end))
    sides = [sizes(np.maximum(np.nextafter(marks, 0.0), 0.0)), sizes(marks)]
    grown = np.maximum.accumulate(np.maximum(*sides), axis=0)
    return marks, np.concatenate([grown[1:], grown[-1:]])


@dataclass(frozen=True, eq=False)
class CertifiedGrowth:
    """Growth of changes along a certified motion (`horizon.Growth`), by `growth_of_certificate`.

    `t_end` [s].
    `times` (k,) float64 [s]: of its events, increasing, starting with 0.
    `derivative_ends` [s]: first time at which a ball has two simultaneous collisions, so any change
        decides their order; inf: never. There is no derivative after that. 0 if balls may fly: then
        error growth is unknown, and `sizes` are infinite.
    `events`: the effect of each event on small changes of its balls.
    """

    t_end: float
    times: FloatArray
    derivative_ends: float
    balls: tuple[CertifiedBall, ...]
    events: tuple[EventChange, ...]
    _covariances: tuple[FloatArray, ...]
    _moved: FloatArray  # (events,) [s]: shift of each by rounding, over 2^-53

    def sizes(self, times: ArrayLike) -> FloatArray:
        """Return the rms displacement of each ball by rounding, over 2^-53: (k, n) [m].

        Each number of the state is rounded once at the start and at each event, and so is each
        distance of colliding bodies. The sizes are infinite from `derivative_ends` on.
        """
        t = np.atleast_1d(np.asarray(times, dtype=np.float64))
        sizes = np.empty((len(t), len(self.balls)))
        for k, (ball, kept) in enumerate(zip(self.balls, self._covariances, strict=True)):
            rows, flow = ball.displacement(t)
            with np.errstate(over="ignore", invalid="ignore"):
                variance = np.einsum("kij,kjl,kil->k", flow, kept[rows], flow)
                # If large terms cancel, as for balls that collide slowly, the remainder is
                # rounding.
                terms = np.einsum("kij,kjl,kil->k", abs(flow), abs(kept[rows]), abs(flow))
                size = np.sqrt(np.maximum(variance, 0.0) + _CANCELLATION * terms)
            sizes[:, k] = np.where(np.isfinite(variance), size, np.inf)
        return sizes

    def rounding(self, scene: Scene) -> RoundingEffects:
        """Return the effects of rounding on the times of events and on the energy of this shot.

        The standard deviation of a sum is at most the sum of the standard deviations of its terms,
        here of the balls. The change of a ball's energy is a linear function of time during a
        slide, and decreases during a roll, so the larger of its values at the ends of a segment is
        a bound.
        """
        instants = np.array([event.t for event in self.events])
        starts = np.unique(np.concatenate([ball.segments[:, 0] for ball in self.balls]))
        first = first_energy(scene)
        energies = np.full(len(starts), first)
        with np.errstate(over="ignore", invalid="ignore"):
            for ball, mass, kept in zip(self.balls, scene.masses, self._covariances, strict=True):
                by = energy_slopes(ball, float(mass))
                moved = np.sqrt(np.maximum(np.einsum("ki,kij,kj->k", by, kept, by), 0.0))
                moved = np.maximum.accumulate(np.where(np.isfinite(moved), moved, np.inf))
                following = np.append(moved[1:], moved[-1])
                energies += following[np.searchsorted(ball.segments[:, 0], starts, "right") - 1]
        events = np.maximum(np.where(np.isfinite(self._moved), self._moved, np.inf), instants)
        marks, places = places_between(self.sizes, self.times, self.t_end)
        speeds = self._speeds_changed(marks)
        return RoundingEffects(
            events, self._rest_moved(events), starts, energies, marks, places, speeds
        )

    def _speeds_changed(self, marks: FloatArray) -> FloatArray:
        """Return the change of the speeds of each ball by rounding up to a time, (m, n) [m/s].

        Friction follows the direction of the slip, and in total takes 2/7 of it from the velocity
        and 5/7 from the surface velocity. A change of the slip therefore changes either by at most
        twice itself. During a roll, a change of the velocity is constant or decreases.
        """
        speeds = np.empty((len(marks), len(self.balls)))
        with np.errstate(over="ignore", invalid="ignore"):
            for i, (ball, kept) in enumerate(zip(self.balls, self._covariances, strict=True)):
                by = np.sqrt(np.maximum(np.einsum("kii->ki", kept), 0.0))
                changed = np.linalg.norm(by[:, VELOCITY], axis=1)
                changed += 2.0 * np.linalg.norm(by[:, SLIP], axis=1) + ball.radius * by[:, SPIN]
                changed = np.maximum.accumulate(np.where(np.isfinite(changed), changed, np.inf))
                rows = np.searchsorted(ball.segments[:, 0], marks, side="right") - 1
                speeds[:, i] = changed[rows]
        return speeds

    def _rest_moved(self, events: FloatArray) -> float:
        """Return the effect of rounding on the end time of the shot, over 2^-53 [s]."""
        if len(events) and self.events[-1].t == self.t_end:
            return float(events[-1])
        # Otherwise `t_max` ends the shot, or a ball that spins in place.
        spins = [
            math.sqrt(float(kept[-1, SPIN, SPIN])) / ball.spins_by
            for ball, kept in zip(self.balls, self._covariances, strict=True)
            if ball.spins_by > 0.0 and np.isfinite(kept[-1, SPIN, SPIN])
        ]
        return self.t_end + max(spins, default=0.0)


@lru_cache(maxsize=4)  # keyed by identity: a case from another process has its own
def growth_of_certificate(
    scene: Scene, certificate: Certificate, *, gaps: bool = True
) -> CertifiedGrowth:
    """Return the error growth along the certified part of a shot; its certificate needs the motion.

    `gaps`: whether distances of colliding bodies are rounded, too, or only the states.
    """
    assert certificate.segments is not None
    gravity = scene.physics.gravity
    slides = scene.physics.motion == "sliding"
    physics = scene.physics
    # The friction of the cloth reduces the effect of air drag by 2/7, except for balls that always
    # roll.
    felt = physics.air_drag * (5.0 / 7.0 if slides else 1.0)
    balls = tuple(
        CertifiedBall(
            segments,
            starts,
            float(radius),
            float(sliding),
            float(rolling),
            float(spinning),
            felt + physics.rolling_friction_quadratic,
            physics.air_drag,
            certificate.lifts,
        )
        for segments, starts, radius, sliding, rolling, spinning in zip(
            certificate.segments,
            certificate.starts,
            scene.radii,
            scene.sliding_frictions * gravity * slides,
            scene.rolling_frictions * gravity,
            scene.spinning_friction_rates,
            strict=True,
        )
    )
    # In a long chaotic motion numbers overflow, and in vanishing bounces speeds underflow.
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
        *_covariances(balls, events, gaps),
    )


def energy_slopes(ball: CertifiedBall, mass: float) -> FloatArray:
    """Return the derivative of a ball's energy by its state at the start of each segment, (k, 7).

    E = m v^2 / 2 + m (v - u)^2 / 5 + m R^2 wz^2 / 5: the horizontal angular velocity of a ball is
    its velocity v minus its slip u, divided by R.
    """
    rows = ball.segments
    velocity, slip = rows[:, 3:5], np.zeros((len(rows), 2))
    slides = [ball.slides(k) for k in range(len(rows))]
    slip[slides] = velocity[slides] + ball.radius * rows[slides][:, [8, 7]] * (-1.0, 1.0)
    by = np.zeros((len(rows), PARTS))
    by[:, SLIP] = -0.4 * mass * (velocity - slip)
    by[:, VELOCITY] = mass * velocity - by[:, SLIP]
    by[:, SPIN] = 0.4 * mass * ball.radius**2 * rows[:, 9]
    return by


def _covariances(
    balls: tuple[CertifiedBall, ...], events: tuple[EventChange, ...], gaps: bool
) -> tuple[tuple[FloatArray, ...], FloatArray]:
    """Return the covariance by rounding of each ball at its segments, (k, 7, 7), and event shifts.

    The shifts of the event times are (events,) [s].
    """
    size = PARTS * len(balls)
    whole = np.zeros((size, size))
    kept = [np.full((len(ball.segments), PARTS, PARTS), np.nan) for ball in balls]
    delayed = np.full(len(events), np.nan)
    for i, ball in enumerate(balls):
        here = slice(PARTS * i, PARTS * (i + 1))
        whole[here, here] = kept[i][0] = ball.noise(0, ())
        _spread(ball, kept[i], 0)
    with np.errstate(over="ignore", invalid="ignore"):
        for number, event in enumerate(events):
            rows = rows_of(event.balls)
            if event.later is not None:
                variance = event.later @ whole[np.ix_(rows, rows)] @ event.later
                variance += gaps * event.rounded**2
                delayed[number] = np.sqrt(np.maximum(variance, 0.0))
            if event.matrix is None:
                whole[rows] = whole[:, rows] = np.nan
            else:
                its = np.ix_(rows, rows)
                terms = abs(event.matrix) @ abs(whole[its]) @ abs(event.matrix.T)
                passed = event.matrix @ whole[rows]
                whole[rows], whole[:, rows] = passed, passed.T
                whole[its] = passed[:, rows] @ event.matrix.T
                whole[rows, rows] += _CANCELLATION * np.diag(terms)
            if gaps and event.late is not None:
                moved = event.rounded * event.late
                whole[np.ix_(rows, rows)] += np.outer(moved, moved)
            for i, k, noise in zip(event.balls, event.segments, event.noise, strict=False):
                here = slice(PARTS * i, PARTS * (i + 1))
                whole[here, here] += noise
                kept[i][k] = whole[here, here]
                _spread(balls[i], kept[i], k)
    return tuple(kept), delayed


def _spread(ball: CertifiedBall, kept: FloatArray, k: int) -> None:
    """Propagate the covariance at a start, (7, 7), to the segments that continue its motion."""
    for row, flow in ball.along(k):
        kept[row] = flow @ kept[row - 1] @ flow.T
