"""Long runs: millions of collisions, of a gas, of Galperin's balls, and for an equation of state.

Our engine is asked for all of it. An engine that steps through time would take hours: it is asked
for the same with fewer collisions, as many as each trial states.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from mpmath import mp, workdps
from numpy.typing import NDArray

from engine import Ball, EventKind, Result, Scene, Table, UnsupportedSceneError
from engine._tolerances import EPS
from engine.scene import POOL_BALL_RADIUS as RADIUS
from reference_adapters import ReferenceEngine
from reference_adapters.base import resolution_of
from reference_adapters.registry import OURS
from validation.stress.family import Family
from validation.stress.gas import (
    ICE,
    FloatArray,
    begun_at_end,
    collision_rate,
    gas,
    kinetic_energy,
    literature,
    patient,
    places_of,
    stray_momentum,
)
from validation.stress.judges import overlaps
from validation.stress.trial import Suite, Trial, Verdict, play

SEGMENT = 20_000
"""Collisions of a gas that are recorded at once; the next run begins where this one ended."""

LOOK = 0.02
"""Time between two looks at whether balls overlap [s]: of two that pass through each other in the
middle at up to 2.8 m/s, most of the gas's speeds, at least one look sees it."""

DRIFT = 16.0
"""Standard deviations, or nearly, of the rounding of energy and momentum that are permitted.

Each collision rounds the speeds of two balls of N by some EPS / 2, either way: EPS / N of the
energy, and as a random walk sqrt(n) times that after n. A law that is off by one rounding to the
same side in each collision is beyond that after some hundred of them.
"""


@dataclass(frozen=True)
class GasTrial(Trial):
    """An elastic gas for a number of collisions, every one recorded.

    Attributes
    ----------
    name : str
    rows : int
        Of rows x rows balls.
    packing : float
        Part of the table that they cover.
    collisions, stepped : int
        Of our engine, and of any other.
    unbroken : bool
        Whether it is one run, of which the end alone is kept; else it is cut into runs of some
        `SEGMENT` collisions, each recorded and looked at whole.
    """

    name: str
    rows: int
    packing: float
    collisions: int
    stepped: int
    unbroken: bool = False

    limit: ClassVar[float] = 400.0
    small: ClassVar[bool] = False

    @property
    def _rate(self) -> float:
        return collision_rate(self.rows**2, self.packing)

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Run it part by part; judge energy, momentum and overlaps."""
        ours = engine.name == OURS
        wanted = self.collisions if ours else self.stepped
        some = wanted if self.unbroken else min(wanted, SEGMENT)
        # A tenth more than the theory says: the grid that it starts from takes time to dissolve.
        scene = gas(self.rows, self.packing, 1.1 * some / self._rate)
        engine = patient(engine, 4 * some)
        seen = _Seen(scene)
        while seen.collisions < wanted:
            result = play(engine, scene, "rest" if self.unbroken else "trajectory")
            if isinstance(result, Verdict):
                return result
            if not sum(result.collision_counts.values()):
                return Verdict.of(scene, [f"no collision in {scene.t_max:.3g} s of a gas"])
            seen.add(result)
            if not ours:
                break  # where it ends balls may overlap, and no gas begins: one run must do
            if seen.collisions < wanted:
                scene = begun_at_end(result, some / self._rate)
        return seen.verdict()

    def examples(self) -> Iterable[Scene]:
        """Yield the gas."""
        yield gas(self.rows, self.packing, 1.0)


@dataclass
class _Seen:
    """What was seen of a gas so far."""

    scene: Scene
    collisions: int = 0
    energy: float = 0.0
    first_energy: float = 0.0
    stray: list[tuple[float, float]] = field(default_factory=list)
    deepest: float = -math.inf
    slack: float = 0.0
    curve: list[tuple[int, float]] = field(default_factory=list)

    def add(self, result: Result) -> None:
        """Look at the next part of the run."""
        if not self.first_energy:
            self.first_energy = kinetic_energy(result, at_start=True)
        self.collisions += sum(result.collision_counts.values())
        self.energy = kinetic_energy(result)
        self.curve.append((self.collisions, self.energy / self.first_energy - 1.0))
        stray = stray_momentum(result)
        if stray is not None:
            self.stray.append(stray)
        recorded = result.trajectory is not None
        for places in _looks(result) if recorded else [result.final_state.positions]:
            self.deepest = max(self.deepest, float(np.max(overlaps(result.scene, places))))
        # A place is where a ball last hit, its velocity times the time since: of the clock, too.
        table = self.scene.table
        assert table is not None
        speed = float(np.max(np.abs(result.final_state.velocities)))
        self.slack = max(self.slack, 8.0 * EPS * (table.length + speed * result.rest_time))

    def verdict(self) -> Verdict:
        """Judge all of it."""
        n, balls = self.collisions, len(self.scene.balls)
        drift = abs(self.energy / self.first_energy - 1.0)
        limit = DRIFT * EPS * math.sqrt(n) / balls
        ratios = [drift / limit, self.deepest / self.slack]
        faults = []
        if not drift <= limit:
            faults.append(f"energy drifts by {drift:.3g} in {n} collisions, at most {limit:.3g}")
        if not self.deepest <= self.slack:
            faults.append(f"balls overlap by {self.deepest:.3g} m, at most {self.slack:.3g} m")
        values: dict[str, Any] = {
            "collisions": n,
            "energy_drift": drift,
            "overlap": self.deepest,
            "curve": _thinned(self.curve),
        }
        if self.stray:
            speed = math.sqrt(2.0 * self.first_energy)  # of all mass
            momentum = math.hypot(*(math.fsum(part) for part in zip(*self.stray, strict=True)))
            momentum /= speed * math.sqrt(balls)
            values["stray_momentum"] = momentum
            ratios.append(momentum / limit)
            if not momentum <= limit:
                faults.append(
                    f"{momentum:.3g} of the momentum comes from nowhere, at most {limit:.3g}"
                )
        severity = min(max(*ratios, 0.0), 1e6)
        return Verdict(
            tuple(faults),
            self.scene,
            max(severity, 1.0) if faults else min(severity, 0.999),
            1,
            int(bool(faults)),
            values,
        )


def _looks(result: Result) -> Iterator[FloatArray]:
    """Yield the positions of the balls at instants all through a run, some at once."""
    times = np.arange(0.0, result.rest_time, LOOK)
    for some in np.array_split(times, math.ceil(len(times) / 100)):
        yield result.sample(some).positions


def _thinned(curve: list[tuple[int, float]], most: int = 200) -> list[list[float]]:
    """Return at most so many points of a curve, evenly, with both ends."""
    rows = np.unique(np.linspace(0, len(curve) - 1, min(most, len(curve))).round().astype(int))
    return [[curve[row][0], curve[row][1]] for row in rows]


@dataclass(frozen=True)
class GalperinTrial(Trial):
    """A light ball between a cushion and a heavy one: the collisions spell pi.

    Attributes
    ----------
    name : str
    digits : int
        Of pi after the point; the heavy ball has 100^digits times the mass.
    stepped : bool
        Whether engines that step through time are asked.
    """

    name: str
    digits: int
    stepped: bool

    limit: ClassVar[float] = 400.0
    small: ClassVar[bool] = False

    @property
    def scene(self) -> Scene:
        """The shot; on the middle line of a table 1 m wide, where no y is rounded."""
        return Scene(
            name="galperin",
            t_max=5.0,
            physics=ICE,
            table=Table(length=2.0, width=1.0, cushions=("left",)),
            balls=[
                Ball(id="light", position=(0.5 + RADIUS, 0.5), mass=1.0),
                Ball(
                    id="heavy",
                    position=(1.0 + 3.0 * RADIUS, 0.5),
                    velocity=(-1.0, 0.0),
                    mass=100.0**self.digits,
                ),
            ],
        )

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Count; compare with how often a straight line crosses the mirrors of a wedge."""
        scene = self.scene
        wanted, light, heavy = galperin(self.digits)
        if engine.name != OURS and not (self.stepped or resolution_of(engine, scene) == 0.0):
            why = f"{wanted} collisions, too many for one that steps through time"
            raise UnsupportedSceneError(engine.name, (why,))
        result = play(patient(engine, 2 * wanted), scene, "rest")
        if isinstance(result, Verdict):
            return result
        found = sum(result.collision_counts.values())
        faults = [] if found == wanted else [f"{found} collisions instead of {wanted}"]
        # Each collision rounds the light ball's speed, at most 10^digits, and the heavy one's.
        limit = EPS * (wanted + 8)
        v = result.final_state.velocities[0, :, 0]
        scale = 10.0**self.digits
        off = max(abs(v[0] - light) / scale, abs(v[1] - heavy))
        if not off <= limit:
            faults.append(
                f"the end speeds are off by {off:.3g} of the largest, {limit:.3g} at most"
            )
        drift = kinetic_energy(result) / kinetic_energy(result, at_start=True) - 1.0
        if not abs(drift) <= 2.0 * limit:
            faults.append(f"energy drifts by {drift:.3g}, at most {2.0 * limit:.3g}")
        values = {"collisions": found, "speed_error": float(off), "energy_drift": drift}
        return Verdict.of(scene, faults, min(float(off) / limit, 0.999), values)

    def examples(self) -> Iterable[Scene]:
        """Yield the shot."""
        yield self.scene


def galperin(digits: int) -> tuple[int, float, float]:
    """Return how many collisions there are with masses 1 : 100^digits, and the end speeds [m/s].

    Of the light and the heavy ball, which came in at -1 m/s.

    Notes
    -----
    Galperin 2003, Regular and Chaotic Dynamics 8(4) 375: with X = sqrt(M) x, Y = sqrt(m) y both are
    one point in a wedge of angle theta = atan(sqrt(m / M)), which unfolds into a straight line. It
    crosses a mirror ceil(pi / theta) - 1 times; folded back, its direction is pi less an even
    number of angles, or that many less pi.
    """
    with workdps(50):
        theta = mp.atan(mp.mpf(10) ** -digits)
        count = int(mp.ceil(mp.pi / theta)) - 1
        turned = count + count % 2
        direction = (mp.pi - count * theta) if count % 2 == 0 else (turned * theta - mp.pi)
        return count, float(mp.mpf(10) ** digits * mp.sin(direction)), float(mp.cos(direction))


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
    small: ClassVar[bool] = False

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Mix the gas, then measure block by block.

        Ours in a run for each block, which bounds what is recorded; others in one.
        """
        if engine.name != OURS:
            return self._in_one_run(engine)
        rate = collision_rate(self.rows**2, self.packing)
        scene = gas(self.rows, self.packing, MIXING * self.rows**2 / rate)
        result = play(engine, scene, "rest")
        parts = []
        while len(parts) < BLOCKS and isinstance(result, Result):
            result = play(engine, begun_at_end(result, self.collisions / rate / BLOCKS))
            if isinstance(result, Result):
                parts.append(middle_of(result, 0.0, result.rest_time))
        if isinstance(result, Verdict):
            return result
        return judge_pressure(scene, np.array(parts), FINEST)

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
        return judge_pressure(scene, np.array(parts), COARSEST)

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


def judge_pressure(scene: Scene, parts: NDArray[np.float64], finest: float) -> Verdict:
    """Judge the pressure that some parts of a run say, (blocks, 5) as of `middle_of`.

    Notes
    -----
    By the virial theorem p / (n k T) is 1 + the sum over collisions of m v_n d / (2 N k T t), for
    those in the middle and the discs there. Engines that step say when balls hit, but no speed at
    that instant, so that for v_n its mean over collisions of discs with Maxwell's velocities,
    sqrt(pi k T / m), is taken; values hold what it was, in units of that. Errors are those of the
    jackknife over blocks, of the difference from the literature at the density found.
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
    _, seconds, hits, speeds, heat = parts.sum(axis=0).tolist()
    values = {
        "approach_speed": speeds / hits / math.sqrt(math.pi * heat / seconds) if hits else None,
        "packing": packing,
        "state": state,
        "error": error,
        "literature": right,
        "literature_error": unsure,
        "collisions": int(parts[:, 2].sum()),
    }
    return Verdict.of(scene, faults, min(abs(difference) / permitted, 0.999), values)


def _jackknife(values: list[float]) -> float:
    """Return the standard error from what is left with each block left out."""
    n = len(values)
    return math.sqrt((n - 1) / n * float(np.sum((np.array(values) - np.mean(values)) ** 2)))


def _trials(suite: Suite) -> Iterator[Trial]:
    full = suite == "full"
    many = 10_000_000 if full else 100_000
    yield GasTrial(f"gas-{many}", 12, 0.5, many, 1_000 if full else 100)
    if full:
        yield GasTrial(f"gas-unbroken-{many}", 12, 0.5, many, 1_000, unbroken=True)
    for digits in range(8 if full else 6):
        yield GalperinTrial(f"galperin-{digits}", digits, stepped=digits <= 2)
    for tenths in range(1, 7) if full else (3,):
        packing = tenths / 10.0
        stepped = 2_500 if full and tenths == 3 else 0  # more would take them minutes each
        rows, wanted = (32, 1_000_000) if full else (24, 30_000)
        yield PressureTrial(f"pressure-at-{packing:g}", packing, rows, wanted, 16, stepped)


FAMILY = Family(
    "long-runs",
    "Long runs: a gas, Galperin's pi, the pressure of hard discs",
    "10 million collisions of an elastic gas drift by no more than a random walk of roundings and "
    "never overlap; Galperin's balls collide as often as the digits of pi say, to 31 415 926; hard "
    "discs have the pressure of the literature within 4 standard errors. Engines that step are "
    "asked for some thousand collisions.",
    _trials,
)
