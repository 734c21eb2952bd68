"""How little would change the course of a shot: other balls would meet, or in another order.

    >>> nearest = nearest_of(bifurcations_of(simulate(scene, record="trajectory")))[0]
    >>> nearest.relative         # relative change of the first state
    >>> nearest.describe(scene)  # 'ball "3" catches ball "5" by 0.12 mm at t = 1.234 s'

Each is a margin, in metres, over what a relative change of the first state of size 1 makes of it,
by the tangent map of the shot itself. To first order, so that it is the surer the smaller it is.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import CUSHIONS, EventKind, Result, Scene
from ghostball.engine.sensitivity import LANES, PARTS
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.truth.passings import (
    Cushion,
    ball_passings,
    cushion_passings,
    cushions_of,
)

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

BifurcationKind = Literal["tie", "graze", "near miss", "order"]
"""Two collisions of a ball at one instant; a hit that all but misses; a miss that all but hits; a
collision that comes all but first."""

_LOCAL = 0.1
"""Of the sum of two radii: how near a competitor must be for its rate to tell when it touches."""

_SEED = 59
"""Of the directions in which the first state is changed: the same for every shot."""

_MOST_NUMBERS = 4_000_000
"""Of perturbations that are held at once: 32 MB."""


@dataclass(frozen=True)
class Bifurcation:
    """Where a shot might have taken another course.

    Attributes
    ----------
    kind : "tie", "graze", "near miss" or "order"
    t : float [s]
    a, b : int
        The balls; b is -1 minus the index of a cushion, where it is one.
    margin : float [m]
        By how much a hit overlaps sideways, a miss is apart, or the ball that would have been first
        still has to go when the other collision comes; 0 for a tie.
    relative : float
        The relative change of the first state that uses up the margin, see `bifurcations_of`.
    """

    kind: BifurcationKind
    t: float
    a: int
    b: int
    margin: float
    relative: float

    def describe(self, scene: Scene) -> str:
        """Return the bifurcation in words."""
        first = f'ball "{scene.balls[self.a].id}"'
        second = (
            f'ball "{scene.balls[self.b].id}"'
            if self.b >= 0
            else f"cushion {CUSHIONS[-1 - self.b]}"
        )
        size, at = f"{1e3 * self.margin:.3g} mm", f"t = {self.t:.6g} s"
        if self.kind == "tie":
            return f"{first} has several collisions at {at}, one with {second}"
        if self.kind == "graze":
            return f"{first} catches {second} by {size} at {at}"
        if self.kind == "near miss":
            return f"{first} passes {second} {size} away at {at}"
        return f"{first} is {size} from {second} when another collision comes at {at}"


class Changes(Protocol):
    """What becomes of m small changes of a shot's first state."""

    @property
    def event_shifts(self) -> FloatArray:
        """How much later each event comes [s], (events, m)."""
        ...

    def sample(self, times: FloatArray) -> FloatArray:
        """Return the changes at `times`, (k, m, n, 2 or more), places first [m]."""
        ...


def bifurcations_of(result: Result, tangent: Changes | None = None) -> tuple[Bifurcation, ...]:
    """Return all bifurcations that a shot passes, in order of time.

    Parameters
    ----------
    result : Result
        Recorded with `record="trajectory"` by an engine of exact motion.
    tangent : Changes, optional
        What becomes of `directions_of` its scene; left out, by its own tangent map.

    Raises
    ------
    GhostballError
        Where it isn't.

    Notes
    -----
    The first state is changed in random directions: every ball's position by the extent of the
    scene, and the velocity and spin of every ball that moves, whatever their direction, by its
    speed; `relative` is in these units, and the root mean square over the directions. Unlike
    rounding in our engine, such changes respect no symmetry.

    Between two events of two balls the least of their gaps counts where they part again, or one
    stops; so does the gap of a ball that turns back, or stops, short of a cushion. Which of two
    cushions a ball meets first isn't counted: it ends in the same place.

    Left out is what lies where no derivative exists, past ties and sustained contact; the first tie
    itself counts as one with margin 0.
    """
    if tangent is None:
        tangent = result.tangent(directions_of(result.scene))
    found = [*_ties(result), *_grazes(result, tangent), *_orders(result, tangent)]
    return tuple(sorted([*found, *_near_misses(result, tangent)], key=lambda one: one.t))


def nearest_of(bifurcations: Iterable[Bifurcation]) -> tuple[Bifurcation, ...]:
    """Return the nearest bifurcation of each kind, the nearest first."""
    nearest: dict[BifurcationKind, Bifurcation] = {}
    for one in bifurcations:
        if one.kind not in nearest or one.relative < nearest[one.kind].relative:
            nearest[one.kind] = one
    return tuple(sorted(nearest.values(), key=lambda one: one.relative))


def extent_of(scene: Scene) -> float:
    """Return the largest coordinate of a scene, of its table or of a ball [m]."""
    extent = float(np.max(np.abs(scene.positions[:, :2])) + np.max(scene.radii))
    return extent if scene.table is None else max(extent, scene.table.length, scene.table.width)


def directions_of(scene: Scene) -> FloatArray:
    """Return changes of the first state, (LANES, n, 7), of relative size 1."""
    signs = (
        np.random.default_rng(_SEED).integers(0, 2, (LANES, len(scene.balls), PARTS)) * 2.0 - 1.0
    )
    sizes = np.empty((len(scene.balls), PARTS))
    sizes[:, :2] = extent_of(scene)
    sizes[:, 2:4] = np.linalg.norm(scene.velocities, axis=1)[:, np.newaxis]
    sizes[:, 4:] = np.linalg.norm(scene.angular_velocities, axis=1)[:, np.newaxis]
    changes: FloatArray = signs * sizes
    return changes


def _ties(result: Result) -> Iterator[Bifurcation]:
    """Yield the first instant at which a ball has two collisions."""
    at: dict[int, float] = {}
    for t, kind, a, b in events_of(result).tolist():
        if kind not in (EventKind.BALL_BALL, EventKind.BALL_CUSHION):
            continue
        balls = (a, b) if kind == EventKind.BALL_BALL else (a,)
        other = b if kind == EventKind.BALL_BALL else -1 - b
        if any(at.get(ball) == t for ball in balls):
            yield Bifurcation("tie", t, a, other, 0.0, 0.0)
            return
        at |= dict.fromkeys(balls, t)


def _grazes(result: Result, tangent: Changes) -> Iterator[Bifurcation]:
    """Yield for each hit of two balls by how much they might miss, sideways."""
    events = events_of(result)
    hits = np.flatnonzero(events["kind"] == EventKind.BALL_BALL)
    radii = result.scene.radii
    for rows in _chunks(hits, len(radii)):
        t, a, b = (events[name][rows] for name in ("t", "a", "b"))
        before = np.nextafter(t, 0.0)
        state = result.sample(before)
        at = np.arange(len(rows))
        r = (state.positions[at, b] - state.positions[at, a])[:, :2]
        v = (state.velocities[at, a] - state.velocities[at, b])[:, :2]
        speed = np.linalg.norm(v, axis=1)
        with np.errstate(invalid="ignore"):  # of a tie, which is noted as such
            across = np.stack([-v[:, 1], v[:, 0]], axis=1) / speed[:, np.newaxis]
        margin = radii[a] + radii[b] - np.abs(np.sum(across * r, axis=1))
        change = _changes(tangent, before, a, b)
        spread = _spread(np.einsum("kx,kmx->km", across, change))
        yield from _bifurcations("graze", t, a, b, np.maximum(margin, 0.0), spread)


def _orders(result: Result, tangent: Changes) -> Iterator[Bifurcation]:
    """Yield for each collision of a ball how near another of the same ball was."""
    events, scene = events_of(result), result.scene
    collisions = np.flatnonzero(events["kind"] <= EventKind.BALL_CUSHION)
    n = len(scene.balls)
    for rows in _chunks(collisions, n):
        t, kind = events["t"][rows], events["kind"][rows]
        state = result.sample(np.nextafter(t, 0.0))
        places, speeds = state.positions, state.velocities
        for name in ("a", "b"):
            chosen = rows if name == "a" else rows[kind == EventKind.BALL_BALL]
            at = np.flatnonzero(np.isin(rows, chosen))
            if not len(at):
                continue
            mover = events[name][rows[at]].astype(np.int64)
            taken = np.where(
                kind[at] == EventKind.BALL_BALL, events["b" if name == "a" else "a"][rows[at]], -1
            )
            for other in range(n):
                free = np.flatnonzero((mover != other) & (taken != other))
                to = _to_ball(scene, mover[free], other, places[at[free]], speeds[at[free]])
                yield from _competing(result, tangent, rows[at[free]], mover[free], other, to)
            hits = np.flatnonzero(kind[at] == EventKind.BALL_BALL)
            for cushion in cushions_of(scene):
                to = _to_cushion(scene, mover[hits], cushion, places[at[hits]], speeds[at[hits]])
                other = -1 - cushion.number
                yield from _competing(result, tangent, rows[at[hits]], mover[hits], other, to)


class _Way(NamedTuple):
    """How far some balls are from something else, (k,) each, and which way, (k, 2)."""

    normal: FloatArray
    gap: FloatArray
    approach: FloatArray


def _to_ball(
    scene: Scene, mover: IntArray, other: int, positions: FloatArray, velocities: FloatArray
) -> _Way:
    k = np.arange(len(mover))
    r = (positions[:, other] - positions[k, mover])[:, :2]
    distance = np.linalg.norm(r, axis=1)
    normal = r / distance[:, np.newaxis]
    approach = np.sum(normal * (velocities[k, mover] - velocities[:, other])[:, :2], axis=1)
    return _Way(normal, distance - (scene.radii[mover] + scene.radii[other]), approach)


def _to_cushion(
    scene: Scene, mover: IntArray, cushion: Cushion, positions: FloatArray, velocities: FloatArray
) -> _Way:
    k = np.arange(len(mover))
    height = positions[k, mover, :2] @ cushion.inward - cushion.offset
    approach = -(velocities[k, mover, :2] @ cushion.inward)
    return _Way(np.tile(-cushion.inward, (len(mover), 1)), height - scene.radii[mover], approach)


def _competing(
    result: Result, tangent: Changes, rows: IntArray, mover: IntArray, other: int, to: _Way
) -> Iterator[Bifurcation]:
    """Yield how near `other` was to being met by each mover, when its event of `rows` came."""
    gap = np.maximum(to.gap, 0.0)
    near = _LOCAL * (result.scene.radii[mover] + (result.scene.radii[other] if other >= 0 else 0.0))
    close = np.flatnonzero((to.approach > 0.0) & (gap < near))
    if not len(close):
        return
    t = events_of(result)["t"][rows[close]]
    b = np.full(len(close), other)
    change = _changes(tangent, np.nextafter(t, 0.0), mover[close], b if other >= 0 else None)
    if other < 0:  # what a cushion is relative to the ball
        change = -change
    approach = to.approach[close, np.newaxis]
    later = np.einsum("kx,kmx->km", to.normal[close], change) / approach
    relative = approach * (later - tangent.event_shifts[rows[close]])
    yield from _bifurcations("order", t, mover[close], b, gap[close], _spread(relative))


def _near_misses(result: Result, tangent: Changes) -> Iterator[Bifurcation]:
    """Yield how closely two balls pass without touching, and how near a ball turns to a cushion."""
    times, a, b, gaps = ball_passings(result)
    for rows in _chunks(np.argsort(times, kind="stable"), len(result.scene.balls)):
        at = np.arange(len(rows))
        places = result.sample(times[rows]).positions[..., :2]
        r = places[at, b[rows]] - places[at, a[rows]]
        normal = r / np.linalg.norm(r, axis=1)[:, np.newaxis]
        change = _changes(tangent, times[rows], a[rows], b[rows])
        spread = _spread(np.einsum("kx,kmx->km", normal, change))
        yield from _bifurcations("near miss", times[rows], a[rows], b[rows], gaps[rows], spread)
    inward = {one.number: one.inward for one in cushions_of(result.scene)}
    times, a, cushions, gaps = cushion_passings(result)
    for rows in _chunks(np.argsort(times, kind="stable"), len(result.scene.balls)):
        change = _changes(tangent, times[rows], a[rows])
        normal = np.array([inward[k] for k in cushions[rows].tolist()])
        spread = _spread(np.einsum("kx,kmx->km", normal, change))
        b = -1 - cushions[rows]
        yield from _bifurcations("near miss", times[rows], a[rows], b, gaps[rows], spread)


def _changes(
    tangent: Changes, times: FloatArray, a: IntArray, b: IntArray | None = None
) -> FloatArray:
    """Return the perturbations of the position of a, or of b relative to a, (k, m, 2) [m]."""
    places = tangent.sample(times)[..., :2]
    at = np.arange(len(times))
    with np.errstate(invalid="ignore"):  # infinite where there is no derivative, and so no margin
        change: FloatArray = places[at, :, a] if b is None else places[at, :, b] - places[at, :, a]
    return change


def _spread(values: FloatArray) -> FloatArray:
    """Return the root mean square over perturbations, (k,)."""
    with np.errstate(over="ignore", invalid="ignore"):
        spread: FloatArray = np.sqrt(np.mean(values**2, axis=-1))
    return spread


def _bifurcations(
    kind: BifurcationKind,
    t: FloatArray,
    a: IntArray,
    b: IntArray,
    margin: FloatArray,
    spread: FloatArray,
) -> Iterator[Bifurcation]:
    for one in zip(t, a, b, margin, spread, strict=True):
        size, change = float(one[3]), float(one[4])
        # A margin that nothing changes is none to speak of; no derivative, no margin.
        if np.isfinite(change) and change > 0.0:
            yield Bifurcation(kind, float(one[0]), int(one[1]), int(one[2]), size, size / change)


def _chunks(rows: IntArray, n: int) -> Iterator[IntArray]:
    size = max(_MOST_NUMBERS // (56 * n), 1)
    for start in range(0, len(rows), size):
        yield rows[start : start + size]
