"""How far two runs of one shot may differ by rounding alone, as its proof says where there is one.

Our engine's tangent map says it of each event's instant, but is believed only as far as the proof
bears it out: a bug in that map must not explain what another bug changed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ghostball.model import Events, Scene, UnsupportedSceneError
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.registry import OURS, make_engine
from ghostball.validation.baselines.played import Played
from ghostball.validation.grading.certified_growth import growth_of_proof
from ghostball.validation.grading.certified_widths import is_differentiated
from ghostball.validation.grading.event_logs import ALL_KINDS, compare_logs, events_in
from ghostball.validation.grading.horizon import Growth, RunGrowth, extent_of, horizon
from ghostball.validation.grading.tolerances import OFF_BY, ROUNDINGS, TOLERANCE, UNIT_ROUNDOFF
from ghostball.validation.runs.ladder import step_of
from ghostball.validation.runs.playing import run_ours
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.truth.proof import proof_of

UNAMPLIFIED = 64.0 * 2.0 * UNIT_ROUNDOFF
"""Relative difference that needs no tangent map to be called rounding: some sums of a few terms."""


_SOURCES = {
    "proof": "the certified result",
    "engine": "Ghostball's own engine, because no certified result gives the error growth up to "
    "the end",
    "nothing": "unamplified roundings, because the error growth is unknown",
}
"""Where the allowance for rounding comes from."""


@dataclass(frozen=True, eq=False)
class Allowance:
    """What rounding explains in one shot.

    `horizon` [s]: until when the shot can be predicted; inf: to its end. After it nothing is
        compared.
    `map_end` [s]: from when on no derivative exists, such as after collisions of a ball at one
        instant; inf: never. After it nothing but rounding that was never amplified is explained.
    `event_times` (m,) float64 [s]: by how much each event may come earlier or later; those after
        `map_end` by `UNAMPLIFIED`.
    `rest` (n,) float64 [m] or None: how far each ball may come to rest from where it did; None past
        the horizon.
    `source`: who says how far rounding displaces balls: the proof of the shot; where it isn't
        proved to its end, our engine alone; or nobody, where that can't play it either.
    `roundings`: errors that the engine may make at each event, over those of one rounding: those of
        all its steps, if it has a time step.
    """

    horizon: float
    map_end: float
    event_times: FloatArray
    rest: FloatArray | None
    source: Literal["proof", "engine", "nothing"] = "engine"
    roundings: float = ROUNDINGS

    @property
    def account(self) -> str:
        """Where this allowance comes from, in a sentence."""
        return f"the allowance for rounding is from {_SOURCES[self.source]}"


def allowance(played: Played) -> Allowance:
    """Return what rounding explains in a run of an engine, ours or another."""
    record = played.record
    scene = record.load_scene()
    if record.label == OURS:
        return allowance_of(scene)
    step = step_of(make_engine(record.label))
    # Its own count of its steps would widen its allowance without bound.
    steps = 0.0 if step is None else (record.rest_time or 0.0) / step
    return allowance_of_other(scene, played.log().events, steps)


def allowance_of(scene: Scene, roundings: float = ROUNDINGS) -> Allowance:
    """Run a shot on our engine, and return what rounding explains in it.

    `roundings`: as in `Allowance`.

    The deviation of an event's instant is 2^-53 times the root mean square of what rounding the
    state at each event before it does (`Result.rounding`), that of a position likewise
    (`CertifiedGrowth.sizes`). An engine that doesn't lose digits stays within 32 of them, as every
    proof grades; two such runs are within 64 of each other.
    """
    error = roundings * UNIT_ROUNDOFF
    least = 2.0 * error  # two runs, each within it of the true shot, on both its sides
    unamplified = UNAMPLIFIED * roundings / ROUNDINGS
    result = run_ours(scene)
    times = events_of(result)["t"].astype(np.float64)
    with np.errstate(over="ignore", invalid="ignore"):
        shifts = np.sqrt(np.mean(np.square(result.rounding.event_shifts), axis=1))
    own = RunGrowth(result)
    growth: Growth = own
    proof, _ = proof_of(scene)
    proved = proof is not None and proof.proved and is_differentiated(scene)
    if proof is not None and proved:
        growth = growth_of_proof(scene, proof)
    predictable = horizon(growth, TOLERANCE, error)
    map_end = min(own.derivative_ends, growth.derivative_ends)
    if proved:
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
        predictable, map_end, tolerances, rest, "proof" if proved else "engine", roundings
    )


def allowance_of_other(scene: Scene, events: Events, steps: float = 0.0) -> Allowance:
    """Return what rounding explains in a shot that another engine than ours played.

    `events`: of its run.
    `steps`: how many time steps the engine made. Each of them rounds the state once; at the worst
    all of them the same way.

    Its errors grow as those of the true shot do, as long as it plays that one: so its events are
    allowed what ours are that they correspond to. Those that correspond to none are allowed
    roundings that nothing amplifies.
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
    """Return from which event on our engine's growth isn't the proof's any more [s]; inf: never.

    Looked at amid two events, per ball, the largest until then: the run's own events may come a
    little sooner or later than the proved ones, so it may be one look ahead.
    """
    starts = np.unique(np.append(0.0, times))
    looks = np.append(0.5 * (starts[:-1] + starts[1:]), starts[-1])
    ours, right = (
        np.maximum.accumulate(sizes, axis=0) for sizes in (own.sizes(looks), growth.sizes(looks))
    )
    beyond = np.flatnonzero((ours[:-1] > OFF_BY * right[1:]).any(axis=1))
    return float(starts[beyond[0]]) if len(beyond) else math.inf
