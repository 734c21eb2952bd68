"""What no run of our engine may do where balls fly, looked up in its motion by brute force.

A ball is in no other one, in no nose of a cushion and not in the table, by more than rounding and
what resting contact in space may be off by; no energy comes in; a ball at rest lies on the cloth.
"""

from __future__ import annotations

import numpy as np

from ghostball.engine import simulate
from ghostball.model import Phase, Result, Samples, Scene, Status, energy_of
from ghostball.model.arrays import FloatArray
from ghostball.model.rounding import FLIGHT_CONTACT_TOLERANCE
from ghostball.validation.grading.tolerances import EPS
from ghostball.validation.runs.sampling import overlaps_of_balls
from ghostball.validation.stress.invariants import (
    Measured,
    energy_rise,
    faults_in,
    gap_rounding,
    instants,
    rise_limit_of_many,
    unsolved,
)


def faults_in_space(result: Result) -> list[str]:
    """Return what a run that was recorded as a trajectory does and must not, a sentence each."""
    times = instants(result)
    states = result.sample(times)
    found = _depths(result, times, states)
    energy = energy_of(result.scene, states).total
    found["rise of the energy [1]"] = (energy_rise(energy), rise_limit(result, times, states))
    found["contact steps or joint impacts left unsolved"] = (float(unsolved(result)), 0.0)
    return faults_in(found)


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

    A height is recorded as that of the centre, and rounded so: half a spacing at each of two
    instants.
    """
    scene, limit = result.scene, rise_limit_of_many(result, times, states)
    first = float(energy_of(scene, states).total[0])
    weights = scene.physics.gravity * scene.masses
    highest = float(weights @ states.positions[:, :, 2].max(axis=0))
    return limit + (EPS * highest / first if first > 0.0 else 0.0)


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
