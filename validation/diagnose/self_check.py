"""Check that the events of a result agree with its samples, and that times are in seconds.

    >>> contradiction_in(result, known)
    '`events` says that "cue" hits "object" at t = 0.2 s, but in its samples ...'

A comparison with a reference means nothing if a result contradicts itself. Every received result is
already checked to end where its samples end.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np

from ghostball.model import Result, SampledTrajectory
from ghostball.validation.diagnose.margins import gaps
from ghostball.validation.grading.event_logs import Event, compare_logs, events_in
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.truth.known_shot import KnownShot

LARGEST_GAP: Final = 0.02
"""Allowed gap of colliding balls in the samples, in radii; their motion in two frames is added.

Solvers that add a margin to their shapes let balls collide this early.
"""

MILLISECONDS: Final = 1000.0

RATIO_TOLERANCE: Final = 0.1
"""Largest relative deviation from 1000 of a ratio of times that indicates milliseconds."""


def contradiction_in(result: Result, known: KnownShot) -> str:
    """Return how a result contradicts itself, or that its times are in milliseconds; or "".

    `result`: with its events and its motion.
    """
    return _times(result, known) or _contacts(result)


def _times(result: Result, known: KnownShot) -> str:
    """Return a message if times are about a thousand times those of the reference; or ""."""
    true = events_in(events_of(known.result))
    pairs = compare_logs(true, events_in(events_of(result))).pairs
    ratios = [b.t / a.t for a, b in pairs if a.t > 0.0]
    if known.result.rest_time > 0.0:
        ratios.append(result.rest_time / known.result.rest_time)
    if not ratios or not abs(float(np.median(ratios)) / MILLISECONDS - 1.0) < RATIO_TOLERANCE:
        return ""
    return (
        f"its times look like milliseconds: they are {np.median(ratios):.4g} times those of the "
        "reference. Give `t`, `rest_time` and the times of samples in seconds"
    )


def _contacts(result: Result) -> str:
    """Return a message about the collision with the largest gap in the samples; or ""."""
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
        allowed = LARGEST_GAP * float(result.scene.radii[balls].min()) + 2.0 * spacing * speed
        if gap > allowed and (worst is None or gap > worst[0]):
            worst = gap, one
    if worst is None:
        return ""
    gap, one = worst
    first, obstacle = one.first_ball(result.scene), one.obstacle(result.scene)
    return (
        f"`events` says that {one.describe(result.scene)} at t = {one.t:.6g} s, but in its samples "
        f"{first} is then {1e3 * gap:.3g} mm away from {obstacle}"
    )


def _spacing(result: Result) -> float:
    """Return the longest time between two frames [s]; 0 for an exact motion."""
    if not isinstance(result.trajectory, SampledTrajectory):
        return 0.0
    return max((b - a for a, b in pairwise(result.trajectory.times.tolist())), default=0.0)
