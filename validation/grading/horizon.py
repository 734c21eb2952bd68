"""Compute the predictability horizon of a shot: the time until which errors stay small.

    >>> horizon(growth_along(scene, certificate, result), TOLERANCE, ROUNDINGS * UNIT_ROUNDOFF)

If the whole shot is certified, the growth of errors is computed along the certified motion, so that
no engine decides how long it is judged: with the tangent map (`certified_growth`), or in flight
with the widths of the enclosures (`certified_widths`). Otherwise the tangent map of Ghostball's own
run is used.

The size of the initial errors depends on the engine: rounding for an exact engine, a contact
detected up to one step late for a time-stepping engine. Near misses do not shorten the horizon: an
engine that hits a ball before its errors have grown has a wrong collision.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ghostball.model import EventKind, Events, Result, Scene
from ghostball.model.arrays import FloatArray
from ghostball.model.impact_laws import BALL_LAWS, CUSHION_LAWS
from ghostball.reference_adapters.certified import Certificate
from ghostball.validation.grading.certified_growth import CertifiedGrowth, growth_of_certificate
from ghostball.validation.grading.certified_widths import FlightGrowth, is_differentiated
from ghostball.validation.grading.event_logs import events_in
from ghostball.validation.grading.tolerances import (
    BALANCED_SLOPE,
    INTEGRATED_IMPACT,
    ROUNDINGS,
    TIE,
    UNIT_ROUNDOFF,
    contact_error,
)
from ghostball.validation.runs.sampling import events_of

_INTERVALS = 4
"""Number of intervals between two events in which growth is sampled."""

_CHUNK = 256
"""Number of times that are sampled together: more would need too much memory for hundreds of balls.
"""

_MOST_TIMES = 2048
"""Largest number of times at which the growth along a whole shot is stored."""

_HALVINGS = 40
"""Number of bisections for the time at which a growth passes a limit."""

GRID = 2.0**-20
"""Horizons are multiples of this [s], so that the rounding of matrix products doesn't change them.
"""


class Growth(Protocol):
    """The growth of errors along a shot."""

    @property
    def times(self) -> FloatArray:
        """Times of its events, increasing, starting with 0: (k,) [s]."""

    @property
    def t_end(self) -> float:
        """End of the shot [s]."""

    @property
    def derivative_ends(self) -> float:
        """Time from which the growth is unknown, as after simultaneous hits [s]; inf: never."""

    def sizes(self, times: ArrayLike) -> FloatArray:
        """Return the displacement of each ball by relative errors of 1, at start and events.

        One row for each time, (k, n) [m]; infinite if the growth is unknown.
        """


def growth_along(scene: Scene, certificate: Certificate | None, result: Result) -> Growth:
    """Return the growth of errors along a shot: certified if all of it is, otherwise from a run.

    `certificate`: of the shot, with its motion; None if there is none.
    `result`: the run on Ghostball's engine, recorded with its trajectory.
    """
    if certificate is not None and certificate.proved:
        return growth_along_certificate(scene, certificate)
    return RunGrowth(result)


def growth_along_certificate(
    scene: Scene, certificate: Certificate
) -> CertifiedGrowth | FlightGrowth:
    """Return the error growth along the certified part of a shot; it must store its motion."""
    if is_differentiated(scene):
        return growth_of_certificate(scene, certificate)
    return FlightGrowth(scene, certificate)


def horizon(growth: Growth, tolerance: float, error: float) -> float:
    """Return the time until which errors stay within a tolerance [s].

    Infinite if errors stay small to the end, or as long as the growth is known.

    `tolerance` [m].
    `error`: relative size of the error at the start and at each event.
    """
    looks = _looks(growth)
    ends = _first_beyond(growth, looks[looks < growth.derivative_ends], tolerance / error)
    return math.floor(ends / GRID) * GRID if math.isfinite(ends) else math.inf


def _first_beyond(growth: Growth, looks: FloatArray, limit: float) -> float:
    """Return the time at which a growth first exceeds a limit [s]; inf: never."""
    for start in range(0, len(looks), _CHUNK):
        some = looks[start : start + _CHUNK]
        beyond = np.flatnonzero(~(np.max(growth.sizes(some), axis=1) <= limit))
        if len(beyond):
            first = start + int(beyond[0])
            break
    else:
        return math.inf
    low, high = float(looks[max(first - 1, 0)]), float(looks[first])
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if float(np.max(growth.sizes([middle]))) <= limit:
            low = middle
        else:
            high = middle
    return high


def _looks(growth: Growth) -> FloatArray:
    """Return the times of the events and some times between them."""
    times = growth.times
    marks = np.append(times, growth.t_end) if times[-1] < growth.t_end else times
    parts = np.arange(_INTERVALS) / _INTERVALS
    inner = marks[:-1, np.newaxis] + np.diff(marks)[:, np.newaxis] * parts
    looks: FloatArray = np.append(inner.ravel(), marks[-1])
    return looks


class RunGrowth:
    """The growth of errors along a run of Ghostball's engine, from its own tangent map."""

    def __init__(self, result: Result) -> None:
        self.result = result
        self.times: FloatArray = np.unique(np.append(0.0, events_of(result)["t"]))
        self.t_end = result.rest_time

    def sizes(self, times: ArrayLike) -> FloatArray:
        """Return the displacement by a relative error of 1 at the start and each event.

        inf if balls had compliant impacts, because these have no tangent map.
        """
        if self.result.work.get("compliant_impacts", 0) > 0:
            return np.full((np.size(times), len(self.result.scene.balls)), np.inf)
        return self.result.sensitivity(times)

    @cached_property
    def derivative_ends(self) -> float:
        """Time from which the displacement of a ball is unknown [s]; inf: never."""
        return _first_beyond(self, _looks(self), np.finfo(np.float64).max)


@dataclass(frozen=True, eq=False)
class SampledGrowth:
    """The growth of errors along a shot at some times, and the meetings that errors may change.

    `times` (k,) float64 [s]: increasing.
    `largest` (k,) float64 [m]: largest displacement of a ball so far by relative errors of 1 at the
        start and at each event, at least the extent of the scene; inf if it is unknown.
    `events` (k,) int: number of instants so far at which errors are made; the first is the start.
    `extent` [m]: of the scene.
    `coordinate` [m]: rms coordinate of the balls at their events. A relative error displaces each
        coordinate in proportion to itself, so this is the typical displacement at an event by a
        relative error of 1. It is no bound: an event near the origin has a smaller one.
    `known_until` [s]: time from which the growth is unknown; inf: never.
    `meetings`: of the shot.
    `least_error`: relative error at each event that any engine may have: that of all steps of
        contacts, or of an impact law that is integrated; else 0.
    """

    times: FloatArray
    largest: FloatArray
    events: NDArray[np.intp]
    extent: float
    coordinate: float
    known_until: float
    meetings: Meetings
    least_error: float

    def horizon(self, error: float) -> float:
        """Return the time up to which relative errors of this size can't change the shot [s]."""
        error = max(error, self.least_error)
        return min(self.known_until, self.meetings.horizon(error * self.extent))


def sampled_growth(growth: Growth, result: Result) -> SampledGrowth:
    """Return the growth of errors at no more than `_MOST_TIMES` times of a run of the shot."""
    times, extent = _looks(growth), extent_of(result.scene)
    if len(times) > _MOST_TIMES:
        times = times[np.linspace(0, len(times) - 1, _MOST_TIMES).astype(np.intp)]
    chunks = range(0, len(times), _CHUNK)
    sizes = np.concatenate([np.max(growth.sizes(times[k : k + _CHUNK]), axis=1) for k in chunks])
    sizes = np.maximum(np.where(np.isnan(sizes), np.inf, sizes), extent)
    largest = np.maximum.accumulate(sizes)
    unknown = np.flatnonzero(np.isinf(largest))
    known_until = math.inf
    if len(unknown):  # the growth may become unknown right after the last time at which it is known
        known_until = math.nextafter(float(times[max(unknown[0] - 1, 0)]), math.inf)
    least = max(
        contact_error(result.work.get("contact_steps", 0)),
        INTEGRATED_IMPACT if _has_integrated_law(result.scene) else 0.0,
    )
    events = np.searchsorted(growth.times, times, side="right")
    known_until = min(known_until, _first_tie(result), first_balance(result))
    log = events_of(result)[:_MOST_TIMES]
    places = result.sample(log["t"]).positions[np.arange(len(log)), log["a"], :2]
    coordinate = math.sqrt(float(np.mean(places**2))) if len(log) else extent
    return SampledGrowth(
        times,
        largest,
        events,
        extent,
        min(coordinate, extent) or extent,
        known_until,
        meetings_of(growth, result),
        least,
    )


def _first_tie(result: Result) -> float:
    """Return the time from which rounding decides the order of two collisions of a ball [s].

    For example, a ball is pushed into a corner whose two cushions it almost touches. inf: never.
    """
    last: dict[int, tuple[float, int]] = {}
    for one in events_in(events_of(result)):
        for ball in one.balls:
            partner = one.b if ball == one.a else one.a
            t, before = last.get(ball, (-math.inf, -1))
            if partner != before and one.t - t <= TIE * one.t:
                return t
            last[ball] = one.t, partner
    return math.inf


def hits_corner(result: Result) -> bool:
    """Return whether a ball hits two cushions at one instant: the order then changes roundings."""
    log = events_of(result)
    log = np.sort(log[log["kind"] == EventKind.BALL_CUSHION], order=("a", "t"))
    two = (log["a"][1:] == log["a"][:-1]) & (log["b"][1:] != log["b"][:-1])
    return bool(np.any(two & (np.diff(log["t"]) <= TIE * log["t"][1:])))


def first_balance(result: Result) -> float:
    """Return the time of the first collision of a ball with a ball exactly below it [s]; inf: none.

    The direction in which the ball falls then depends on less than the roundness of a real ball.
    """
    log = events_of(result)
    log = log[(log["kind"] == EventKind.BALL_BALL) & result.scene.physics.airborne]
    for start in range(0, len(log), _CHUNK):
        some = log[start : start + _CHUNK]
        places, k = result.sample(some["t"]).positions, np.arange(len(some))
        x, y, z = (places[k, some["a"]] - places[k, some["b"]]).T
        balanced = np.flatnonzero(np.hypot(x, y) <= BALANCED_SLOPE * np.abs(z))
        if len(balanced):
            return float(some["t"][balanced[0]])
    return math.inf


def _has_integrated_law(scene: Scene) -> bool:
    physics = scene.physics
    chosen = ((BALL_LAWS, physics.ball_impact), (CUSHION_LAWS, physics.cushion))
    return any(law.integrated for laws, name in chosen for law in laws if law.name == name)


@dataclass(frozen=True, eq=False)
class Meetings:
    """The size of errors when a ball is about to meet a body that scatters it; see `meetings_of`.

    Errors at a meeting may change what happens next; later events then don't depend on the accuracy
    of the engine. Other balls, posts, jaws and corners that point into the table scatter a ball; so
    does the nose of a cushion if balls may fly. The edge of a pocket decides whether the ball
    falls.

    `times` (k,) float64 [s]: of the meetings, increasing.
    `largest` (k,) float64 [m]: displacement of the meeting balls by a relative error of 1 at the
        start and at each event (`Growth`); inf if it is unknown. The effect of a displacement
        depends on the distance of a ball's centre from the point about which its path turns. The
        displacement is therefore scaled to this distance for two of the smallest balls, 2 `radius`.
    `extent` [m]: of the scene; relative errors are relative to it.
    `radius` [m]: of the smallest ball.
    """

    times: FloatArray
    largest: FloatArray
    extent: float
    radius: float

    def horizon(self, resolution: float) -> float:
        """Return the first meeting with an outcome that errors may have changed [s]; inf: none.

        At this meeting errors have grown to a ball's radius, so they turn the outcome by 30
        degrees.

        `resolution` [m]: position error that the engine states for balls at a collision. Rounding
            is added.
        """
        error = max(ROUNDINGS * UNIT_ROUNDOFF, resolution / self.extent)
        beyond = np.flatnonzero(~(self.largest <= self.radius / error))
        return float(self.times[beyond[0]]) if len(beyond) else math.inf


def meetings_of(growth: Growth, result: Result) -> Meetings:
    """Return the size of errors when balls are about to meet in a run of the shot."""
    scene, radius = result.scene, float(np.min(result.scene.radii))
    log = events_of(result)
    events = log[np.isin(log["kind"], _MEETINGS) & ~_of_straight_sides(scene, log)]
    reaches = _reaches_of(scene, result, events)
    events, reaches = events[reaches < math.inf], reaches[reaches < math.inf]
    times, instant = np.unique(events["t"], return_inverse=True)
    largest = np.zeros(len(times))
    if len(times):
        # Bounds in flight include the event at that time; a derivative is taken just before the
        # event.
        flies = isinstance(growth, FlightGrowth)
        sizes = growth.sizes(times if flies else np.nextafter(times, 0.0))
        for k, one, reach in zip(instant.tolist(), events, reaches.tolist(), strict=True):
            balls = [one["a"], one["b"]] if one["kind"] == EventKind.BALL_BALL else [one["a"]]
            largest[k] = max(largest[k], float(np.max(sizes[k, balls])) * 2.0 * radius / reach)
    return Meetings(times, largest, extent_of(scene), radius)


_MEETINGS = (EventKind.BALL_BALL, EventKind.BALL_CUSHION, EventKind.POCKETED)


def _of_straight_sides(scene: Scene, log: Events) -> NDArray[np.bool_]:
    """Return which events are contacts with straight sides of balls that never fly, (k,)."""
    if scene.table is None or scene.physics.airborne:
        return np.zeros(len(log), dtype=np.bool_)
    sides = [side.cushion for side in scene.table.sides]
    of_cushions = log["kind"] == EventKind.BALL_CUSHION
    found: NDArray[np.bool_] = of_cushions & np.isin(log["b"], sides)
    return found


def _reaches_of(scene: Scene, result: Result, events: Events) -> FloatArray:
    """Return twice the error that changes the outcome of each meeting, (k,) [m]."""
    reaches: FloatArray = scene.radii[events["a"]].copy()
    of_balls = events["kind"] == EventKind.BALL_BALL
    reaches[of_balls] += scene.radii[events["b"][of_balls]]
    others = np.flatnonzero(~of_balls)
    for start in range(0, len(others), _CHUNK):
        rows = others[start : start + _CHUNK]
        before = result.sample(np.nextafter(events["t"][rows], 0.0))
        for k, row in enumerate(rows):
            a = int(events["a"][row])
            reaches[row] = _reach_of(
                scene, events[row], before.positions[k, a], before.velocities[k, a]
            )
    return reaches


def _reach_of(scene: Scene, event: np.void, position: FloatArray, velocity: FloatArray) -> float:
    """Return twice the error that changes the outcome of a ball's meeting with an obstacle [m].

    For a round obstacle, it is the distance of the ball's centre from the point that its path turns
    about; for a hole, twice the displacement that would make the ball pass it; for a straight side,
    inf.

    `position` [m], `velocity` [m/s]: of the ball just before it, (3,).
    """
    kind, a, b = int(event["kind"]), int(event["a"]), int(event["b"])
    assert scene.table is not None
    (x, y, z), (vx, vy, _) = position.tolist(), velocity.tolist()
    if kind == EventKind.POCKETED:
        (hole,) = (one for one in scene.table.holes if one.pocket == b)
        dx, dy = x - hole.centre[0], y - hole.centre[1]
        return float(2.0 * (hole.radius - abs(dx * vy - dy * vx) / math.hypot(vx, vy)))
    centre = scene.table.turns_about(b, x, y)
    if centre is not None:
        return math.dist(centre, (x, y))
    radius = float(scene.radii[a])
    # For a ball in the air, the nose of a cushion acts like a horizontal post.
    return radius if z > (1.0 + _LIFTED_HEIGHT) * radius else math.inf


_LIFTED_HEIGHT = 2.0**-20
"""Height of a ball above the cloth, in its radii, above which it counts as lifted."""


def extent_of(scene: Scene) -> float:
    """Return the largest coordinate of a scene, of its table or of a ball [m]."""
    extent = float(np.max(np.abs(scene.positions[:, :2])) + np.max(scene.radii))
    return extent if scene.table is None else max(extent, scene.table.length, scene.table.width)
