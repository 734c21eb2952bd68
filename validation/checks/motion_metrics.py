"""Metrics of the motion that a run shows: its energy, overlaps, momentum and counters."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ghostball.model import EventKind, Result, first_energy
from ghostball.model.arrays import FloatArray
from ghostball.validation.checks.certificate_metrics import certified_motion, in_roundings
from ghostball.validation.checks.energy_curve import conserves_energy, energy_differences
from ghostball.validation.checks.energy_gain import largest_gain
from ghostball.validation.checks.metric import (
    Compute,
    MetricGroup,
    NotMeasuredError,
    RunAndTruth,
    RunIncompleteError,
)
from ghostball.validation.runs.sampling import (
    deepest_contact,
    energy_series,
    energy_times,
    events_of,
    frames_of,
    largest_cushion_overlap,
    largest_overlap,
    momentum_series,
)

MOTION: Final = MetricGroup()


def _finite(energy: FloatArray) -> FloatArray:
    if not np.all(np.isfinite(energy)):
        raise RunIncompleteError("the energy of the engine's motion is not finite")
    return energy


def _initial(result: Result) -> float:
    first = first_energy(result.scene)
    if first == 0.0:
        raise NotMeasuredError("not applicable: nothing moves at the start")
    return first


def _compared(run: RunAndTruth, right: Result, until: float) -> tuple[FloatArray, FloatArray]:
    """Return times up to `until` (k,) [s], and energy differences at these times (k,) [J]."""
    times, differences = energy_differences(run.result, right, until)
    if not len(times):
        raise NotMeasuredError("a collision is due at the start: no energy can be compared")
    return times, differences


def _differences(run: RunAndTruth) -> tuple[FloatArray, FloatArray]:
    """Return times up to the horizon, and the differences from the reference energy at them."""
    run.require_end()
    right = run.known("energy", run.truth.motion)
    if run.truth.is_own_measure(run.result.engine, "energy"):
        raise NotMeasuredError(
            "the reference energy of this shot is that of Ghostball's own engine"
        )
    times, differences = _compared(run, right, run.horizon)
    return times, _finite(differences)


@MOTION.metric(
    "energy_difference_max",
    "1",
    "largest deviation from the reference energy, divided by the initial energy; energies between "
    "the two times of a matching event aren't compared",
    "energy",
)
def _energy_difference_max(run: RunAndTruth) -> float:
    return float(np.max(_differences(run)[1])) / _initial(run.result)


@MOTION.metric("energy_difference_time", "s", "time of `energy_difference_max`", "energy")
def _energy_difference_time(run: RunAndTruth) -> float:
    times, differences = _differences(run)
    largest = int(np.argmax(differences))
    if differences[largest] == 0.0:
        raise NotMeasuredError("the energy equals the reference at every instant compared")
    return float(times[largest])


@MOTION.metric(
    "energy_difference_factor",
    "1",
    "largest energy error up to the horizon for rounding errors, in units of the error that one "
    "rounding per event would cause",
    "certificate",
)
def _energy_difference_factor(run: RunAndTruth) -> float:
    found, rounding, scene = run.grade, run.rounding, run.result.scene
    times, differences = _compared(run, certified_motion(run, "energy"), found.until)
    sizes = rounding.energy_at(times)
    if scene.physics.airborne:  # rounding of heights may exceed the energy of a slow ball
        sizes = sizes + scene.physics.gravity * float(scene.masses @ scene.positions[:, 2])
    return in_roundings(differences, sizes)


@MOTION.metric(
    "energy_drift",
    "1",
    "largest change of energy where it should be conserved, divided by the initial energy",
)
def _energy_drift(run: RunAndTruth) -> float:
    if not conserves_energy(run.result.scene):
        raise NotMeasuredError("energy isn't conserved in this scene")
    energy = _finite(energy_series(run.result))
    return float(np.max(np.abs(energy - energy[0]))) / _initial(run.result)


@MOTION.metric(
    "energy_rise",
    "1",
    "largest rise of energy above its earlier minimum, at each impact and frame, divided by the "
    "initial energy; in a time step with an impact, the rise above the energy that cloth friction "
    "leaves",
)
def _energy_rise(run: RunAndTruth) -> float:
    _finite(energy_series(run.result))
    certificate = run.truth.certificate
    pressed = certificate is not None and certificate.ending == "sustained contact"
    gain = largest_gain(run.result, run.resolution, pressed=pressed)
    if gain > 0.0 and first_energy(run.result.scene) == 0.0:
        return math.inf  # energy from nothing
    return gain / _initial(run.result)


@MOTION.metric(
    "overlap_max",
    "m",
    "largest overlap of two balls in the recorded motion; with impacts that last, minus the "
    "overlap at which a contact would have all of the energy",
)
def _overlap_max(run: RunAndTruth) -> float:
    if len(run.result.scene.balls) == 1:
        raise NotMeasuredError("not applicable: only one ball")
    return max(0.0, largest_overlap(run.result) - deepest_contact(run.result.scene))


@MOTION.metric(
    "cushion_overlap_max",
    "m",
    "largest overlap of a ball and a cushion, a jaw or a post in the recorded motion",
    on_demand=True,
)
def _cushion_overlap_max(run: RunAndTruth) -> float:
    table = run.result.scene.table
    if table is None or not table.has_cushions:
        raise NotMeasuredError("not applicable: no cushions")
    return largest_cushion_overlap(run.result)


@MOTION.metric(
    "momentum_drift",
    "1",
    "largest change of the balls' total momentum in the plane, divided by the largest sum of their "
    "momenta",
    on_demand=True,
)
def _momentum_drift(run: RunAndTruth) -> float:
    momenta = momentum_series(run.result)
    largest = float(np.max(np.sum(np.linalg.norm(momenta, axis=2), axis=1)))
    if largest == 0.0:
        raise NotMeasuredError("not applicable: nothing moves")
    total = np.sum(momenta, axis=1)
    return float(np.max(np.abs(total - total[0]))) / largest


@MOTION.metric(
    "pocketed_count", "1", "balls that fall into a pocket", judges="shot", on_demand=True
)
def _pocketed_count(run: RunAndTruth) -> int:
    return int(np.count_nonzero(events_of(run.result)["kind"] == EventKind.POCKETED))


ENERGY_TIMES: Final = {"energy_time_75": 0.75, "energy_time_50": 0.5, "energy_time_25": 0.25}
"""Metrics of the decay of energy: the share of the initial energy that is left."""


def _energy_time(share: float) -> Compute:
    def compute(run: RunAndTruth) -> float:
        energy, frames = energy_series(run.result), frames_of(run.result)
        times = energy_times(run.result) if frames is None else frames.times
        below = np.flatnonzero(energy <= share * _initial(run.result))
        if not len(below):
            raise NotMeasuredError(f"more than {share:.0%} of the energy is left at the end")
        return float(times[below[0]])

    return compute


for _name, _share in ENERGY_TIMES.items():
    MOTION.metric(
        _name,
        "s",
        f"first recorded time at which at most {_share:.0%} of the energy is left",
        on_demand=True,
    )(_energy_time(_share))


@MOTION.metric("event_count", "1", "events of any kind", on_demand=True)
def _event_count(run: RunAndTruth) -> int:
    return len(events_of(run.result))


@MOTION.metric(
    "contact_steps",
    "1",
    "short steps of the engine along resting contacts, if it counts them",
    on_demand=True,
)
def _contact_steps(run: RunAndTruth) -> int:
    if "contact_steps" not in run.result.work:
        raise NotMeasuredError("the engine doesn't count contact steps")
    return int(run.result.work["contact_steps"])


@MOTION.metric(
    "unsolved",
    "1",
    "resting contacts and simultaneous impacts that the engine reports as unsolved",
    on_demand=True,
)
def _unsolved(run: RunAndTruth) -> int:
    work = run.result.work
    counts = [count for name, count in work.items() if name.startswith("unsolved")]
    if not counts:
        raise NotMeasuredError("the engine doesn't count what it left unsolved")
    return int(sum(counts))
