"""Trials of the pressure of hard discs, from their collisions: against the literature."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import EventKind, Result, Scene, UnsupportedSceneError
from ghostball.engine.scene import POOL_BALL_RADIUS as RADIUS
from ghostball.reference_adapters import ReferenceEngine
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.stress.gas import begun_at_end, collision_rate, gas, literature, places_of
from ghostball.validation.stress.judges import is_exact
from ghostball.validation.stress.trial import Trial, Verdict, play

LAYERS = 10.0 * RADIUS
"""How far from a cushion the gas is as in the middle [m]: five diameters."""

BLOCKS = 20
"""Parts of a run from whose scatter the error of its pressure is estimated."""

MIXING = 30.0
"""Collisions of each disc before its gas is measured; a tenth for engines that step."""

SIGMAS = 4.0
"""Standard errors that a pressure may be off."""

FINEST, COARSEST = 0.005, 0.05
"""The standard error, relative, that our engine's run must have; and another's."""


@dataclass(frozen=True)
class PressureTrial(Trial):
    """The equation of state of hard discs at one packing, against the literature.

    Attributes
    ----------
    name : str
    packing : float
    rows, stepped_rows : int
        Of rows x rows balls, for our engine and for any other.
    collisions, stepped : int
        0: engines that step aren't asked.
    """

    name: str
    packing: float
    rows: int
    collisions: int
    stepped_rows: int
    stepped: int

    limit: ClassVar[float] = 400.0

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Mix the gas, then measure block by block.

        Ours in a run for each block, which bounds what is recorded; others in one.
        """
        if engine.name != OURS:
            return self._in_one_run(engine)
        rate = collision_rate(self.rows**2, self.packing)
        scene = gas(self.rows, self.packing, MIXING * self.rows**2 / rate)
        result = play(engine, scene, "rest")
        parts: list[tuple[float, float, float, float, float]] = []
        while len(parts) < BLOCKS and isinstance(result, Result):
            result = play(engine, begun_at_end(result, self.collisions / rate / BLOCKS))
            if isinstance(result, Result):
                parts.append(middle_of(result, 0.0, result.rest_time))
        if isinstance(result, Verdict):
            return result
        return judge_pressure(scene, np.array(parts), FINEST, speeds=is_exact(result))

    def _in_one_run(self, engine: ReferenceEngine) -> Verdict:
        if not self.stepped:
            wanted = f"{self.collisions} collisions, too many for one that steps through time"
            raise UnsupportedSceneError(engine.name, (wanted,))
        rate = collision_rate(self.stepped_rows**2, self.packing)
        mixed = MIXING / 10.0 * self.stepped_rows**2 / rate
        scene = gas(self.stepped_rows, self.packing, mixed + self.stepped / rate)
        result = play(engine, scene)
        if isinstance(result, Verdict):
            return result
        marks = np.linspace(mixed, result.rest_time, BLOCKS + 1).tolist()
        parts = [middle_of(result, begin, end) for begin, end in pairwise(marks)]
        return judge_pressure(scene, np.array(parts), COARSEST, speeds=is_exact(result))

    def examples(self) -> Iterable[Scene]:
        """Yield the gas."""
        yield gas(self.rows, self.packing, 1.0)


def middle_of(result: Result, begin: float, end: float) -> tuple[float, float, float, float, float]:
    """Return what a run says of the middle of its table between two instants [s].

    Discs times seconds, seconds, collisions, the sum of their speeds of approach [m/s], and the
    temperature k T [J] times the seconds.
    """
    assert result.events is not None
    table = result.scene.table
    assert table is not None
    low, high = LAYERS, table.length - LAYERS
    states = result.sample(np.linspace(begin, end, 40, endpoint=False))
    places = states.positions[:, :, :2]
    discs = np.mean(np.sum(np.all((places > low) & (places < high), axis=2), axis=1))
    events = result.events
    hits = events[
        (events["kind"] == EventKind.BALL_BALL) & (events["t"] >= begin) & (events["t"] < end)
    ]
    a, va = places_of(result, hits["a"].astype(np.int64), hits["t"])
    b, vb = places_of(result, hits["b"].astype(np.int64), hits["t"])
    inside = np.all((0.5 * (a + b) > low) & (0.5 * (a + b) < high), axis=1)
    apart = (b - a)[inside]
    speeds = np.sum((vb - va)[inside] * apart, axis=1) / np.hypot(*apart.T)
    temperature = 0.5 * float(np.mean(np.sum(states.velocities**2, axis=2)))  # of 1 kg
    seconds = end - begin
    return (
        float(discs) * seconds,
        seconds,
        float(np.count_nonzero(inside)),
        float(np.sum(np.abs(speeds))),
        temperature * seconds,
    )


def judge_pressure(
    scene: Scene, parts: NDArray[np.float64], finest: float, *, speeds: bool
) -> Verdict:
    """Judge the pressure that some parts of a run say.

    Parameters
    ----------
    scene : Scene
    parts : (blocks, 5) float64
        As of `middle_of`.
    finest : float
        The standard error, relative, that the pressure must have.
    speeds : bool
        Whether the run says how fast balls approach when they hit, and that is judged too.

    Notes
    -----
    By the virial theorem p / (n k T) is 1 + the sum over collisions of m v_n d / (2 N k T t), for
    those in the middle and the discs there. Engines that step say when balls hit, but no speed at
    that instant, so that for v_n its mean over collisions of discs with Maxwell's velocities,
    sqrt(pi k T / m), is taken; an exact engine's own mean, in units of that, must be 1, by as many
    standard errors. Errors are those of the jackknife over blocks, of the difference from the
    literature at the density found, and of this mean.
    """
    table = scene.table
    assert table is not None
    area = (table.length - 2.0 * LAYERS) ** 2

    def off(some: NDArray[np.float64]) -> tuple[float, float, float]:
        discs, seconds, hits, _, heat = some.sum(axis=0).tolist()
        temperature = heat / seconds
        packing = discs / seconds / area * math.pi * RADIUS**2
        state = 1.0 + hits * RADIUS * math.sqrt(math.pi / temperature) / discs
        return state - literature(packing)[0], state, packing

    difference, state, packing = off(parts)
    error = _jackknife([off(np.delete(parts, k, axis=0))[0] for k in range(len(parts))])
    right, unsure = literature(packing)
    permitted = SIGMAS * math.hypot(error, unsure)
    faults = []
    if not abs(difference) <= permitted:
        faults.append(
            f"p/nkT is {state:.5g} at packing {packing:.4f}, {right:.5g} in the literature: "
            f"{difference / error:+.3g} standard errors"
        )
    if not error <= finest * right:
        faults.append(f"the error is {error / right:.2g} of p/nkT, at most {finest:g}")
    nearest = abs(difference) / permitted
    speed = None
    if speeds:
        speed = _approach_speed(parts)
        left_out = (np.delete(parts, k, axis=0) for k in range(len(parts)))
        scatter = _jackknife([_approach_speed(some) for some in left_out])
        nearest = max(nearest, abs(speed - 1.0) / (SIGMAS * scatter))
        if not abs(speed - 1.0) <= SIGMAS * scatter:
            faults.append(
                f"balls that hit approach at {speed:.5g} of the mean that Maxwell's velocities "
                f"have: {(speed - 1.0) / scatter:+.3g} standard errors"
            )
    values = {
        "approach_speed": speed,
        "packing": packing,
        "state": state,
        "error": error,
        "literature": right,
        "literature_error": unsure,
        "collisions": int(parts[:, 2].sum()),
    }
    return Verdict.of(scene, faults, nearest, values)


def _approach_speed(parts: NDArray[np.float64]) -> float:
    """Return the mean speed of approach over Maxwell's, sqrt(pi k T / m); NaN without a hit."""
    _, seconds, hits, speeds, heat = parts.sum(axis=0).tolist()
    return speeds / hits / math.sqrt(math.pi * heat / seconds) if hits else math.nan


def _jackknife(values: list[float]) -> float:
    """Return the standard error from what is left with each block left out."""
    n = len(values)
    return math.sqrt((n - 1) / n * float(np.sum((np.array(values) - np.mean(values)) ** 2)))
