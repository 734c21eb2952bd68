"""Check a run with flying balls for impossible motion, by brute force at many times.

A ball must not overlap another ball, a cushion nose or the table by more than rounding and the
tolerance of resting contact in space. The energy must not rise. A ball at rest must lie on the
cloth.
"""

from __future__ import annotations

import numpy as np

from ghostball.engine import simulate
from ghostball.model import ExactTrajectory, Phase, Result, Samples, Scene, Status, energy_of
from ghostball.model.arrays import FloatArray
from ghostball.model.rounding import FLIGHT_CONTACT_TOLERANCE
from ghostball.validation.checks.energy_gain import largest_rise
from ghostball.validation.grading.tolerances import CONTACT_STEP, EPS
from ghostball.validation.runs.sampling import overlaps_of_balls

Measured = dict[str, tuple[float, float]]
"""Measured quantities of a run: value and limit, by name."""

BETWEEN = 3
"""Number of checked times between neighbouring events. Times at and just before events and changes
of a ball's motion are also checked."""

MOST_STEPS = 64
"""Number of contact steps whose errors may have the same sign: more than one contact takes."""


def faults_in_space(result: Result) -> list[str]:
    """Return a sentence for each impossible property of a run with a recorded trajectory."""
    times = instants(result)
    states = result.sample(times)
    found = _depths(result, times, states)
    energy = energy_of(result.scene, states).total
    found["rise of the energy [1]"] = (energy_rise(energy), rise_limit(result, times, states))
    left = sum(count for name, count in result.work.items() if name.startswith("unsolved"))
    found["contact steps or joint impacts left unsolved"] = (float(left), 0.0)
    return [
        f"{name} of {value:.3g}, at most {limit:.3g}"
        for name, (value, limit) in found.items()
        if not value <= limit  # also true for NaN
    ]


def instants(result: Result) -> FloatArray:
    """Return the times at which an exact run is checked, (k,) [s], sorted."""
    assert result.events is not None
    assert isinstance(result.trajectory, ExactTrajectory)
    marks = np.unique(np.concatenate(([0.0], result.events["t"], [result.rest_time])))
    parts = np.arange(BETWEEN + 1) / (BETWEEN + 1)
    inner = marks[:-1, np.newaxis] + np.diff(marks)[:, np.newaxis] * parts
    changes = np.concatenate([segments[:, 0] for segments in result.trajectory.segments])
    changes = changes[(changes > 0.0) & (changes <= result.rest_time)]
    return np.unique(
        np.concatenate((inner.ravel(), marks[-1:], changes, np.nextafter(changes, 0.0)))
    )


def energy_rise(energy: FloatArray) -> float:
    """Return the largest rise of the energy above its earlier minimum, over the initial energy."""
    rise = largest_rise(energy)
    if rise <= 0.0:
        return 0.0
    return rise / float(energy[0]) if energy[0] > 0.0 else np.inf


def gap_rounding(scene: Scene, positions: FloatArray) -> float:
    """Return the largest error of a closed gap by rounding alone [m]: a few ulps of coordinates."""
    largest = float(np.max(np.abs(positions[:, :, :2]), initial=0.0))
    return 8.0 * EPS * max(largest, float(scene.radii.max()))


def after_the_first_event(scene: Scene) -> tuple[np.void, FloatArray, FloatArray]:
    """Return the first event, and velocities and spins just after it, (n, 3) each."""
    result = simulate(scene, record="trajectory")
    event = result.events[0]
    states = result.sample([event["t"]])
    return event, states.velocities[0], states.angular_velocities[0]


def energies_around_events(result: Result) -> FloatArray:
    """Return the energy just before and after each event [J]."""
    assert result.events is not None
    times = np.unique(result.events["t"])
    return result.energy(np.sort(np.concatenate((times, np.nextafter(times, 0.0))))).total


def rise_limit(result: Result, times: FloatArray, states: Samples) -> float:
    """Return the limit on `energy_rise` for a run.

    It is the sum of: one rounding of each of the three parts of a ball's energy; random roundings
    of half an ulp at each impact; the energy loss to the cloth during one rounding of the clock;
    and twice the velocity errors of contact steps. Heights are recorded, and rounded, at the
    centre.
    """
    scene = result.scene
    limit = max(16.0, 3.0 * len(scene.balls)) * EPS + 2.0 * EPS * np.sqrt(result.work["events"])
    steps = min(result.work.get("contact_steps", 0), MOST_STEPS)
    limit += 2.0 * CONTACT_STEP * (1 + steps) if steps else 0.0
    first = float(energy_of(scene, states).total[0])
    if first <= 0.0:
        return float(limit)
    speeds = np.linalg.norm(states.velocities, axis=2)
    speeds += scene.radii * np.linalg.norm(states.angular_velocities, axis=2)
    frictions = np.maximum(scene.sliding_frictions, scene.rolling_frictions)
    taken = speeds @ (frictions * scene.masses * scene.physics.gravity)
    weights = scene.physics.gravity * scene.masses
    highest = float(weights @ states.positions[:, :, 2].max(axis=0))
    return float(limit + (4.0 * np.max(np.spacing(times) * taken) + EPS * highest) / first)


def _depths(result: Result, times: FloatArray, states: Samples) -> Measured:
    """Return the depths of balls in the table, in each other, and in cushion noses, with limits."""
    scene = result.scene
    here = result.phases(times) != Phase.GONE
    places, radii = states.positions, scene.radii
    rounding = gap_rounding(scene, places)
    limit = rounding + FLIGHT_CONTACT_TOLERANCE * 2.0 * float(radii.max())
    found = {"depth in the table [m]": (float((radii - places[:, :, 2]).max()), rounding)}
    if len(radii) > 1:
        deepest = float(overlaps_of_balls(scene, places, here).max())
        found["overlap of balls [m]"] = (max(deepest, -1.0), limit)
    if scene.table is not None and scene.table.cushions:
        x, y = places[:, :, 0], places[:, :, 1]
        above = places[:, :, 2] - scene.physics.cushion_height
        deepest = -1.0
        for side in scene.table.sides:
            depth = radii - np.hypot(np.maximum(side.distance(x, y), 0.0), above)
            deepest = max(float(np.where(here, depth, -1.0).max()), deepest)
        found["overlap of ball and nose [m]"] = (deepest, limit)
    if result.status is Status.REST:
        last = result.sample([result.rest_time])
        on_cloth = result.phases(np.array([result.rest_time]))[0] != Phase.GONE
        above = np.where(on_cloth, np.abs(last.positions[0, :, 2] - radii), 0.0)
        found["height of a ball at rest over the cloth [m]"] = (float(above.max()), rounding)
    return found
