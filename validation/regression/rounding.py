"""How far two runs of one shot may differ by rounding alone, as our engine's tangent map says."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine import Scene
from engine.result.hashes import bits_hash
from engine.sensitivity import QUALITY, ROUNDING
from validation.our_run import run_ours
from validation.predictability.bifurcations import extent_of
from validation.sampling import events_of

FloatArray = NDArray[np.float64]

APART = 2.0 * QUALITY * ROUNDING
"""Two runs, each within `QUALITY` roundings at every event of the true shot, on both its sides."""

UNAMPLIFIED = 64.0 * 2.0 * ROUNDING
"""Relative difference that needs no tangent map to be called rounding: some sums of a few terms."""


@dataclass(frozen=True, eq=False)
class Allowance:
    """What rounding explains in one shot.

    Attributes
    ----------
    horizon : float [s]
        Until when the shot can be predicted; inf: to its end. After it nothing is compared.
    map_end : float [s]
        From when on no derivative exists, such as after collisions of a ball at one instant; inf:
        never. After it nothing but rounding that was never amplified is explained.
    event_times : (m,) float64 [s]
        By how much each event may come earlier or later; those after `map_end` by `UNAMPLIFIED`.
    rest : (n,) float64 [m] or None
        How far each ball may come to rest from where it did; None past the horizon.
    bits : str
        Hash of the run that all this is of.
    """

    horizon: float
    map_end: float
    event_times: FloatArray
    rest: FloatArray | None
    bits: str


def allowance_of(scene: Scene) -> Allowance:
    """Run a shot on our engine, and return what rounding explains in it.

    Notes
    -----
    The deviation of an event's instant is 2^-53 times the root mean square of what rounding the
    state at each event before it does (`Result.rounding`), that of a position likewise
    (`Result.sensitivity`). An engine that doesn't lose digits stays within 32 of them, as every
    proof grades; two such runs are within 64 of each other.
    """
    result = run_ours(scene)
    times = events_of(result)["t"].astype(np.float64)
    with np.errstate(over="ignore", invalid="ignore"):
        shifts = np.sqrt(np.mean(np.square(result.rounding.event_shifts), axis=1))
        growth = result.sensitivity([result.rest_time])[0]
    horizon, map_end = result.horizon(), math.inf
    if math.isfinite(horizon) and not np.isfinite(result.sensitivity([horizon])).all():
        horizon, map_end = math.inf, horizon
    plain = UNAMPLIFIED * np.maximum(times, extent_of(scene))
    known = np.isfinite(shifts) & (times < map_end)
    tolerances = np.where(known, APART * np.where(known, shifts, 0.0) + UNAMPLIFIED * times, plain)
    rest = None
    if math.isinf(horizon):
        smallest = UNAMPLIFIED * extent_of(scene)
        rest = APART * np.where(np.isfinite(growth), growth, 0.0) + smallest
    return Allowance(
        horizon, map_end, tolerances, rest, bits_hash(events_of(result), result.rest_positions)
    )
