"""Shipped: the scenes that come with ghostball, each asked what `ghostball validate` asks of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from ghostball.model import EngineFailedError, Scene, UnsupportedSceneError
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.checks.law import asked_of
from ghostball.validation.checks.verdict import not_judged, unfinished_text
from ghostball.validation.scenes.library import select
from ghostball.validation.stress.trial import (
    Family,
    NotJudgedError,
    StressError,
    Suite,
    Trial,
    Verdict,
)
from ghostball.validation.suite.case import plain_settings, run_case, truth_or_failure
from ghostball.validation.suite.judge import Case
from ghostball.validation.suite.plan import shipped_criteria


@dataclass(frozen=True)
class ShippedTrial(Trial):
    """A scene, held to its limits and to the law."""

    name: str
    scene: Scene
    limit: ClassVar[float] = 300.0  # where no proof is kept yet

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Run the shot and judge it in the same way as every other command.

        Raises `NotJudgedError` if no limit applies to the run.
        """
        own = shipped_criteria(self.scene)
        asked = asked_of([(engine.name, plain_settings(engine))], own)
        case = Case(self.scene, engine.name, truth_or_failure(self.scene, own), asked)
        record, _ = run_case(case, lambda _: engine)
        if record.outcome == "not-representable":
            raise UnsupportedSceneError(engine.name, (record.reason,))
        if record.fault == "ghostball":
            raise StressError(record.reason)
        if record.outcome == "failed":
            raise EngineFailedError(engine.name, record.reason)
        faults = [check.sentence for check in record.checks if check.passed is False]
        if stopped := unfinished_text(record):
            faults.insert(0, stopped)
        if not faults and (why := not_judged([record])):
            raise NotJudgedError(why)
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
