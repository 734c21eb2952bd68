"""Run one engine on scenes; report each requirement as passed, failed or skipped.

The requirements and their sentences are those of `ghostball validate`; see
`validation.checks.requirements`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal, NamedTuple

from ghostball.model import Scene
from ghostball.reference_adapters import ReferenceEngine, make_engine
from ghostball.validation.checks import requirements
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.checks.requirements import Requirements
from ghostball.validation.checks.verdict import is_unfinished, unfinished_text
from ghostball.validation.results.records import CaseRecord, Check, Motion
from ghostball.validation.suite.case import plain_settings, run_case, truth_or_failure
from ghostball.validation.suite.judge import Case

COMPLETES = "completes"
"""The requirement besides the limits on metrics: that a run finishes by itself."""

Outcome = Literal["passed", "failed", "skipped"]


class Specs(NamedTuple):
    """The engine under test, and optionally a second engine whose limits apply.

    Each is written as by the user: `NAME` or `MODULE:NAME`, then settings.
    """

    engine: str
    judged_as: str | None = None

    @property
    def limiting(self) -> str:
        """The engine whose limits apply."""
        return self.engine if self.judged_as is None else self.judged_as


@dataclass(frozen=True)
class RequirementResult:
    """Result of one requirement: `words` is one sentence, "" if it passed."""

    outcome: Outcome
    words: str = ""
    checks: tuple[Check, ...] = ()


@dataclass(frozen=True, eq=False)
class SceneRun:
    """A scene that was run on an engine.

    `motion`: None if the engine did not finish.
    """

    record: CaseRecord
    motion: Motion | None = None

    def finding(self, metric: str) -> RequirementResult:
        """Return the result of `COMPLETES`, or of all limits on a metric."""
        record = self.record
        if record.outcome == "not-representable":
            return RequirementResult("skipped", f"{record.scene}: unsupported: {record.reason}")
        if record.outcome != "ran":
            return RequirementResult("failed", f"{record.engine} failed: {record.reason}")
        if metric == COMPLETES:
            if is_unfinished(record):
                return RequirementResult(
                    "failed", f"the run must finish by itself: {unfinished_text(record)}"
                )
            return RequirementResult("passed")
        checks = tuple(check for check in record.checks if check.metric == metric)
        if not checks:
            note = record.notes.get(metric) or (
                "no limit follows from the claims or the time step of the engine, or the "
                "reference isn't independent of the engine `ghostball`"
            )
            return RequirementResult("skipped", f"{record.scene}: {note}")
        broken = tuple(check for check in checks if check.passed is False)
        if broken:
            return RequirementResult(
                "failed", "; ".join(check.sentence for check in broken), broken
            )
        if all(check.passed is None for check in checks):
            return RequirementResult("skipped", f"{record.scene}: {checks[0].note}", checks)
        return RequirementResult("passed", checks=checks)


def asked_of_engine(specs: Specs, own: Criteria, for_all: Criteria | None = None) -> Requirements:
    """Return the requirements for an engine in a scene; see `requirements.asked_of`.

    Limits for the engine itself apply even if it is judged as another engine.
    """
    named = [one for one in specs if one is not None]
    engines = [(one.name, plain_settings(one)) for one in map(make_engine, named)]
    return requirements.asked_of(engines, own, for_all)


def requirement_names(specs: Specs, scene: Scene, asked: Requirements) -> tuple[str, ...]:
    """Return the names of the requirements: `COMPLETES`, then metrics in the order of `METRICS`."""
    return (COMPLETES, *asked.metrics(requirements.claim_of(make_engine(specs.limiting), scene)))


def run_scene(
    specs: Specs,
    scene: Scene,
    own: Criteria,
    asked: Requirements,
    make: Callable[[str], ReferenceEngine] = make_engine,
    *,
    every_record: bool = False,
) -> SceneRun:
    """Run a scene on an engine; any error becomes part of the record.

    `own`: the criteria of the scene.
    `make`: creates the engine that runs, for example one in another process.
    `every_record`: also run with less recorded, which must not change the result.
    """
    judged_as = None if specs.judged_as is None else partial(make_engine, specs.judged_as)
    truth = truth_or_failure(scene, own)
    case = Case(scene, specs.engine, truth, asked, judged_as=judged_as, every_record=every_record)
    return SceneRun(*run_case(case, make))
