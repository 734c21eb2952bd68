"""Long runs: millions of collisions, of a gas and of Galperin's balls.

Our engine is asked for all of it. An engine that steps through time would take hours: it is asked
for the same with fewer collisions, as many as each trial states.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from mpmath import mp, workdps

from ghostball.model import (
    POOL_BALL_RADIUS as RADIUS,
    Ball,
    Result,
    Scene,
    Table,
    UnsupportedSceneError,
)
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters import ReferenceEngine
from ghostball.reference_adapters.base import resolution_of
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.grading.tolerances import EPS
from ghostball.validation.stress.gas import (
    ICE,
    begun_at_end,
    collision_rate,
    gas,
    kinetic_energy,
    patient,
    stray_momentum,
)
from ghostball.validation.stress.invariants import is_exact, overlap_limit, overlaps, solver_noise
from ghostball.validation.stress.trial import Family, Suite, Trial, Verdict, play

SEGMENT = 20_000
"""Collisions of a gas that are recorded at once; the next run begins where this one ended."""

LOOK = 0.02
"""Time between two looks at whether balls overlap [s]: of two that pass through each other in the
middle at up to 2.8 m/s, most of the gas's speeds, at least one look sees it."""

DRIFT = 16.0
"""Standard deviations, or nearly, of the rounding of energy and momentum that are permitted.

Each collision rounds the speeds of two balls of N by some EPS / 2, either way: EPS / N of the
energy, and as a random walk sqrt(n) times that after n. A law that is off by one rounding to the
same side in each collision is beyond that after some hundred of them. Of engines that step the law
judges energy and overlaps.
"""


@dataclass(frozen=True)
class GasTrial(Trial):
    """An elastic gas for a number of collisions, every one recorded.

    `rows`: of rows x rows balls.
    `packing`: part of the table that they cover.
    `collisions`, `stepped`: of our engine, and of any other.
    `unbroken`: whether it is one run, of which the end alone is kept; else it is cut into runs of
        some `SEGMENT` collisions, each recorded and looked at whole.
    """

    name: str
    rows: int
    packing: float
    collisions: int
    stepped: int
    unbroken: bool = False

    limit: ClassVar[float] = 400.0

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
            result = play(engine, scene, "rest" if ours and self.unbroken else "trajectory")
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
    exact: bool = True
    collisions: int = 0
    energy: float = 0.0
    first_energy: float = 0.0
    stray: list[tuple[float, float]] = field(default_factory=list)
    deepest: float = -math.inf
    slack: float = 0.0

    def add(self, result: Result) -> None:
        """Look at the next part of the run."""
        if not self.first_energy:
            self.first_energy = kinetic_energy(result, at_start=True)
        self.collisions += sum(result.collision_counts.values())
        self.energy = kinetic_energy(result)
        stray = stray_momentum(result)
        if stray is not None:
            self.stray.append(stray)
        recorded = result.trajectory is not None
        self.exact = is_exact(result) or not recorded  # our engine's alone isn't
        first = 0 if self.exact else 1  # of one that steps the law judged how deep balls overlap
        for places in _looks(result) if recorded else [result.final_state.positions]:
            deepest = np.max(overlaps(result.scene, places)[:, first:])
            self.deepest = float(np.maximum(self.deepest, deepest))  # NaN stays
        if not self.exact:
            self.slack = overlap_limit(result, result.final_state.positions)
            return
        # A place is where a ball last hit, its velocity times the time since: of the clock, too.
        table = self.scene.table
        assert table is not None
        speed = float(np.max(np.abs(result.final_state.velocities)))
        self.slack = max(self.slack, 8.0 * EPS * (table.length + speed * result.rest_time))

    def verdict(self) -> Verdict:
        """Judge all of it."""
        n, balls = self.collisions, len(self.scene.balls)
        drift = abs(self.energy / self.first_energy - 1.0)
        # Of one that steps the law judged how its energy drifts.
        limit = DRIFT * EPS * math.sqrt(n) / balls if self.exact else math.inf
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
        return Verdict.of(self.scene, faults, max(ratios), values)


def _looks(result: Result) -> Iterator[FloatArray]:
    """Yield the positions of the balls at instants all through a run, some at once."""
    times = np.arange(0.0, result.rest_time, LOOK)
    for some in np.array_split(times, math.ceil(len(times) / 100)):
        yield result.sample(some).positions


@dataclass(frozen=True)
class GalperinTrial(Trial):
    """A light ball between a cushion and a heavy one: the collisions spell pi.

    `digits`: of pi after the point; the heavy ball has 100^digits times the mass.
    `stepped`: whether engines that step through time are asked.
    """

    name: str
    digits: int
    stepped: bool

    limit: ClassVar[float] = 400.0

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
        exact = resolution_of(engine, scene) == 0.0
        if not (exact or self.stepped):
            why = f"{wanted} collisions, too many for one that steps through time"
            raise UnsupportedSceneError(engine.name, (why,))
        result = play(patient(engine, 2 * wanted), scene, "rest")
        if isinstance(result, Verdict):
            return result
        found = sum(result.collision_counts.values())
        faults = [] if found == wanted else [f"{found} collisions instead of {wanted}"]
        # Each collision rounds the light ball's speed, at most 10^digits, and the heavy one's.
        limit = EPS * (wanted + 8) if exact else solver_noise()
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
        return Verdict.of(scene, faults, float(off) / limit, values)


def galperin(digits: int) -> tuple[int, float, float]:
    """Return how many collisions there are with masses 1 : 100^digits, and the end speeds [m/s].

    Of the light and the heavy ball, which came in at -1 m/s.

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


def _trials(suite: Suite) -> Iterator[Trial]:
    full = suite == "full"
    many = 10_000_000 if full else 100_000
    yield GasTrial(f"gas-{many}", 12, 0.5, many, 1_000 if full else 100)
    if full:
        yield GasTrial(f"gas-unbroken-{many}", 12, 0.5, many, 1_000, unbroken=True)
    for digits in range(8 if full else 6):
        yield GalperinTrial(f"galperin-{digits}", digits, stepped=digits <= 2)


FAMILY = Family(
    "long-runs",
    "Long runs: a gas, Galperin's pi",
    "10 million collisions of an elastic gas drift by no more than a random walk of roundings and "
    "never overlap; Galperin's balls collide as often as the digits of pi say, to 31 415 926. "
    "Engines that step are asked for some thousand collisions.",
    _trials,
)
