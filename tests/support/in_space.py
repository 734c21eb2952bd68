"""What no run of our engine may do where balls fly, looked up in its motion by brute force.

A ball is in no other one, in no nose of a cushion and not in the table, by more than rounding and
what resting contact in space may be off by; no energy comes in; a ball at rest lies on the cloth.
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
"""What is measured of a run: by its name, its value and the most that it may be."""

BETWEEN = 3
"""Instants from each event to the next at which a run is looked at, beside those of the events and
of the changes of a ball's motion, and just before."""

MOST_STEPS = 64
"""Contact steps that may err the same way: more than a contact takes from its start to its end."""


def faults_in_space(result: Result) -> list[str]:
    """Return what a run that was recorded as a trajectory does and must not, a sentence each."""
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
        if not value <= limit  # nor where it is NaN
    ]


def instants(result: Result) -> FloatArray:
    """Return the instants at which an exact run is looked at, (k,) [s], sorted."""
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
    """Return by how much energy ever exceeds the least before it, over the first."""
    rise = largest_rise(energy)
    if rise <= 0.0:
        return 0.0
    return rise / float(energy[0]) if energy[0] > 0.0 else np.inf


def gap_rounding(scene: Scene, positions: FloatArray) -> float:
    """Return how far rounding alone may put a closed gap off [m]: some ulps of the coordinates."""
    largest = float(np.max(np.abs(positions[:, :, :2]), initial=0.0))
    return 8.0 * EPS * max(largest, float(scene.radii.max()))


def after_the_first_event(scene: Scene) -> tuple[np.void, FloatArray, FloatArray]:
    """Return the event, and velocities and spins just after it, (n, 3) each."""
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
    """Return the largest `energy_rise` that a run may have.

    A rounding of each of the three parts that a ball's energy has; those of many impacts, by chance
    half a spacing each; what the cloth takes while the clock is rounded; and what contact steps may
    err by, twice that of the velocities. A height is recorded as that of the centre, rounded so.
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
    """Return how deep balls are in the table, in each other, and in the noses of cushions."""
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
