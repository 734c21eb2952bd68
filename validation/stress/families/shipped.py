"""Shipped: the scenes that come with ghostball, each asked what `ghostball validate` asks of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from ghostball.model import Scene
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.scenes.library import select
from ghostball.validation.stress.trial import Family, Suite, Trial, Verdict, broken_law, play
from ghostball.validation.suite.plan import shipped_criteria
from ghostball.validation.truth.scene_truth import truth_of


@dataclass(frozen=True)
class ShippedTrial(Trial):
    """A scene, held to its limits and to the law."""

    name: str
    scene: Scene
    limit: ClassVar[float] = 300.0  # where no proof is kept yet

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Run the shot and judge it."""
        result = play(engine, self.scene, law=False)
        if isinstance(result, Verdict):
            return result
        own = shipped_criteria(self.scene)
        truth = truth_of(self.scene, own.truth, least=own.least_proved)
        faults = broken_law(engine, result, truth, own)
        return Verdict.of(self.scene, faults, 10.0 * bool(faults))


def _trials(suite: Suite) -> Iterator[Trial]:
    for scene in select(["smoke" if suite == "quick" else "full"]):
        yield ShippedTrial(scene.name, scene)


FAMILY = Family(
    "shipped",
    "Shipped scenes and their limits",
    "What `ghostball validate` asks of each scene that comes with ghostball: its own limits, what "
    "the engine's step allows, and the law that holds for every engine.",
    _trials,
)
