"""Trials of random scenes in a row, by number: nothing that must be the same may differ."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from ghostball.model import Scene
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.scenes.random_scenes import random_scene
from ghostball.validation.stress.same import CHECKS, differences
from ghostball.validation.stress.same.plays import played
from ghostball.validation.stress.trial import Trial, Verdict

SELDOM = ("results", "proof")
"""Checks that take a hundred times what others do."""

OFTEN = tuple(name for name in CHECKS if name not in SELDOM)


@dataclass(frozen=True)
class SameScenes(Trial):
    """Random scenes put to checks; the verdict shows the one that took most, or one that broke.

    Attributes
    ----------
    first, count : int
        See `random_scene`.
    having : tuple of (str, str)
        Options that all of them have.
    checks : tuple of str
        Names of `CHECKS`; the first of the scenes is put to all.
    """

    name: str
    first: int
    count: int
    having: tuple[tuple[str, str], ...] = ()
    checks: tuple[str, ...] = OFTEN
    limit: ClassVar[float] = 600.0

    def run(self, engine: ReferenceEngine) -> Verdict:  # noqa: ARG002 - it is about our engine
        """Put the scenes to the checks."""
        verdicts = []
        for k, scene in enumerate(self._scenes()):
            found = differences(scene, CHECKS if k == 0 else self.checks)
            work = sum(played(scene).work[name] for name in ("events", "contact_steps"))
            severity = 1.0 + len(found) if found else work / (work + 1e6)
            faults = [f"{name}: {sentence}" for name, sentence in found.items()]
            verdicts.append(Verdict.of(scene, faults, severity, {"work": work}))
        most = max(one.values["work"] for one in verdicts)
        return Verdict.of_all(verdicts, {"most_events_and_steps": most})

    def examples(self) -> Iterator[Scene]:
        """Yield scenes with every variant of the kernels that is needed, or nearly."""
        yield from self._scenes()

    def _scenes(self) -> Iterator[Scene]:
        for number in range(self.first, self.first + self.count):
            yield random_scene(number, **dict(self.having))


def trials_of(
    what: str, size: int, chunks: int, checks: tuple[str, ...] = OFTEN, **having: str
) -> Iterator[SameScenes]:
    """Yield trials of as many scenes each, the first from number 0 on."""
    for first in range(0, size * chunks, size):
        name = f"{what}-{first:05d}-{first + size - 1:05d}"
        yield SameScenes(name, first, size, tuple(having.items()), checks)
