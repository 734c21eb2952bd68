"""Compute by how much two runs of one shot may differ because of rounding alone.

The tangent map of Ghostball's engine gives the allowance for each event time. It is used only while
the certified result confirms it: an error in the tangent map must not excuse an error elsewhere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ghostball.model import Events, Scene, UnsupportedSceneError
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.registry import OURS, make_engine
from ghostball.validation.baselines.compared_run import ComparedRun
from ghostball.validation.grading.certified_growth import growth_of_certificate
from ghostball.validation.grading.certified_widths import is_differentiated
from ghostball.validation.grading.event_logs import ALL_KINDS, compare_logs, events_in
from ghostball.validation.grading.horizon import Growth, RunGrowth, extent_of, horizon
from ghostball.validation.grading.tolerances import (
    LARGEST_GROWTH_RATIO,
    ROUNDINGS,
    TOLERANCE,
    UNIT_ROUNDOFF,
)
from ghostball.validation.runs.engine_runs import run_ours
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.runs.time_steps import step_of
from ghostball.validation.truth.certificates import certificate_of

UNAMPLIFIED = 64.0 * 2.0 * UNIT_ROUNDOFF
"""Relative difference that counts as rounding without a tangent map: the error of a few sums."""


_SOURCES = {
    "certificate": "the certified result",
    "engine": "Ghostball's own engine, because no certified result gives the error growth up to "
    "the end",
    "nothing": "unamplified roundings, because the error growth is unknown",
}
"""Sources of the allowance for rounding."""


@dataclass(frozen=True, eq=False)
class Allowance:
    """The differences that rounding explains in one shot.

    `horizon` [s]: time up to which the shot can be predicted; inf: to its end. Later events aren't
        compared.
    `map_end` [s]: time from which no derivative exists, for example because of simultaneous
        collisions; inf: never. Later, only rounding without amplification is allowed.
    `event_times` (m,) float64 [s]: allowed difference of each event time.
    `rest` (n,) float64 [m] or None: allowed difference of each rest position; None if the horizon
        comes before the end.
    `source`: source of the error growth: the certified result; Ghostball's engine, if the shot
        isn't certified to its end; or nothing, if Ghostball's engine doesn't support the shot.
    `roundings`: number of roundings allowed at each event; for a time-stepping engine, at least its
        number of time steps.
    """

    horizon: float
    map_end: float
    event_times: FloatArray
    rest: FloatArray | None
    source: Literal["certificate", "engine", "nothing"] = "engine"
    roundings: float = ROUNDINGS

    @property
    def account(self) -> str:
        """One sentence about the source of this allowance."""
        return f"the allowance for rounding is from {_SOURCES[self.source]}"


def allowance(played: ComparedRun) -> Allowance:
    """Return the differences that rounding explains in a run of any engine."""
    record = played.record
    scene = record.load_scene()
    if record.label == OURS:
        return allowance_of(scene)
    step = step_of(make_engine(record.label))
    # The engine's own count of its steps could widen the allowance without bound.
    steps = 0.0 if step is None else (record.rest_time or 0.0) / step
    return allowance_of_other(scene, played.log().events, steps)


def allowance_of(scene: Scene, roundings: float = ROUNDINGS) -> Allowance:
    """Run a shot on Ghostball's engine and return the differences that rounding explains.

    `roundings`: as in `Allowance`.

    The deviation of an event time is 2^-53 times the rms effect of rounding the state at each
    earlier event (`Result.rounding`); the deviation of a position is computed likewise
    (`CertifiedGrowth.sizes`). Certified results show that an engine without loss of digits stays
    within 32 of these deviations, so two runs are within 64 of each other.
    """
    error = roundings * UNIT_ROUNDOFF
    least = 2.0 * error  # two runs, on opposite sides of the exact shot
    unamplified = UNAMPLIFIED * roundings / ROUNDINGS
    result = run_ours(scene)
    times = events_of(result)["t"].astype(np.float64)
    with np.errstate(over="ignore", invalid="ignore"):
        shifts = np.sqrt(np.mean(np.square(result.rounding.event_shifts), axis=1))
    own = RunGrowth(result)
    growth: Growth = own
    certificate, _ = certificate_of(scene)
    certified = certificate is not None and certificate.proved and is_differentiated(scene)
    if certificate is not None and certified:
        growth = growth_of_certificate(scene, certificate)
    predictable = horizon(growth, TOLERANCE, error)
    map_end = min(own.derivative_ends, growth.derivative_ends)
    if certified:
        within = times[times < min(predictable, growth.derivative_ends)]
        map_end = min(map_end, _believed_until(own, growth, within))
    plain = unamplified * np.maximum(times, extent_of(scene))
    known = np.isfinite(shifts) & (times < map_end)
    tolerances = np.where(known, least * np.where(known, shifts, 0.0) + unamplified * times, plain)
    rest = None
    if math.isinf(predictable):
        smallest, sizes = unamplified * extent_of(scene), growth.sizes([result.rest_time])[0]
        rest = least * np.where(np.isfinite(sizes), sizes, 0.0) + smallest
    return Allowance(
        predictable, map_end, tolerances, rest, "certificate" if certified else "engine", roundings
    )


def allowance_of_other(scene: Scene, events: Events, steps: float = 0.0) -> Allowance:
    """Return the differences that rounding explains in a run of an engine other than Ghostball's.

    `events`: the events of that run.
    `steps`: number of time steps. Each time step rounds the state once; in the worst case all
        errors have the same direction.

    Errors grow as in the exact shot while the engine simulates that shot. An event therefore gets
    the allowance of the corresponding event of Ghostball's engine. Events without a counterpart get
    the allowance for rounding without amplification.
    """
    roundings = max(ROUNDINGS, steps)
    unamplified = UNAMPLIFIED * roundings / ROUNDINGS
    times = events["t"].astype(np.float64)
    smallest = unamplified * extent_of(scene)
    allowed = np.maximum(unamplified * times, smallest)
    try:
        ours = allowance_of(scene, roundings)
        true = events_of(run_ours(scene))
    except UnsupportedSceneError:
        rest = np.full(len(scene.balls), smallest)
        return Allowance(math.inf, math.inf, allowed, rest, "nothing", roundings)
    compared = compare_logs(events_in(true, ALL_KINDS), events_in(events, ALL_KINDS))
    for i, j in compared.index_pairs:
        allowed[j] = max(allowed[j], ours.event_times[i])
    return replace(ours, event_times=allowed)


def _believed_until(own: Growth, growth: Growth, times: FloatArray) -> float:
    """Return the time [s] from which the run's error growth exceeds the certified growth, or inf.

    The growth of each ball is compared between consecutive events, as the largest value so far.
    Event times of the run may differ a little from the certified times, so the result may be one
    event early.
    """
    starts = np.unique(np.append(0.0, times))
    looks = np.append(0.5 * (starts[:-1] + starts[1:]), starts[-1])
    ours, right = (
        np.maximum.accumulate(sizes, axis=0) for sizes in (own.sizes(looks), growth.sizes(looks))
    )
    beyond = np.flatnonzero((ours[:-1] > LARGEST_GROWTH_RATIO * right[1:]).any(axis=1))
    return float(starts[beyond[0]]) if len(beyond) else math.inf
