"""Whether a result agrees with itself: its rest positions, its samples and its events.

    >>> contradiction_in(result, known)
    '`rest_positions` has "cue" 0.1 mm from where its samples end'

No comparison with a reference says anything about physics as long as a result contradicts itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import numpy as np

from ghostball.model import Result, SampledTrajectory, Scene
from ghostball.model.arrays import FloatArray
from ghostball.validation.diagnose.near_misses import gaps
from ghostball.validation.grading.event_logs import Event, compare_logs, events_in
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.truth.known_shot import KnownShot

SAME_PLACE: Final = 1e-6
"""How far the rest positions may be from the end of the samples [m]: single precision at 10 m."""

TOUCHING: Final = 0.02
"""How far apart balls may be in the samples when they collide, in radii, besides two frames' way.

A solver that adds a margin to its shapes lets balls collide this early.
"""

MILLISECONDS: Final = 1000.0

NEARLY: Final = 0.1
"""How near a ratio of times must be to 1000 for milliseconds, as a share of it."""


def contradiction_in(result: Result, known: KnownShot) -> str:
    """Return in what a result contradicts itself, or counts milliseconds; "" if in nothing.

    `result`: with its events and its motion.
    """
    looks = (_times(result, known), _ends(result), _contacts(result))
    return next((found for found in looks if found), "")


def _times(result: Result, known: KnownShot) -> str:
    """Return a sentence if times are a thousand times those of the reference."""
    true = events_in(events_of(known.result))
    pairs = compare_logs(true, events_in(events_of(result))).pairs
    ratios = [b.t / a.t for a, b in pairs if a.t > 0.0]
    if known.result.rest_time > 0.0:
        ratios.append(result.rest_time / known.result.rest_time)
    if not ratios or not abs(float(np.median(ratios)) / MILLISECONDS - 1.0) < NEARLY:
        return ""
    return (
        f"its times look like milliseconds: they are {np.median(ratios):.4g} times those of the "
        "reference. Give `t`, `rest_time` and the times of samples in seconds"
    )


def _ends(result: Result) -> str:
    """Return how the rest positions differ from where the samples end."""
    scene, rest = result.scene, result.rest_positions[:, :2]
    end = result.sample([result.rest_time]).positions[0, :, :2]
    off = np.hypot(*(rest - end).T)
    if not np.max(off) > SAME_PLACE:
        return ""
    names = [f'"{ball.id}"' for ball in scene.balls]
    moved = np.flatnonzero(off > SAME_PLACE)
    among = np.hypot(*np.moveaxis(rest[:, np.newaxis] - end, 2, 0))
    order = np.argmin(among, axis=1)
    if np.all(among[np.arange(len(rest)), order] <= SAME_PLACE) and len(set(order)) == len(rest):
        if len(moved) == 2:
            one, two = (names[ball] for ball in moved)
            return f"`rest_positions` lists {one} and {two} in each other's place"
        return (
            f"`rest_positions` lists balls in another order than the samples: {names[moved[0]]} "
            f"is where the samples end for {names[order[moved[0]]]}"
        )
    for what, mirrored in _mirrored(scene, end):
        if np.max(np.hypot(*(rest - mirrored).T)) <= SAME_PLACE:
            return f"`rest_positions` is mirrored against the end of the samples: {what}"
    worst = int(np.argmax(off))
    return (
        f"`rest_positions` has {names[worst]} {_length(off[worst])} from where its samples end"
        + (f"; so it is with {len(moved)} balls" if len(moved) > 1 else "")
    )


def _mirrored(scene: Scene, places: FloatArray) -> Iterator[tuple[str, FloatArray]]:
    """Yield mirror images of places (n, 2), each with how it is made."""
    x, y = places.T
    yield "x has the other sign", np.column_stack([-x, y])
    yield "y has the other sign", np.column_stack([x, -y])
    yield "x and y are exchanged", np.column_stack([y, x])
    if scene.table is not None and scene.table.length is not None:
        length, width = float(scene.table.length), float(scene.table.width)
        yield "x is counted from the right cushion", np.column_stack([length - x, y])
        yield "y is counted from the top cushion", np.column_stack([x, width - y])


def _contacts(result: Result) -> str:
    """Return the collision whose balls are farthest apart in the samples when it happens."""
    events = [one for one in events_in(events_of(result)) if one.t <= result.rest_time]
    if not events:
        return ""
    times = np.array([one.t for one in events])
    states, spacing = result.sample(times), _spacing(result)
    worst: tuple[float, Event] | None = None
    for k, one in enumerate(events):
        balls = list(one.balls)
        gap = float(gaps(result.scene, one, states.positions[[k]][:, balls, :2])[0])
        speed = float(np.sum(np.hypot(*states.velocities[k, balls, :2].T)))
        allowed = TOUCHING * float(result.scene.radii[balls].min()) + 2.0 * spacing * speed
        if gap > allowed and (worst is None or gap > worst[0]):
            worst = gap, one
    if worst is None:
        return ""
    gap, one = worst
    first, obstacle = one.first_ball(result.scene), one.obstacle(result.scene)
    return (
        f"`events` says that {one.describe(result.scene)} at t = {one.t:.6g} s, and in its samples "
        f"{first} is then {_length(gap)} away from {obstacle}"
    )


def _spacing(result: Result) -> float:
    """Return the longest time between two frames [s]; 0 for an exact motion."""
    if not isinstance(result.trajectory, SampledTrajectory):
        return 0.0
    return max((b - a for a, b in pairwise(result.trajectory.times.tolist())), default=0.0)


def _length(metres: float) -> str:
    return f"{1e3 * metres:.3g} mm"
