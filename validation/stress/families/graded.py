"""Graded: shots of all physics that can be proved, and how a run compares with the proof."""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import ClassVar

from ghostball.model import Ball, Physics, Scene, Table
from ghostball.reference_adapters import ReferenceEngine
from ghostball.reference_adapters.certified import CertifiedSettings
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.scenes.random_shots import random_shot
from ghostball.validation.stress.proved import MatchesProof, partly_proved
from ghostball.validation.stress.trial import Family, SceneTrial, Suite, Trial, Verdict, play

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
    "cradle",
    "galperin-1",
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
    "flight-jump",
    "flight-leaves",
)
"""The shipped scenes that are graded here: each law and way of moving, from one ball to breaks."""

BATCH = 10
"""Random shots in a trial."""

QUICK_SHOTS, FULL_SHOTS = 100, 3_000

PARTLY_PROVED = {"frozen-triangle": 1}
"""Events that are proved of the shipped scenes here whose proof ends early, in a tie."""

CALM = range(10, 90)
"""Random shots none of which has thousands of steps of sustained contact: fast, interpreted too.

Of the first hundred, shots 1 and 97 do have them.
"""

MATCHES_PROOF = MatchesProof(settings=PROOF)


@dataclass(frozen=True)
class ProvedShot(SceneTrial):
    """A shot of a name, graded against its proof."""

    limit: ClassVar[float] = 300.0  # the first one compiles the tangent map


@dataclass(frozen=True)
class ProvedShots(Trial):
    """Random shots from one number on, each graded against its proof.

    Attributes
    ----------
    first, count : int
        See `random_shot`.
    """

    name: str
    first: int
    count: int
    limit: ClassVar[float] = 300.0
    cached: ClassVar[bool] = False  # there are more than are kept

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Play and judge them; the verdict shows the shot that came off worst."""
        return Verdict.of_all([self._judge(engine, self.shot(n)) for n in self._numbers()])

    def examples(self) -> Iterable[Scene]:
        """Yield the shots."""
        return map(self.shot, self._numbers())

    def shot(self, number: int) -> Scene:
        """Return the shot of a number."""
        return random_shot(number)

    def least(self, scene: Scene) -> int | None:
        """Return how many events must be proved of a shot; None: all."""
        return partly_proved().get(int(scene.name.removeprefix("shot-")))

    def _numbers(self) -> range:
        return range(self.first, self.first + self.count)

    def _judge(self, engine: ReferenceEngine, scene: Scene) -> Verdict:
        result = play(engine, scene)
        if isinstance(result, Verdict):
            return result
        return replace(MATCHES_PROOF, cached=self.cached, least=self.least(scene))(result)


@dataclass(frozen=True)
class CalmShots(ProvedShots):
    """The same, where all of them are in `CALM`."""

    cached: ClassVar[bool] = True


def many_balls(name: str, physics: Physics, number: int) -> Scene:
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


def _odd_shots() -> Iterator[Scene]:
    """Yield shots in which the cloth does what it seldom does."""
    table = Table(length=2.54, width=1.27)
    thrown_back = Ball(
        id="cue", position=(0.06, 0.3), velocity=(0.3, 0.05), angular_velocity=(0.0, -250.0, 0.0)
    )
    # With so much backspin that it comes back, still sliding, to the cushion that it left.
    yield Scene(
        name="thrown-back",
        table=table,
        physics=Physics(motion="sliding", sliding_friction=0.2),
        balls=[thrown_back],
    )
    # A ball whose spin the cloth still changes rubs against another one.
    yield Scene(
        name="hit-while-sliding",
        physics=Physics(preset="pool"),
        balls=[
            Ball(
                id="cue",
                position=(0.6, 0.4),
                velocity=(1.2, 0.9),
                angular_velocity=(60.0, -40.0, 30.0),
            ),
            Ball(id="1", position=(0.86, 0.6)),
        ],
    )


def _trials(suite: Suite) -> Iterator[Trial]:
    for name in SHIPPED:
        as_proved = replace(MATCHES_PROOF, least=PARTLY_PROVED.get(name))
        yield ProvedShot(name, find_scene(name), as_proved)
    for scene in _odd_shots():
        yield ProvedShot(scene.name, scene, MATCHES_PROOF)
    for kind, physics in (
        ("elastic", Physics(rolling_friction=0.0)),
        ("sliding", Physics(preset="pool")),
    ):
        for number in range(1 if suite == "quick" else 10):
            name = f"many-balls-{kind}-{number}"
            yield ProvedShot(name, many_balls(name, physics, number), MATCHES_PROOF)
    for first in range(0, QUICK_SHOTS if suite == "quick" else FULL_SHOTS, BATCH):
        calm = first in CALM and first + BATCH - 1 in CALM
        batch = CalmShots if calm else ProvedShots
        yield batch(f"shots-{first:04d}+{BATCH}", first, BATCH)


FAMILY = Family(
    "graded",
    "Shots against their proofs",
    "Every event that interval arithmetic proves happens, in that order, no other does, and the "
    "balls end within 32 roundings of the state per event; as far as the proof goes, and the shot "
    "can be predicted in double precision.",
    _trials,
    ours_alone=True,
)
