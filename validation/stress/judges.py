"""What must hold in any run, looked up in its recorded motion by brute force; and how well.

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

from ghostball.engine import ExactTrajectory, Result, Samples, Scene
from ghostball.engine.core.tolerances import MOTION_ERROR
from ghostball.engine.trajectory import SampledTrajectory, energy_of
from ghostball.validation.checks.criteria import common_criteria
from ghostball.validation.checks.energy_gain import largest_rise
from ghostball.validation.grading.tolerances import EPS
from ghostball.validation.runs.steps import STEP_SETTINGS

FloatArray = NDArray[np.float64]

CONTACT_SLOP = 2.0**-37
"""Overlap, in diameters, that an exact motion may have in a contact that lasts.

4e-13 m for pool balls: a thousand roundings of a coordinate on a table, so that the force that
holds a gap closed isn't made of rounding.
"""


MOST_STEPS = 64
"""Contact steps that may err the same way: more than a contact takes from its start to its end."""


def overlaps(scene: Scene, positions: FloatArray) -> FloatArray:
    """Return the deepest overlap of two balls, and of a ball with a cushion, at each instant.

    Parameters
    ----------
    scene : Scene
    positions : (k, n, 3) float64 [m]

    Returns
    -------
    (k, 2) float64 [m]
        Negative where everything is apart.
    """
    radii = scene.radii
    deepest = np.full((len(positions), 2), -np.inf)
    first, second = np.triu_indices(len(radii), 1)
    x, y = positions[:, :, 0], positions[:, :, 1]
    if len(first):
        dx, dy = x[:, first] - x[:, second], y[:, first] - y[:, second]
        reach = radii[first] + radii[second]
        deepest[:, 0] = np.max(reach - np.sqrt(dx * dx + dy * dy), axis=1)
    if scene.table is not None:
        beyond = {
            "left": radii - x,
            "right": x + radii - scene.table.length,
            "bottom": radii - y,
            "top": y + radii - scene.table.width,
        }
        for name in scene.table.cushions:
            deepest[:, 1] = np.maximum(deepest[:, 1], np.max(beyond[name], axis=1))
    return deepest


def instants(result: Result, between: int = 7) -> FloatArray:
    """Return the instants at which a run is looked at, (k,) [s], sorted.

    Parameters
    ----------
    result : Result
        Recorded with "events" or "trajectory".
    between : int
        Instants from each event to the next, beside those of the events themselves.

    Notes
    -----
    Where an engine records frames: these alone. Between them its states are means of two, which it
    never claimed, and a mean of the velocities before and after an impact has lost energy.
    """
    if isinstance(result.trajectory, SampledTrajectory):
        return np.unique(result.trajectory.times)
    assert result.events is not None
    marks = np.unique(np.concatenate(([0.0], result.events["t"], [result.rest_time])))
    parts = np.arange(between + 1) / (between + 1)
    inner = marks[:-1, np.newaxis] + np.diff(marks)[:, np.newaxis] * parts
    return np.append(inner.ravel(), marks[-1])


def energies(result: Result, times: FloatArray) -> FloatArray:
    """Return the total energy [J] at `times`, (k,)."""
    return result.energy(times).total


def energy_rise(energy: FloatArray) -> float:
    """Return by how much energy ever exceeds the least before it, over the first.

    So that many small rises count as what they add up to.

    Parameters
    ----------
    energy : (k,) float64 [J]
        In order of time.

    Returns
    -------
    float
        0 where it never rises; inf where it rises from 0.
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

    Of an engine that steps that is with a cushion; the law says how deep balls may overlap.
    """
    scene = result.scene
    slop = CONTACT_SLOP * 2.0 * float(scene.radii.max())
    return gap_rounding(scene, positions) + (slop if is_exact(result) else way_of_a_step(result))


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

    Hops of balls that lie on others lose nothing, so that the roundings of many add up, by chance
    half a spacing of doubles each, sqrt(n) / 2 of n together, and four times as much isn't seen. A
    height is recorded as that of the centre, and rounded so: half a spacing at each of two
    instants. An instant, too, is rounded, to what the cloth takes in the spacing of the clock
    there: next to nothing, unless a slow ball slides after days. And each contact step may err by
    `MOTION_ERROR` of the velocities, so by twice that of the energy. Steps of one contact err the
    same way, and one takes no more than some fifty.
    """
    scene = result.scene
    limit = rise_limit(result) + 2.0 * EPS * math.sqrt(result.work["events"])
    first = float(energy_of(scene, states).total[0])
    if scene.physics.airborne and first > 0.0:
        weights = scene.physics.gravity * scene.masses
        limit += EPS * float(weights @ states.positions[:, :, 2].max(axis=0)) / first
    if first > 0.0:
        limit += 4.0 * float(np.max(np.spacing(times) * _most_taken(scene, states))) / first
    steps = min(result.work.get("contact_steps", 0), MOST_STEPS)
    return limit + (2.0 * MOTION_ERROR * (1 + steps) if steps else 0.0)


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


def way_of_a_step(result: Result) -> float:
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
    return sum(
        result.work.get(name, 0) for name in ("unsolved_contact_steps", "unsolved_joint_impacts")
    )
