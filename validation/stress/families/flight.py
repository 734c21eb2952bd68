"""Flight: balls that jump, drop and bounce; what must hold in space whatever the shot."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ghostball.engine import Ball, EventKind, Physics, Result, Scene, Status
from ghostball.engine.core.tolerances import EPS, LOWEST_HOP, MOTION_ERROR
from ghostball.engine.trajectory import Phase, energy_of
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.runs.steps import with_setting
from ghostball.validation.stress.families.graded import BATCH, ProvedShots
from ghostball.validation.stress.family import Family
from ghostball.validation.stress.judges import energy_rise, gap_rounding, rise_limit, unsolved
from ghostball.validation.stress.random_jumps import random_jump
from ghostball.validation.stress.sound import telling_instants
from ghostball.validation.stress.trial import (
    SceneTrial,
    Suite,
    Trial,
    Verdict,
    graded_severity,
    play,
)

MOST_EVENTS = 100_000
"""Events and contact steps of a random shot: ten times what a ball takes that is dropped exactly on
top of another, and hops there for a second before it falls off."""

SUNK = 4.0 * LOWEST_HOP
"""Overlap, in diameters, of what is pressed together in flight: it hops instead of being held."""

R = Ball(id="any", position=(0.0, 0.0)).radius
G = 9.81
_FLIES = Physics(preset="pool", airborne=True, table_restitution=0.5)


@dataclass(frozen=True)
class SoundInSpace:
    """Whether a run in which balls fly is possible at all; and whether two balls meet in it.

    Attributes
    ----------
    meets : bool or None
        Whether two balls meet; None where that isn't asked.
    """

    meets: bool | None = None

    def __call__(self, result: Result) -> Verdict:
        """Judge a run, recorded as a trajectory."""
        found = measured(result)
        faults = [
            f"{name} of {value:.3g}, at most {limit:.3g}"
            for name, (value, limit) in found.items()
            if not value <= limit  # nor where it is NaN
        ]
        assert result.events is not None
        met = bool(np.any(result.events["kind"] == EventKind.BALL_BALL))
        if self.meets is not None and met != self.meets:
            faults.append("two balls meet that don't" if met else "a ball goes through another")
        nearest = max(value / limit for value, limit in found.values() if limit > 0.0)
        return Verdict.of(
            result.scene, faults, nearest, {name: value for name, (value, _) in found.items()}
        )


def measured(result: Result) -> dict[str, tuple[float, float]]:
    """Return what is measured of a run: by its name, its value and the most that it may be."""
    scene = result.scene
    times = telling_instants(result)
    states = result.sample(times)
    here = result.phases(times) != Phase.GONE
    places, radii = states.positions, scene.radii
    rounding = gap_rounding(scene, places)
    sunk = rounding + SUNK * 2.0 * float(radii.max())
    found = {"depth in the table [m]": (float((radii - places[:, :, 2]).max()), rounding)}
    first, second = np.triu_indices(len(radii), 1)
    if len(first):
        apart = np.linalg.norm(places[:, first] - places[:, second], axis=2)
        depth = np.where(here[:, first] & here[:, second], radii[first] + radii[second] - apart, -1)
        found["overlap of balls [m]"] = (float(depth.max()), sunk)
    if scene.table is not None:
        x, y = places[:, :, 0], places[:, :, 1]
        above = places[:, :, 2] - scene.physics.cushion_height
        for away in (x, scene.table.length - x, y, scene.table.width - y):
            depth = np.where(here, radii - np.hypot(np.maximum(away, 0.0), above), -1)
            before = found.get("overlap of ball and nose [m]", (-1.0, sunk))[0]
            found["overlap of ball and nose [m]"] = (max(float(depth.max()), before), sunk)
    energy = energy_of(scene, states).total
    # Hops of balls that lie on others lose nothing, so that the roundings of many add up, by chance
    # half a spacing of doubles each, sqrt(n) / 2 of n together, and four times as much isn't seen.
    # A height is recorded as that of the centre, and rounded so: half a spacing at each of two
    # instants. And a contact step errs by `MOTION_ERROR` of the velocities, so by twice that of the
    # energy, at each of two instants.
    limit = rise_limit(result) + 2.0 * EPS * math.sqrt(result.work["events"])
    if energy[0] > 0.0:
        weights = scene.physics.gravity * scene.masses
        limit += EPS * float(weights @ places[:, :, 2].max(axis=0)) / float(energy[0])
    limit += 4.0 * MOTION_ERROR if result.work.get("contact_steps") else 0.0
    found["rise of the energy [1]"] = (energy_rise(energy), limit)
    if result.status is Status.REST:
        last = result.sample([result.rest_time])
        on_cloth = result.phases(np.array([result.rest_time]))[0] != Phase.GONE
        above = np.where(on_cloth, np.abs(last.positions[0, :, 2] - radii), 0.0)
        found["height of a ball at rest over the cloth [m]"] = (float(above.max()), rounding)
    found["contact steps or joint impacts left unsolved"] = (float(unsolved(result)), 0.0)
    return found


@dataclass(frozen=True)
class Lands:
    """Whether the last landing of each ball is where the series of its bounces ends.

    To 1e-14 of that time for each landing; and balls that are let go together land together.

    Attributes
    ----------
    ends : float [s]
        When the last bounce of each ends.
    """

    ends: float

    def __call__(self, result: Result) -> Verdict:
        """Judge a run, recorded as a trajectory."""
        assert result.events is not None
        landings = result.events[result.events["kind"] == EventKind.BALL_CLOTH]
        faults = []
        off = 0.0
        for i in range(len(result.scene.balls)):
            last = float(landings["t"][landings["a"] == i].max(initial=0.0))
            off = max(off, abs(last / self.ends - 1.0))
        if len(np.unique(landings["t"])) * len(result.scene.balls) != len(landings):
            faults.append("balls that land at one instant land at several")
        limit = 1e-14 * max(len(landings), 1)
        if not off <= limit:
            faults.append(f"bounces end off by {off:.3g} of their time {self.ends:.6g} s")
        return Verdict.of(result.scene, faults, off / limit, {"off": off})


def over_the_top(depth: float, turn: float) -> Scene:
    """Return a jump whose apex is above a resting ball, `depth` diameters nearer than a touch.

    At 1 m/s, fast enough for the path to be nearest there: 2 R g < v^2.
    """
    speed, before = 1.0, 0.1
    c, s = math.cos(turn), math.sin(turn)
    top = 3.0 * R - 2.0 * R * depth
    way = speed * before
    return Scene(
        name=f"over-top-{depth:g}-{turn:g}",
        physics=_FLIES,
        balls=[
            Ball(
                id="cue",
                position=(-c * way, -s * way, top - 0.5 * G * before * before),
                velocity=(speed * c, speed * s, G * before),
                angular_velocity=(0.0, 0.0, 0.0),
            ),
            Ball(id="object", position=(0.0, 0.0)),
        ],
        t_max=1.2 * before,
    )


def on_top(aside: float, restitution: float, drop: float) -> Scene:
    """Return a ball that falls on another, `aside` radii from its middle."""
    return Scene(
        name=f"on-top-{aside:g}-{restitution:g}-{drop:g}",
        physics=_FLIES.model_copy(update={"ball_restitution": restitution}),
        balls=[
            Ball(id="below", position=(0.0, 0.0)),
            Ball(id="above", position=(aside * R, 0.0, 3.0 * R + drop)),
        ],
    )


def endless(count: int, restitution: float, drop: float) -> Scene:
    """Return balls that are let go at one instant, from one height."""
    return Scene(
        name=f"endless-{count}-{restitution:g}-{drop:g}",
        physics=_FLIES.model_copy(update={"table_restitution": restitution}),
        balls=[Ball(id=f"b{i}", position=(0.25 * i, 0.0, R + drop)) for i in range(count)],
    )


@dataclass(frozen=True)
class Jumps(Trial):
    """Random shots with flight in a row, by number.

    Attributes
    ----------
    name : str
    first, count : int
    """

    name: str
    first: int
    count: int

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Play the shots and judge each."""
        if "max_events" in type(engine.settings).model_fields:
            engine = with_setting(engine, "max_events", MOST_EVENTS)
        faults: list[str] = []
        worst: tuple[float, Scene | None] = (-1.0, None)
        broken = 0
        most: dict[str, Any] = {}
        for number in range(self.first, self.first + self.count):
            scene = random_jump(number)
            played = play(engine, scene)
            verdict = played if isinstance(played, Verdict) else SoundInSpace()(played)
            faults += [f"{scene.name}: {fault}" for fault in verdict.faults]
            broken += verdict.broken
            for name, value in verdict.values.items():
                most[name] = max(value, most.get(name, value))
            if verdict.severity > worst[0]:
                worst = (verdict.severity, scene)
        severity = graded_severity(worst[0], bool(broken))
        return Verdict(tuple(faults), worst[1], severity, self.count, broken, most)

    def examples(self) -> Iterator[Scene]:
        """Yield shots with every variant of the kernels that is needed."""
        yield from map(random_jump, range(self.first, self.first + min(self.count, 40)))


def _trials(suite: Suite) -> Iterator[Trial]:
    finest = 10 if suite == "full" else 6
    for depth in [s * 10.0**-k for k in range(1, finest) for s in (1.0, -1.0)]:
        for turn in (0.0, 0.7) if suite == "quick" else (0.0, 0.3, 0.7, 2.0):
            scene = over_the_top(depth, turn)
            yield SceneTrial(scene.name, scene, SoundInSpace(meets=depth > 0.0))
    for aside in (0.0, 1e-13, 1e-6, 0.5, 1.5):
        for restitution in (0.0, 0.95, 1.0):
            for drop in (0.1,) if suite == "quick" else (0.1, 1e-3, 1e-7):
                scene = on_top(aside, restitution, drop)
                yield SceneTrial(scene.name, scene, SoundInSpace(meets=True))
    for restitution in (0.0, 0.3, 0.6, 0.9, 0.99):
        for count in (1, 2):
            scene = endless(count, restitution, 0.1)
            first = math.sqrt(2.0 * 0.1 / G)
            ends = first * (1.0 + restitution) / (1.0 - restitution)
            yield SceneTrial(scene.name, scene, Lands(ends))
    size, chunks = (100, 2) if suite == "quick" else (500, 20)
    for start in range(0, size * chunks, size):
        yield Jumps(f"jumps-{start:05d}-{start + size - 1:05d}", start, size)
    count = 30 if suite == "quick" else 300
    for start in range(0, count, BATCH):
        yield ProvedJumps(f"proved-jumps-{start:03d}-{start + BATCH - 1:03d}", start, BATCH)


@dataclass(frozen=True)
class ProvedJumps(ProvedShots):
    """Random jumps from one number on, each graded against its proof, as far as that goes."""

    def shot(self, number: int) -> Scene:
        """Return the jump of a number."""
        return random_jump(number)

    def least(self, scene: Scene) -> int | None:  # noqa: ARG002 - the same for all
        """Return how many events must be proved: one. Where balls come to lie, proofs end."""
        return 1


FAMILY = Family(
    "flight",
    "Balls that fly",
    "A jump clears a ball or clips its top, down to 1e-10 of a diameter; a ball "
    "that falls on another, however near to its middle, comes off it; endless bounces end when "
    "their series does, of balls that land at one instant too; and random jumps, drops and breaks "
    f"come to rest within {MOST_EVENTS} events and contact steps, through no ball, nose or table, "
    "and gain no energy. The first of them have the events that are proved, and no others, as far "
    "as that goes.",
    _trials,
    ours_alone=True,
)
