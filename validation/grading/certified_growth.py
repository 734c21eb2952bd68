"""How errors grow along a proved shot: the grader's own tangent map, which owes our engine nothing.

    >>> growth = growth_of_proof(scene, certify(scene, motion=True))
    >>> growth.sizes([1.0])     # what rounding does to each ball until then, over 2^-53: (1, n) [m]

A small change of a ball follows the derivative of its closed form between events; an event h = 0
comes later for it by dtau = -(grad h . dz) / (grad h . f), and takes it to
dz+ = DG (dz- + f- dtau) - f+ dtau, f the rate of change before and after. DG, the derivative of
what the event does, is that of the certified engine's own laws, by automatic differentiation. The
motion is the proved one. So a bug in the tangent map of the engine that is graded changes no grade,
and one in its laws changes nothing here.

What rounding does is carried as a covariance: exact but for its own rounding, and whatever the
order of the balls. Rounded are the state, at the start and at each event, and the distance by which
what collides touches: of a thin hit, or of one whose approach is slow, that makes the instant far
more uncertain than the places are.
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
    ProvedBall,
    rows_of,
)
from ghostball.validation.grading.tolerances import EPS

_CANCELLED = 16.0 * EPS
"""Largest remainder of variance terms that cancel, in units of their sizes."""


@dataclass(frozen=True, eq=False)
class Rounding:
    """What rounding each number of the state once, at the start and at each event, does to a shot.

    Over 2^-53; root mean square along a proved motion, the most that is possible in flight.
    Infinite where no derivative is known.

    `events` (events,) float64 [s]: how far it moves the instant of each event of the proof.
    `rest` [s]: how far it moves the end of the shot.
    `times`, `energies` (k,) float64 [s], [J]: how far it moves the energy of all balls, from each
        instant to the next; never less than before.
    `marks` (m,) float64 [s], `places` (m, n) float64 [m]: how far it moves each ball, likewise.
    `speeds` (m, n) float64 [m/s]: by how much it changes the velocity of each ball and of its
        surface, likewise.
    """

    events: FloatArray
    rest: float
    times: FloatArray
    energies: FloatArray
    marks: FloatArray
    places: FloatArray
    speeds: FloatArray

    def energy_at(self, times: FloatArray) -> FloatArray:
        """Return how far rounding moves the energy at some instants, (k,) [J]."""
        return _since(self.times, self.energies, times)

    def places_at(self, times: FloatArray) -> FloatArray:
        """Return how far rounding moves each ball at some instants, (k, n) [m]."""
        return _since(self.marks, self.places, times)

    def speeds_at(self, times: FloatArray) -> FloatArray:
        """Return by how much rounding changes the speeds of each ball, (k, n) [m/s]."""
        return _since(self.marks, self.speeds, times)


def _since(marks: FloatArray, values: FloatArray, times: FloatArray) -> FloatArray:
    """Return the values that hold at some instants, of those from each mark to the next."""
    found: FloatArray = values[np.searchsorted(marks, times, side="right") - 1]
    return found


def places_between(
    sizes: Callable[[FloatArray], FloatArray], times: FloatArray, t_end: float
) -> tuple[FloatArray, FloatArray]:
    """Return instants (m,) [s], and the most that errors come to from each to the next, (m, n) [m].

    `sizes`: what errors have become of each ball at some instants.
    `times` (k,) float64 [s]: of the events. Between two of them the error of a ball's place is a
        convex function of the time: the larger of those at both ends bounds it.
    """
    marks = np.unique(np.append(times, t_end))
    sides = [sizes(np.maximum(np.nextafter(marks, 0.0), 0.0)), sizes(marks)]
    grown = np.maximum.accumulate(np.maximum(*sides), axis=0)
    return marks, np.concatenate([grown[1:], grown[-1:]])


@dataclass(frozen=True, eq=False)
class CertifiedGrowth:
    """How changes grow along a proved motion: `horizon.Growth`; made by `growth_of_proof`.

    `t_end` [s].
    `times` (k,) float64 [s]: of its events, increasing, from 0 on.
    `derivative_ends` [s]: when a ball first has two collisions at one instant, whose order any
        change decides; inf where none has. Later there is no derivative of what follows from them.
        0 where balls may fly: nothing is known here of how errors grow then, so that `sizes` are
        infinite.
    `events`: what each event does to small changes of its balls.
    """

    t_end: float
    times: FloatArray
    derivative_ends: float
    balls: tuple[ProvedBall, ...]
    events: tuple[EventChange, ...]
    _covariances: tuple[FloatArray, ...]
    _moved: FloatArray  # (events,) [s]: how far rounding moves each, over 2^-53

    def sizes(self, times: ArrayLike) -> FloatArray:
        """Return how far rounding displaces each ball, over 2^-53: (k, n) [m], root mean square.

        Of rounding each number of the state once at the start and at each event, and each distance
        at which something collides. Infinite where no derivative is known: from `derivative_ends`
        on.
        """
        t = np.atleast_1d(np.asarray(times, dtype=np.float64))
        sizes = np.empty((len(t), len(self.balls)))
        for k, (ball, kept) in enumerate(zip(self.balls, self._covariances, strict=True)):
            rows, flow = ball.displacement(t)
            with np.errstate(over="ignore", invalid="ignore"):
                variance = np.einsum("kij,kjl,kil->k", flow, kept[rows], flow)
                # Where large terms cancel, as those of balls that meet slowly, what is left of them
                # is their rounding.
                terms = np.einsum("kij,kjl,kil->k", abs(flow), abs(kept[rows]), abs(flow))
                size = np.sqrt(np.maximum(variance, 0.0) + _CANCELLED * terms)
            sizes[:, k] = np.where(np.isfinite(variance), size, np.inf)
        return sizes

    def rounding(self, scene: Scene) -> Rounding:
        """Return what rounding does to the times of events and to the energy of this scene's shot.

        The standard deviation of a sum is no more than the sum of those of its parts, here of the
        balls. A ball's energy changes with the time as a linear function of its first change while
        it slides, and ever less while it rolls; so the larger of what it is at the ends of a
        segment bounds it between.
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
        return Rounding(events, self._rest_moved(events), starts, energies, marks, places, speeds)

    def _speeds_changed(self, marks: FloatArray) -> FloatArray:
        """Return by how much rounding changes the speeds of each ball until then, (m, n) [m/s].

        Friction turns with the slip, and takes 2/7 of it from the velocity in all, and 5/7 from the
        surface's; so a change of the slip changes either by no more than twice itself. What slows a
        ball that rolls leaves a change of its velocity as it is, or makes it smaller.
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
        # Else `t_max` ends the shot, or a ball that spins on its place.
        spins = [
            math.sqrt(float(kept[-1, SPIN, SPIN])) / ball.spins_by
            for ball, kept in zip(self.balls, self._covariances, strict=True)
            if ball.spins_by > 0.0 and np.isfinite(kept[-1, SPIN, SPIN])
        ]
        return self.t_end + max(spins, default=0.0)


@lru_cache(maxsize=4)  # by identity: a case that comes from another process has its own
def growth_of_proof(
    scene: Scene, certificate: Certificate, *, gaps: bool = True
) -> CertifiedGrowth:
    """Return how errors grow along what is proved of a shot, whose certificate has its motion.

    `gaps`: whether distances at which something collides are rounded, too, or the states alone.
    """
    assert certificate.segments is not None
    gravity = scene.physics.gravity
    slides = scene.physics.motion == "sliding"
    physics = scene.physics
    # Of the air's drag the cloth's friction takes 2/7, but none where balls always roll.
    felt = physics.air_drag * (5.0 / 7.0 if slides else 1.0)
    balls = tuple(
        ProvedBall(
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
        *_covariances(balls, events, gaps),
    )


def energy_slopes(ball: ProvedBall, mass: float) -> FloatArray:
    """Return the derivative of a ball's energy by its state as each segment starts, (k, 7).

    E = m v^2 / 2 + m (v - u)^2 / 5 + m R^2 wz^2 / 5, since a ball turns about the horizontal by its
    velocity v less its slip u, over R.
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
    balls: tuple[ProvedBall, ...], events: tuple[EventChange, ...], gaps: bool
) -> tuple[tuple[FloatArray, ...], FloatArray]:
    """Return the covariance of what rounding has done to each ball at its segments, (k, 7, 7).

    And how far it has moved each event, (events,) [s].
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
                whole[rows, rows] += _CANCELLED * np.diag(terms)
            if gaps and event.late is not None:
                moved = event.rounded * event.late
                whole[np.ix_(rows, rows)] += np.outer(moved, moved)
            for i, k, noise in zip(event.balls, event.segments, event.noise, strict=False):
                here = slice(PARTS * i, PARTS * (i + 1))
                whole[here, here] += noise
                kept[i][k] = whole[here, here]
                _spread(balls[i], kept[i], k)
    return tuple(kept), delayed


def _spread(ball: ProvedBall, kept: FloatArray, k: int) -> None:
    """Carry the covariance at a start, (7, 7), to the segments that continue with its motion."""
    for row, flow in ball.along(k):
        kept[row] = flow @ kept[row - 1] @ flow.T
