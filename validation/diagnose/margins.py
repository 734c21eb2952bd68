"""How narrowly a collision happens or is missed: overlaps, gaps and approach speeds in a run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ghostball.model import Ball, EventKind, Result, SampledTrajectory, Samples, Scene
from ghostball.model.arrays import FloatArray
from ghostball.validation.grading.event_logs import Agreement, Event, Parting, events_in
from ghostball.validation.runs.engine_runs import run_ours
from ghostball.validation.runs.sampling import events_of

Centres = Callable[[FloatArray], FloatArray]
"""Times (k,) [s] -> centres (k, balls, 2) [m]."""

SAMPLE_COUNT = 2_001
"""Number of times at which a gap is sampled; sampling is repeated twice around the smallest gap."""


Side = Literal["truth", "engine"]
What = Literal["miss", "collision", "order"]


@dataclass(frozen=True)
class Margin:
    """The smallest change of a shot that would change its collisions.

    `run`: the run in which it was measured.
    `what`: "miss": the collision would be missed if its overlap were smaller by `length`.
        "collision": the collision would happen if the smallest gap were smaller by `length`.
        "order": the collision would be second, as in the other run, if it came later; `length` is
        `seconds` multiplied by the approach speed.
    `event`: the collision in this run, or in the other run if it doesn't happen here.
    `length` [m].
    `ulps` [1]: the length divided by the spacing of doubles at these coordinates.
    `seconds` [s]: for "order", the time between the two collisions.
    """

    run: Side
    what: What
    event: Event
    length: float
    ulps: float
    seconds: float | None = None


def state_before(result: Result, t: float) -> tuple[float, Samples]:
    """Return the time of the last known state before `t` [s], and that state; arrays (1, n, 3).

    For an exact motion, it is just before `t`. For frames, it is the last frame before `t`, because
    interpolation to the next frame would mix the velocities before and after a collision.
    """
    frames = result.trajectory
    if isinstance(frames, SampledTrajectory):
        row = max(int(np.searchsorted(frames.times, t, side="left")) - 1, 0)
        states = (frames.positions, frames.velocities, frames.angular_velocities)
        return float(frames.times[row]), Samples(*(one[row : row + 1] for one in states))
    before = max(float(np.nextafter(t, 0.0)), 0.0)
    return before, result.sample([before])


def ball_at(scene: Scene, states: Samples, ball: int, axes: int = 3) -> Ball:
    """Return a ball of a scene in the first of the sampled states.

    `axes`: 2 if only the plane counts: the ball then lies on the cloth, and moves along it.
    """
    state = {
        "position": tuple(states.positions[0, ball, :axes].tolist()),
        "velocity": tuple(states.velocities[0, ball, :axes].tolist()),
        "angular_velocity": None
        if scene.physics.motion == "rolling"
        else tuple(states.angular_velocities[0, ball].tolist()),
    }
    return Ball(**(dict(scene.balls[ball].without_strike()) | state))


def overlap_of(result: Result, collision: Event) -> float | None:
    """Return the overlap of a collision of a run [m]: the change that would make it a miss.

    It is the largest overlap of the two balls, or of the ball and the cushion, if the balls
    continued undisturbed until the cloth stops them. None if the last known state doesn't lead to
    the collision, because the engine had several collisions in one time step.
    """
    _, state = state_before(result, collision.t)
    coasts = [_coast(result.scene, state, ball) for ball in collision.balls]
    end = max(coast.rest_time for coast in coasts)
    if end == 0.0:
        return None

    def centres(times: FloatArray) -> FloatArray:
        return np.concatenate([coast.sample(times).positions[:, :, :2] for coast in coasts], axis=1)

    overlap = -_smallest(result.scene, collision, centres, 0.0, end)[0]
    return overlap if overlap > 0.0 else None


def nearest_approach(
    result: Result, collision: Event, start: float, end: float
) -> tuple[float, float]:
    """Return the smallest gap between the bodies of a collision [m], and its time [s]."""

    def centres(times: FloatArray) -> FloatArray:
        chosen: FloatArray = result.sample(times).positions[:, list(collision.balls), :2]
        return chosen

    return _smallest(result.scene, collision, centres, start, max(end, start))


def approach_speed(result: Result, collision: Event) -> float:
    """Return the approach speed just before a collision [m/s]."""
    _, state = state_before(result, collision.t)
    positions, velocities = state.positions[0, :, :2], state.velocities[0, :, :2]
    a, b = collision.a, collision.b
    if collision.kind is EventKind.BALL_CUSHION:
        assert result.scene.table is not None
        inward, _ = result.scene.table.facing(b, *positions[a].tolist())
        return float(-(velocities[a] @ np.array(inward)))
    between = positions[b] - positions[a]
    normal = between / np.hypot(*between)
    return float((velocities[a] - velocities[b]) @ normal)


def gaps(scene: Scene, collision: Event, centres: FloatArray) -> FloatArray:
    """Return the gap between the bodies of a collision for centres (k, its balls, 2): (k,) [m]."""
    radii = scene.radii[list(collision.balls)]
    if collision.kind is EventKind.BALL_BALL:
        gap: FloatArray = np.hypot(*(centres[:, 1] - centres[:, 0]).T) - radii.sum()
        return gap
    assert scene.table is not None
    facing = scene.table.facing
    distances = [facing(collision.b, *place)[1] for place in centres[:, 0].tolist()]
    gap_to_cushion: FloatArray = np.array(distances) - radii[0]
    return gap_to_cushion


def _coast(scene: Scene, state: Samples, ball: int) -> Result:
    """Let one ball continue alone from a state, on an unbounded cloth."""
    # On a cloth without friction, the ball never stops: run until it is far beyond all others.
    speed = float(np.linalg.norm(state.velocities[0, ball, :2]))
    extent = float(np.max(np.abs(state.positions[0, :, :2])) + np.max(scene.radii))
    endless = scene.rolling_frictions[ball] == 0.0 or not scene.sliding_frictions[ball] > 0.0
    t_max = 4.0 * extent / speed if endless and speed > 0.0 else None
    t_max = 1.0 if endless and t_max is None else t_max
    free = Scene(
        name="coast", physics=scene.physics, balls=[ball_at(scene, state, ball, 2)], t_max=t_max
    )
    return run_ours(free)


def _smallest(
    scene: Scene, collision: Event, centres: Centres, start: float, end: float
) -> tuple[float, float]:
    """Return the smallest gap between two times [m], and its time [s]."""
    low, high = start, end
    gap, when = np.inf, start
    for _ in range(3):
        times = np.linspace(low, high, SAMPLE_COUNT)
        found = gaps(scene, collision, centres(times))
        row = int(np.argmin(found))
        gap, when = float(found[row]), float(times[row])
        low, high = float(times[max(row - 1, 0)]), float(times[min(row + 1, SAMPLE_COUNT - 1)])
    return gap, when


def in_ulps(length: float, positions: Sequence[FloatArray]) -> float:
    """Return a length over the spacing of doubles at the largest coordinate of `positions`."""
    largest = max(float(np.abs(one).max()) for one in positions)
    return length / float(np.spacing(largest))


def margins_of(
    truth: Result, result: Result, agreement: Agreement, parting: Parting
) -> tuple[Margin, ...]:
    """Return the margins of the two collisions that differ, in both runs; the smallest first."""
    pairs = agreement.before
    # The largest time difference of shared collisions: two collisions closer in time may be one.
    late = max((abs(a.t - b.t) for a, b in pairs), default=0.0)
    sides: tuple[tuple[Side, Result, list[Event], Event | None, Event | None], ...]
    sides = (
        ("truth", truth, [a for a, _ in pairs], parting.true, parting.other),
        ("engine", result, [b for _, b in pairs], parting.other, parting.true),
    )
    found = [
        margin
        for name, run, common, own, others in sides
        for margin in _margins_in(name, run, common, own, others, late)
    ]
    return tuple(sorted(found, key=lambda one: one.length))


def _margins_in(
    name: Side,
    run: Result,
    common: list[Event],
    own: Event | None,
    others: Event | None,
    late: float,
) -> Iterator[Margin]:
    """Yield the margins in one run, which has `own` where the other run has `others`."""
    if own is not None and (overlap := overlap_of(run, own)) is not None:
        yield _margin(name, "miss", run, own, overlap)
    if others is None:
        return
    later = None if own is None else _next_of(run, own, others)
    if own is not None and later is not None:
        lead = later.t - own.t
        speed = approach_speed(run, own)
        if abs(later.t - others.t) <= lead + 2.0 * late:
            if speed > 0.0:
                yield _margin(name, "order", run, own, lead * speed, lead)
            return
    start = max(
        (one.t for one in common if not set(one.balls).isdisjoint(others.balls)), default=0.0
    )
    # Up to twice the time that the balls took in the other run: a much later contact doesn't count.
    end = run.rest_time if own is None else min(own.t, 2.0 * others.t - start + late)
    gap, _ = nearest_approach(run, others, start, end)
    if gap > 0.0:
        yield _margin(name, "collision", run, others, gap)


def _next_of(run: Result, own: Event, others: Event) -> Event | None:
    """Return the collision `others` if it is next for its balls after `own`, else None."""
    log = events_in(events_of(run))
    after = log[log.index(own) + 1 :]
    first = next((one for one in after if not set(one.balls).isdisjoint(others.balls)), None)
    return first if first is not None and first.key == others.key else None


def _margin(
    name: Side,
    what: What,
    run: Result,
    event: Event,
    length: float,
    seconds: float | None = None,
) -> Margin:
    t = min(event.t, run.rest_time)
    places = run.sample([t]).positions[0, list(event.balls), :2]
    return Margin(name, what, event, length, in_ulps(length, [places]), seconds)
