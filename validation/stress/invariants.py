"""What must hold in any run on the cloth, looked up in its motion by brute force; and how well.

Exact motion is held to rounding, and to what a sustained contact may be off by. An engine that
steps is held to the law that holds for every engine (`trial.play`): of overlaps of balls and of
energy nothing else is asked. What the law has no metric of may be off by what the engine's step
explains, where it is a place, and by the noise that the law leaves to a solver, where it is a part.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ghostball.engine.running.skips import is_integrated
from ghostball.model import (
    ExactTrajectory,
    Hole,
    Phase,
    Result,
    SampledTrajectory,
    Samples,
    Scene,
    energy_of,
)
from ghostball.model.arrays import FloatArray
from ghostball.model.rounding import CONTACT_TOLERANCE
from ghostball.model.scene.obstacles import gap_to
from ghostball.validation.checks.criteria import common_criteria
from ghostball.validation.checks.energy_gain import largest_rise
from ghostball.validation.grading.tolerances import CONTACT_STEP, EPS
from ghostball.validation.runs.sampling import overlaps_of_balls, times_gone
from ghostball.validation.runs.steps import STEP_SETTINGS

Measured = dict[str, tuple[float, float]]
"""What is measured of a run: by its name, its value and the most that it may be."""

LAW_ERROR = 1e-7
"""Of the speeds, what a law may be off by that integrates over an impact: twice that of the energy,
at each of two instants."""

MOST_STEPS = 64
"""Contact steps that may err the same way: more than a contact takes from its start to its end."""

BETWEEN = 3
"""Instants from each event to the next at which a run is looked at, beside those of the events.

And, in exact motion, beside those at which a ball's motion changes, and just before.
"""

MOST_DISTANCES = 4_000_000
"""Distances of two balls that are computed in one run: of more instants, some are left out."""


def measured(result: Result, times: FloatArray, random: bool = False) -> Measured:
    """Return what no run on the cloth may do, how much of it this one does, and the most allowed.

    `result`: recorded as a trajectory.
    `times` (k,) float64 [s]: instants at which it is looked at.
    `random`: see `judges.Invariants`.
    """
    scene, states = result.scene, result.sample(times)
    found = _depths(result, times, states, random)
    if is_exact(result):
        limit = rise_limit_of_many(result, times, states) if random else rise_limit(result)
        limit += 4.0 * LAW_ERROR if random and is_integrated(scene) else 0.0
        rise = energy_rise(energy_of(scene, states).total)
        found["rise of the energy [1]"] = (rise, limit)
    found["contact steps or joint impacts left unsolved"] = (float(unsolved(result)), 0.0)
    return found


def faults_in(found: Measured) -> list[str]:
    """Return what is measured and more than it may be, one sentence each."""
    return [
        f"{name} of {value:.3g}, at most {limit:.3g}"
        for name, (value, limit) in found.items()
        if not value <= limit  # nor where it is NaN
    ]


def _depths(result: Result, times: FloatArray, states: Samples, random: bool) -> Measured:
    """Return how deep balls overlap each other, of exact motion, and how deep cushions."""
    exact = isinstance(result.trajectory, ExactTrajectory)
    here = (
        result.phases(times) != Phase.GONE if exact else times[:, np.newaxis] < times_gone(result)
    )
    depths = overlaps(result.scene, states.positions, here)
    limit = overlap_limit(result, states.positions)
    ways = np.zeros(len(times))
    if random:  # the instant of an impact is rounded, and two balls continue for that long
        speeds = np.linalg.norm(states.velocities, axis=2).max(axis=1)
        ways = 2.0 * speeds * np.spacing(times)
    found: Measured = {}
    for column, name in enumerate(("overlap of balls [m]", "overlap of ball and cushion [m]")):
        if column == 1 or is_exact(result):
            k = int(np.argmax(depths[:, column] - ways))
            found[name] = (float(np.maximum(depths[k, column], 0.0)), limit + float(ways[k]))
    return found


def overlaps(
    scene: Scene, positions: FloatArray, here: NDArray[np.bool_] | None = None
) -> FloatArray:
    """Return the deepest overlap of two balls, and of a ball with a cushion, at each instant.

    `positions` (k, n, 3) float64 [m].
    `here` (k, n) bool: whether a ball is on the table, which one in a pocket isn't; None: all are.

    Returns (k, 2) float64 [m]: negative where nothing touches.
    """
    radii = scene.radii
    deepest = np.full((len(positions), 2), -np.inf)
    deepest[:, 0] = overlaps_of_balls(scene, positions, here)
    x, y = positions[:, :, 0], positions[:, :, 1]
    if scene.table is not None:
        for side in scene.table.sides:
            beyond = radii - side.distance(x, y)
            deepest[:, 1] = np.maximum(deepest[:, 1], np.max(beyond, axis=1))
        for one in scene.table.obstacles:
            if not isinstance(one, Hole):
                beyond = radii - gap_to(one, x, y)
                deepest[:, 1] = np.maximum(deepest[:, 1], np.max(beyond, axis=1))
    return deepest


def instants(result: Result, most: int = MOST_DISTANCES) -> FloatArray:
    """Return the instants at which a run is looked at, (k,) [s], sorted.

    `result`: recorded with "events" or "trajectory".
    `most`: of instants: where there are more, or more than `MOST_DISTANCES` allows, some of them,
        evenly taken, and the end.

    Where an engine records frames: these alone. Between them its states are means of two, which it
    never claimed, and a mean of the velocities before and after an impact has lost energy.
    """
    if isinstance(result.trajectory, SampledTrajectory):
        times = np.unique(result.trajectory.times)
    else:
        assert result.events is not None
        marks = np.unique(np.concatenate(([0.0], result.events["t"], [result.rest_time])))
        parts = np.arange(BETWEEN + 1) / (BETWEEN + 1)
        inner = marks[:-1, np.newaxis] + np.diff(marks)[:, np.newaxis] * parts
        times = np.append(inner.ravel(), marks[-1])
    if isinstance(result.trajectory, ExactTrajectory):
        changes = np.concatenate([segments[:, 0] for segments in result.trajectory.segments])
        changes = changes[(changes > 0.0) & (changes <= result.rest_time)]
        times = np.unique(np.concatenate((times, changes, np.nextafter(changes, 0.0))))
    most = min(most, max(MOST_DISTANCES // len(result.scene.balls) ** 2, 2))
    if len(times) > most:
        times = times[np.linspace(0, len(times) - 1, most).round().astype(np.int64)]
    return times


def energy_rise(energy: FloatArray) -> float:
    """Return by how much energy ever exceeds the least before it, over the first.

    So that many small rises count as what they add up to. 0 where it never rises, infinite where it
    rises from 0.

    `energy` (k,) float64 [J]: in order of time.
    """
    rise = largest_rise(energy)
    if rise <= 0.0:
        return 0.0
    return rise / float(energy[0]) if energy[0] > 0.0 else np.inf


def is_exact(result: Result) -> bool:
    """Whether a run is held to rounding: its motion is recorded in closed form."""
    return isinstance(result.trajectory, ExactTrajectory)


def overlap_limit(result: Result, positions: FloatArray) -> float:
    """Return the deepest overlap that a run may have at these places, (k, n, 3) [m]; in metres.

    Of an engine that steps that is with a cushion, and less than any ball's radius, beyond which it
    has left the table; the law says how deep balls may overlap.
    """
    scene = result.scene
    if not is_exact(result):
        return gap_rounding(scene, positions) + min(
            travel_in_a_step(result), float(scene.radii.min())
        )
    return gap_rounding(scene, positions) + CONTACT_TOLERANCE * 2.0 * float(scene.radii.max())


@cache
def solver_noise() -> float:
    """Return the part of the energy that the common law leaves to any engine's solver."""
    rows = common_criteria().criteria
    (limit,) = (one.limit for one in rows if one.metric == "energy_rise" and one.claiming is None)
    return float(limit)


def rise_limit(result: Result) -> float:
    """Return the largest `energy_rise` that an exact motion may have.

    A rounding of each of the three parts that a ball's energy has, for the sum
    over them may round all the same way; of few balls, those of their speeds as well.
    """
    return max(16.0, 3.0 * len(result.scene.balls)) * EPS


def rise_limit_of_many(result: Result, times: FloatArray, states: Samples) -> float:
    """Return the largest `energy_rise` that an exact motion of many events may have.

    The roundings of many impacts that lose nothing add up, by chance half a spacing of doubles
    each, sqrt(n) / 2 of n together, and four times as much isn't seen. An instant, too, is rounded,
    to what the cloth takes in the spacing of the clock there: next to nothing, unless a slow ball
    slides after days. And each contact step may err by `CONTACT_STEP` of the velocities, so by
    twice that of the energy. Steps of one contact err the same way, and one takes no more than some
    fifty.
    """
    scene = result.scene
    limit = rise_limit(result) + 2.0 * EPS * math.sqrt(result.work["events"])
    first = float(energy_of(scene, states).total[0])
    if first > 0.0:
        limit += 4.0 * float(np.max(np.spacing(times) * _most_taken(scene, states))) / first
    steps = min(result.work.get("contact_steps", 0), MOST_STEPS)
    return limit + (2.0 * CONTACT_STEP * (1 + steps) if steps else 0.0)


def _most_taken(scene: Scene, states: Samples) -> FloatArray:
    """Return at most what the cloth takes of the energy at each instant, (k,) [W]."""
    speeds = np.linalg.norm(states.velocities, axis=2)
    speeds += scene.radii * np.linalg.norm(states.angular_velocities, axis=2)
    frictions = np.maximum(scene.sliding_frictions, scene.rolling_frictions)
    taken: FloatArray = speeds @ (frictions * scene.masses * scene.physics.gravity)
    return taken


def gap_rounding(scene: Scene, positions: FloatArray) -> float:
    """Return how far rounding alone may put a closed gap off [m]: some ulps of the coordinates."""
    largest = float(np.max(np.abs(positions[:, :, :2]), initial=0.0))
    return 8.0 * EPS * max(largest, float(scene.radii.max()))


def travel_in_a_step(result: Result) -> float:
    """Return how far the fastest ball goes at first in a step of the engine [m].

    Infinite where the result doesn't say how long its steps are. Its speed is that of the centre or
    of the surface, whichever is greater: spin becomes speed.
    """
    steps = (float(result.settings.get(name) or math.inf) for name in STEP_SETTINGS)
    step = min(steps, default=math.inf)
    scene = result.scene
    centres = np.linalg.norm(scene.velocities, axis=1)
    surfaces = scene.radii * np.linalg.norm(scene.angular_velocities, axis=1)
    fastest = float(np.maximum(centres, surfaces).max())
    return step * fastest if fastest > 0.0 else 0.0


def unsolved(result: Result) -> int:
    """Return how many contact steps and joint impacts an engine of ours left unsolved."""
    return sum(count for name, count in result.work.items() if name.startswith("unsolved"))
