"""What must hold in any run, looked up in its recorded motion by brute force.

Each function measures; what is too much is for the family to say.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine import Result, Scene
from engine.trajectory import SampledTrajectory

FloatArray = NDArray[np.float64]


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
    """Return the largest rise of energy from one instant to the next, over the first energy.

    Parameters
    ----------
    energy : (k,) float64 [J]
        In order of time.

    Returns
    -------
    float
        0 where it never rises; inf where it rises from 0.
    """
    rise = float(np.max(np.diff(energy), initial=0.0))
    if rise <= 0.0:
        return 0.0
    return rise / float(energy[0]) if energy[0] > 0.0 else np.inf


def unsolved(result: Result) -> int:
    """Return how many contact steps and joint impacts an engine of ours left unsolved."""
    return sum(
        result.work.get(name, 0) for name in ("unsolved_contact_steps", "unsolved_joint_impacts")
    )
