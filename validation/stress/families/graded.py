"""Proofs: shots of all physics that can be proved, and how a run of each compares with its proof."""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import ClassVar

from engine import Ball, Physics, Result, Scene, Table
from reference_adapters import ReferenceEngine
from reference_adapters.certified import CertifiedSettings, certify
from validation.faults import faults_of
from validation.grading import grade
from validation.library import find_scene
from validation.random_shots import random_shot
from validation.stress.family import Family
from validation.stress.trial import SceneTrial, Suite, Trial, Verdict, play

PROOF = CertifiedSettings(max_events=5_000)
"""How far a shot is proved: a few elastic ones have thousands of events."""

SHIPPED = (
    "stop",
    "head-on",
    "half-ball-cut",
    "three-ball-chain",
    "wall-bounce",
    "restitution-cut",
    "unequal-balls",
    "corner-double-bounce",
    "corner-exact",
    "cradle",
    "galperin-1",
    "three-ball-symmetric",
    "sliding-swerve",
    "draw-shot",
    "masse",
    "english-check",
    "han-running",
    "throw-slip",
    "throw-stick",
    "throw-alciatore",
    "gearing",
    "frozen-to-cushion",
    "frozen-triangle",
    "break-7",
    "chaos-a",
    "pool-break-9",
)
"""The shipped scenes that are graded here: each law and way of moving, from one ball to breaks."""

BATCH = 10
"""Random shots in a trial."""

QUICK_SHOTS, FULL_SHOTS = 100, 4_000

CALM = range(10, 90)
"""Random shots none of which has thousands of steps of sustained contact: quick, interpreted too.

Of the first hundred, shots 1 and 97 do have them.
"""

_HARDEST = 32.0
"""Quality factor at which our engine breaks; see `scenes/common.expect.toml`."""


@dataclass(frozen=True)
class Proved:
    """Whether a run keeps the limits of every shipped scene, graded against the proof of its shot.

    No event missing, none invented, and positions within 32 roundings of the state per event.

    Attributes
    ----------
    cached : bool
        Whether the proof is kept on the disk.
    """

    cached: bool = True

    def __call__(self, result: Result) -> Verdict:
        """Judge a run, recorded with its trajectory."""
        scene = result.scene
        grade_of = grade(result, certify(scene, PROOF, motion=True, cached=self.cached))
        quality = grade_of.quality_factor
        values = {"quality_factor": quality, "events": grade_of.events, "extent": grade_of.extent}
        near = min((quality or 0.0) / _HARDEST, 0.999)
        return Verdict.of(scene, faults_of(grade_of, scene), near, values)


@dataclass(frozen=True)
class ProvedShot(SceneTrial):
    """A shot of a name, graded against its proof."""

    limit: ClassVar[float] = 300.0  # the first one compiles the tangent map


@dataclass(frozen=True)
class ProvedShots(Trial):
    """Random shots from one number on, each graded against its proof.

    Attributes
    ----------
    name : str
    first, count : int
        See `random_shot`.
    """

    name: str
    first: int
    count: int
    small: ClassVar[bool] = False
    limit: ClassVar[float] = 300.0
    cached: ClassVar[bool] = False  # there are more than are kept

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Play and judge them; the verdict shows the shot that came off worst."""
        verdicts = [self._judge(engine, random_shot(n)) for n in self._numbers()]
        worst = max(verdicts, key=lambda verdict: (verdict.broken, verdict.severity))
        faults = [
            f"{verdict.scene.name}: {fault}"
            for verdict in verdicts
            for fault in verdict.faults
            if verdict.scene is not None
        ]
        broken = sum(verdict.broken for verdict in verdicts)
        values = dict(worst.values)
        return Verdict(tuple(faults), worst.scene, worst.severity, len(verdicts), broken, values)

    def examples(self) -> Iterable[Scene]:
        """Yield the shots."""
        return map(random_shot, self._numbers())

    def _numbers(self) -> range:
        return range(self.first, self.first + self.count)

    def _judge(self, engine: ReferenceEngine, scene: Scene) -> Verdict:
        result = play(engine, scene)
        return result if isinstance(result, Verdict) else Proved(self.cached)(result)


@dataclass(frozen=True)
class CalmShots(ProvedShots):
    """The same, where all of them are in `CALM`."""

    small: ClassVar[bool] = True
    cached: ClassVar[bool] = True


def crowd(name: str, physics: Physics, number: int) -> Scene:
    """Return a fifth of a second of 110 balls, so many that only neighbours are looked at.

    In rows, but for chance; every tenth or so moves.
    """
    chance = random.Random(f"ghostball crowd {number}")
    balls = []
    for k in range(110):
        place = tuple(0.09 * row + 0.08 + chance.uniform(-0.015, 0.015) for row in divmod(k, 10))
        moves = k % 11 == 3
        velocity = (chance.uniform(-2.0, 2.0), chance.uniform(-2.0, 2.0)) if moves else (0.0, 0.0)
        balls.append(Ball(id=f"b{k}", position=place, velocity=velocity))
    table = Table(length=1.06, width=0.97)
    return Scene(name=name, table=table, physics=physics, balls=balls, t_max=0.2)


def _trials(suite: Suite) -> Iterator[Trial]:
    for name in SHIPPED:
        yield ProvedShot(name, find_scene(name), Proved())
    for kind, physics in (
        ("elastic", Physics(rolling_friction=0.0)),
        ("sliding", Physics(preset="pool")),
    ):
        for number in range(1 if suite == "quick" else 10):
            name = f"crowd-{kind}-{number}"
            yield ProvedShot(name, crowd(name, physics, number), Proved())
    for first in range(0, QUICK_SHOTS if suite == "quick" else FULL_SHOTS, BATCH):
        kind = CalmShots if first in CALM and first + BATCH - 1 in CALM else ProvedShots
        yield kind(f"shots-{first:04d}+{BATCH}", first, BATCH)


FAMILY = Family(
    "proofs",
    "Shots against their proofs",
    "Every event that interval arithmetic proves happens, in that order, no other does, and the "
    "balls end within 32 roundings of the state per event; as far as the proof goes, and the shot "
    "can be predicted in double precision.",
    _trials,
    ours_alone=True,
)
