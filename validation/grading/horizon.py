"""Until when errors leave a shot predictable: its horizon, by how they grow along its motion.

    >>> horizon(growth_along(scene, proof, result), TOLERANCE, ROUNDINGS * UNIT_ROUNDOFF)

Errors grow along the proved motion where there is one, so that no engine says itself how far it is
judged: by its tangent map (`certified_growth`), in flight by the widths of its enclosures
(`certified_widths`); else as our engine says of its own run. An engine makes errors of its own
size: an exact one those of rounding, one that steps those of a contact seen up to a step late. How
near the shot comes to another path is no part of it: who takes that one before its errors have
grown plays another shot.
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
from ghostball.reference_adapters.certified import Certificate
from ghostball.validation.grading.certified_growth import CertifiedGrowth, growth_of_proof
from ghostball.validation.grading.certified_widths import FlightGrowth, is_differentiated
from ghostball.validation.grading.tolerances import ROUNDINGS, UNIT_ROUNDOFF
from ghostball.validation.runs.sampling import events_of

_BETWEEN = 4
"""Parts that the time between two events is cut into where growth is looked for."""

_AT_ONCE = 256
"""Instants that are looked at together: of hundreds of balls more don't fit into memory."""

_HALVINGS = 40
"""Of the time in which a growth passes a limit, between two looks."""

GRID = 2.0**-20
"""Horizons are whole multiples of it [s]: how a matrix product rounds doesn't decide which."""


class Growth(Protocol):
    """How errors grow along a shot."""

    @property
    def times(self) -> FloatArray:
        """When its events are, increasing, from 0 on: (k,) [s]."""

    @property
    def t_end(self) -> float:
        """When it ends [s]."""

    @property
    def derivative_ends(self) -> float:
        """From when on nothing is known, as after two collisions at one instant [s]; inf: never."""

    def sizes(self, times: ArrayLike) -> FloatArray:
        """Return what a relative error of 1 at the start and at each event has become of each ball.

        At some instants, (k, n) [m]; infinite where nothing is known.
        """


def growth_along(scene: Scene, proof: Certificate | None, result: Result) -> Growth:
    """Return how errors grow along a shot: as proved where all of it is, else as a run says.

    `proof`: with its motion.
    `result`: our engine's run of it, recorded with its trajectory.
    """
    if proof is not None and proof.proved:
        return growth_along_proof(scene, proof)
    return RunGrowth(result)


def growth_along_proof(scene: Scene, proof: Certificate) -> CertifiedGrowth | FlightGrowth:
    """Return how errors grow along what is proved of a shot, with its motion."""
    if is_differentiated(scene):
        return growth_of_proof(scene, proof)
    return FlightGrowth(scene, proof)


def horizon(growth: Growth, tolerance: float, error: float) -> float:
    """Return until when errors stay within a tolerance [s].

    Infinite where they do to the end, or as long as anything is known of them.

    `tolerance` [m].
    `error`: relative size of the error that is made at the start and at each event.
    """
    looks = _looks(growth)
    ends = _first_beyond(growth, looks[looks < growth.derivative_ends], tolerance / error)
    return math.floor(ends / GRID) * GRID if math.isfinite(ends) else math.inf


def _first_beyond(growth: Growth, looks: FloatArray, limit: float) -> float:
    """Return when a growth first isn't within a limit [s]: at one of some instants, or between."""
    for start in range(0, len(looks), _AT_ONCE):
        some = looks[start : start + _AT_ONCE]
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
    """Return the instants of the events and some between them."""
    times = growth.times
    marks = np.append(times, growth.t_end) if times[-1] < growth.t_end else times
    parts = np.arange(_BETWEEN) / _BETWEEN
    inner = marks[:-1, np.newaxis] + np.diff(marks)[:, np.newaxis] * parts
    looks: FloatArray = np.append(inner.ravel(), marks[-1])
    return looks


class RunGrowth:
    """How errors grow along a run of our engine, as that says itself."""

    def __init__(self, result: Result) -> None:
        self.result = result
        self.times: FloatArray = np.unique(np.append(0.0, events_of(result)["t"]))
        self.t_end = result.rest_time

    def sizes(self, times: ArrayLike) -> FloatArray:
        """Return what a relative error of 1 at the start and at each event has become; `Growth`."""
        return self.result.sensitivity(times)

    @cached_property
    def derivative_ends(self) -> float:
        """From when on nothing is known of a ball [s]; inf where all is to the end."""
        return _first_beyond(self, _looks(self), np.finfo(np.float64).max)


@dataclass(frozen=True, eq=False)
class Meetings:
    """How errors have grown when a ball is about to meet what scatters it; made by `meetings_of`.

    There they may lead the shot onto another path, and what comes after says nothing of the engine.
    Other balls, posts, jaws and corners that point into the table scatter a ball; so does the nose
    of a cushion if balls may fly. The edge of a pocket decides whether it falls.

    `times` (k,) float64 [s]: of the meetings, increasing.
    `largest` (k,) float64 [m]: what a relative error of 1 at the start and at each event has become
        of the balls that meet (`Growth`), as of two of the smallest balls: an error counts by how
        far the centre is from what it turns about, 2 `radius` there. inf where nothing is known.
    `extent` [m]: of the scene: what a relative error is relative to.
    `radius` [m]: of the smallest ball.
    """

    times: FloatArray
    largest: FloatArray
    extent: float
    radius: float

    def horizon(self, resolution: float) -> float:
        """Return the first meeting whose outcome errors may have changed [s]; inf: none.

        Where they have grown to a ball's radius: then they turn what the ball does by 30 degrees.

        `resolution` [m]: of the engine: how far off a ball may be when it collides. Rounding comes
        on top.
        """
        error = max(ROUNDINGS * UNIT_ROUNDOFF, resolution / self.extent)
        beyond = np.flatnonzero(~(self.largest <= self.radius / error))
        return float(self.times[beyond[0]]) if len(beyond) else math.inf


def meetings_of(growth: Growth, result: Result) -> Meetings:
    """Return how errors have grown when balls are about to meet in a run of the shot."""
    scene, radius = result.scene, float(np.min(result.scene.radii))
    log = events_of(result)
    events = log[np.isin(log["kind"], _MEETINGS) & ~_of_straight_sides(scene, log)]
    reaches = _reaches_of(scene, result, events)
    events, reaches = events[reaches < math.inf], reaches[reaches < math.inf]
    times, instant = np.unique(events["t"], return_inverse=True)
    largest = np.zeros(len(times))
    if len(times):
        # Of a flight the instants themselves are uncertain; a derivative is known just before.
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
    """Return twice the error that changes what comes of each meeting, (k,) [m]."""
    reaches: FloatArray = scene.radii[events["a"]].copy()
    of_balls = events["kind"] == EventKind.BALL_BALL
    reaches[of_balls] += scene.radii[events["b"][of_balls]]
    others = np.flatnonzero(~of_balls)
    for start in range(0, len(others), _AT_ONCE):
        rows = others[start : start + _AT_ONCE]
        before = result.sample(np.nextafter(events["t"][rows], 0.0))
        for k, row in enumerate(rows):
            a = int(events["a"][row])
            reaches[row] = _reach_of(
                scene, events[row], before.positions[k, a], before.velocities[k, a]
            )
    return reaches


def _reach_of(scene: Scene, event: np.void, position: FloatArray, velocity: FloatArray) -> float:
    """Return twice the error that changes what comes of a ball's meeting with an obstacle [m].

    Of what is round, how far a ball's centre is from what its path turns about; of a hole, twice by
    how much the ball would have to be off to pass it; infinite of what is straight.

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
    # A ball in the air meets the nose of a cushion as it meets a post that lies.
    return radius if z > (1.0 + _LIFTED) * radius else math.inf


_LIFTED = 2.0**-20
"""Height of a ball above the cloth, in its radii, that is more than rounding."""


def extent_of(scene: Scene) -> float:
    """Return the largest coordinate of a scene, of its table or of a ball [m]."""
    extent = float(np.max(np.abs(scene.positions[:, :2])) + np.max(scene.radii))
    return extent if scene.table is None else max(extent, scene.table.length, scene.table.width)
