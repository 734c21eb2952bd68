"""The energy error of a run, at the instants at which run and reference can be compared.

A collision removes energy at once. A run with a late collision keeps this energy until then. The
delay is an error of the event time, and limits on event times judge it. So energies aren't compared
between the two times that an event has in the run and in the reference. These times differ in the
last bits for exact engines, and by a time step or more for time-stepping engines. If only the run
or only the reference has an event, the energy that the event removes is an error of the energy.

An exact motion is compared on a grid, at each event, and at the last instant before each event.
Recorded frames are compared at the frames only, because the energy between frames isn't known. The
end of a slide doesn't count as an event here, because the energy doesn't jump at it.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ghostball.model import EventKind, Result, SampledTrajectory, Scene
from ghostball.model.arrays import FloatArray
from ghostball.validation.grading.event_logs import compare_logs, events_in
from ghostball.validation.runs.sampling import (
    MAX_TIMES,
    UNIFORM_TIMES,
    energy_at,
    events_of,
    union_times,
)

_JUMPS = tuple(
    kind for kind in EventKind if kind not in (EventKind.SLIDE_TO_ROLL, EventKind.ROLL_TO_REST)
)
"""Kinds of events that change the energy at once."""


def conserves_energy(scene: Scene) -> bool:
    """Return True if energy is conserved in a scene: no friction, no drag, everything elastic."""
    physics = scene.physics
    cushions = scene.table is not None and scene.table.has_cushions
    elastic_cushions = physics.cushion == "mirror" or (
        physics.cushion == "restitution"
        and physics.cushion_restitution == physics.cushion_tangential_restitution == 1.0
        and physics.cushion_restitution_loss == 0.0
    )
    slides = bool(np.any(scene.sliding_frictions)) or physics.ball_friction != 0.0
    twists = bool(np.any(scene.spinning_friction_rates * scene.angular_velocities[:, 2]))
    return (
        (physics.motion == "rolling" or not (slides or twists))
        and physics.rolling_friction == 0.0
        and physics.air_drag == physics.rolling_friction_quadratic == 0.0
        and not physics.airborne
        and (scene.table is None or not scene.table.holes)
        and (len(scene.balls) == 1 or physics.ball_restitution == 1.0)
        and (not cushions or elastic_cushions)
    )


def energy_differences(
    result: Result, truth: Result, until: float = math.inf
) -> tuple[FloatArray, FloatArray]:
    """Return instants (k,) [s], and the energy errors of the run at these instants, (k,) [J].

    `result`, `truth`: run and reference of the same scene, recorded with `record="trajectory"`.
    `until` [s]: the last instant that is compared.
    """
    times, differences = _differences(result, truth)
    return times[times <= until], differences[times <= until]


def compared_instants(result: Result, truth: Result, until: float = math.inf) -> FloatArray:
    """Return the instants at which run and reference have had the same events, (k,) [s].

    Parameters are those of `energy_differences`.
    """
    times = _instants(result, truth)
    return times[times <= until]


@lru_cache(maxsize=1)  # keyed by identity: several metrics use it
def _differences(result: Result, truth: Result) -> tuple[FloatArray, FloatArray]:
    """Return all instants compared (k,) [s], and the energy errors at them, (k,) [J]."""
    times = _instants(result, truth)
    true = truth.energy(times).total if len(times) else np.empty(0)
    return times, np.abs(energy_at(result, times).total - true)


@lru_cache(maxsize=1)
def _instants(result: Result, truth: Result) -> FloatArray:
    """Return all instants at which run and reference have had the same events, (k,) [s]."""
    logs = [events_in(events_of(run), _JUMPS) for run in (truth, result)]
    pairs = compare_logs(*logs).pairs
    instants = np.array([(one.t, other.t) for one, other in pairs]).reshape(-1, 2)
    earlier, later = np.min(instants, axis=1), np.max(instants, axis=1)
    frames = result.trajectory
    if isinstance(frames, SampledTrajectory):
        times = _few(np.unique(frames.times), later)
    else:
        known = np.concatenate([earlier, later, events_of(result)["t"], events_of(truth)["t"]])
        times = union_times(
            result.rest_time, known, uniform=UNIFORM_TIMES, limit=MAX_TIMES, before=True
        )
    # A frame at the time of an event may show the state before or after it.
    last = later if not isinstance(frames, SampledTrajectory) else np.nextafter(later, np.inf)
    inside = np.searchsorted(np.sort(earlier), times, side="right") > np.searchsorted(
        np.sort(last), times, side="right"
    )
    compared: FloatArray = times[~inside]
    return compared


def _few(times: FloatArray, later: FloatArray) -> FloatArray:
    """Return a part of the frames' times: evenly chosen, and the first after each event."""
    even = np.linspace(0, len(times) - 1, min(len(times), MAX_TIMES)).astype(np.intp)
    after = np.searchsorted(times, later, side="right")
    return times[np.union1d(even, after[after < len(times)])]
