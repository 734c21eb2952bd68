"""Trials of random scenes in a row, by number, each put to one judge."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from ghostball.model import Scene, UnsupportedSceneError
from ghostball.reference_adapters import ReferenceEngine
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.scenes.random_scenes import Wanted, random_scene
from ghostball.validation.stress.trial import Judge, Trial, Verdict, play

FOREIGN_T_MAX = 2.0
"""How much of a scene other engines play [s]."""


@dataclass(frozen=True)
class RandomScenes(Trial):
    """Random scenes, of which the verdict shows the one that broke worst, or came nearest.

    Our engine plays them all. Of other engines, that need seconds for one, each plays the first 2 s
    of the first one that it can represent.

    `judge`: given the result of one, recorded as a trajectory, returns the verdict.
    `first`, `count`: see `random_scene`.
    `having`: options that all of them have.
    """

    name: str
    judge: Judge
    first: int
    count: int
    having: tuple[tuple[str, Wanted], ...] = ()
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
            yield random_scene(number, **dict(self.having))

    def _judged(self, engine: ReferenceEngine, scene: Scene) -> Verdict:
        result = play(engine, scene)
        return result if isinstance(result, Verdict) else self.judge(result)


def random_trials(
    what: str, judge: Judge, size: int, parts: int, **having: Wanted
) -> Iterator[RandomScenes]:
    """Yield trials of as many scenes each, the first from number 0 on."""
    for first in range(0, size * parts, size):
        name = f"{what}-{first:05d}-{first + size - 1:05d}"
        yield RandomScenes(name, judge, first, size, tuple(having.items()))
