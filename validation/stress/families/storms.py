"""Storms: random breaks over the whole physics of the cloth, of which none may get stuck."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, Final

from ghostball.model import Scene, UnsupportedSceneError
from ghostball.reference_adapters import ReferenceEngine
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.scenes.random_scenes import Wanted, random_scene
from ghostball.validation.stress.judges import Invariants
from ghostball.validation.stress.trial import Family, Suite, Trial, Verdict, play

MOST = 100_000
"""Events, and contact steps, of a break."""

LOOKS = 200
"""Instants at which each break is looked at."""

JUDGE: Final = Invariants(most_events=MOST, most_steps=MOST, random=True, looks=LOOKS)

BREAKS: Final[Mapping[str, Wanted]] = {
    "layout": ("rack", "loose-rack"),
    "count": "many",
    "table": ("pool", "small"),
    "cloth": "slows",
    "stop": "rest",
    "speed": ("usual", "fast"),
    "flight": "no",
    "along_rail": "no",
}
"""The options of random scenes that are breaks."""

FOREIGN_T_MAX = 2.0
"""How much of a scene other engines play [s]."""


@dataclass(frozen=True)
class RandomBreaks(Trial):
    """Random breaks, of which the verdict shows the one that broke worst, or came nearest.

    Our engine plays them all. Of other engines, that need seconds for one, each plays the first 2 s
    of the first one that it can represent.

    `first`, `count`: numbers of the scenes; see `random_scene`.
    """

    name: str
    first: int
    count: int
    limit: ClassVar[float] = 600.0

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Play the scenes and judge each.

        Raises `UnsupportedSceneError` where the engine can represent none of them.
        """
        if engine.name == OURS:
            return Verdict.of_all([self._judged(engine, scene) for scene in self.examples()])
        lacks: dict[str, None] = {}
        for scene in self.examples():
            try:
                return self._judged(engine, scene.model_copy(update={"t_max": FOREIGN_T_MAX}))
            except UnsupportedSceneError as error:
                lacks.update(dict.fromkeys(error.features))
        raise UnsupportedSceneError(engine.name, tuple(lacks))

    def examples(self) -> Iterator[Scene]:
        """Yield the scenes: with every variant of the kernels that is needed."""
        for number in range(self.first, self.first + self.count):
            yield random_scene(number, **BREAKS)

    def _judged(self, engine: ReferenceEngine, scene: Scene) -> Verdict:
        result = play(engine, scene)
        return result if isinstance(result, Verdict) else JUDGE(result)


def _trials(suite: Suite) -> Iterator[Trial]:
    size, parts = (250, 2) if suite == "quick" else (500, 100)
    for first in range(0, size * parts, size):
        yield RandomBreaks(f"racks-{first:05d}-{first + size - 1:05d}", first, size)


FAMILY = Family(
    "storms",
    "Random breaks",
    "Whatever the break, the laws and the frictions: it ends by itself within "
    f"{MOST} events and contact steps, energy never rises, and no ball overlaps another or "
    "a cushion: exact motion by no more than rounding and what a sustained contact may be off by, "
    "that of an engine that steps by no more than the law allows its step. Each break is looked "
    f"at at {LOOKS} instants. Other engines than "
    f"ours play {FOREIGN_T_MAX:g} s of one break of each trial.",
    _trials,
)
