"""Shots of Ghostball's engine, checked against the common limits of all engines."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from ghostball.model import Result, Scene
from ghostball.reference_adapters import ReferenceEngine
from ghostball.reference_adapters.base import resolution_of
from ghostball.reference_adapters.certified import CertifiedSettings
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.checks.criterion import Criterion
from ghostball.validation.checks.requirements import Requirements, asked_of
from ghostball.validation.results.records import CaseRecord, Check
from ghostball.validation.stress import StressShot, StressSize, chosen_shots, path_of
from ghostball.validation.suite.case import blank_record, plain_settings, run_case
from ghostball.validation.suite.judge import Case, judge
from ghostball.validation.truth.scene_truth import Truth, truth_of

PROOF = CertifiedSettings(time_limit=5.0)
"""Time limit for the certificate of a shot."""


@dataclass(frozen=True)
class Judged:
    """Result of the checks of a run of Ghostball's engine.

    `faults`: a sentence for each failed check.
    `reference`: extent of the independent reference: the whole shot; the part before a contact that
        the certificate can't decide ("ambiguous"); another part; or none.
    """

    record: CaseRecord
    faults: tuple[str, ...]
    reference: Literal["whole", "ambiguous", "part", "none"]
    why: str


NO_REFERENCE = Truth(None, missing="not requested")


def judged(scene: Scene, criteria: Criteria | None = None, *, reference: bool = True) -> Judged:
    """Simulate a shot with Ghostball's engine, and check it as all commands do.

    `criteria`: additional limits.
    `reference`: whether the shot is compared with a closed form or a certificate.
    """
    truth = truth_of(scene, settings=PROOF) if reference else NO_REFERENCE
    engine = make_engine("ghostball")
    asked = asked_of([(engine.name, plain_settings(engine))], criteria or Criteria())
    record, _ = run_case(Case(scene, "ghostball", truth, asked, keeps_motion=False))
    faults = tuple(check.sentence for check in record.checks if check.passed is False)
    if record.outcome != "ran":
        faults = (f"{record.outcome}: {record.reason}",)
    return Judged(record, faults, *_reference(truth))


def checks_on(
    engine: ReferenceEngine, result: Result, truth: Truth, asked: Requirements
) -> tuple[Check, ...]:
    """Return the checks of an existing run of an engine."""
    case = Case(result.scene, engine.name, truth, asked, keeps_motion=False)
    limits = asked.limits(engine, result.scene, truth)
    resolution = resolution_of(engine, result.scene)
    record, _ = judge(blank_record(case), case, truth, result, resolution, limits, engine)
    return record.checks


def broken(result: Result, *limits: Criterion, truth: Truth = NO_REFERENCE) -> list[str]:
    """Return a sentence for each common or given limit that a run of Ghostball's engine fails."""
    engine = make_engine("ghostball")
    asked = asked_of([(engine.name, plain_settings(engine))], Criteria(criteria=limits))
    return [one.sentence for one in checks_on(engine, result, truth, asked) if one.passed is False]


def _reference(truth: Truth) -> tuple[Literal["whole", "ambiguous", "part", "none"], str]:
    proof = truth.certificate
    if "rest" in truth.independent:
        return "whole", ""
    if proof is None:
        return "none", truth.no_certificate
    return ("ambiguous" if proof.ending == "ambiguous" else "part"), proof.reason


def stress_shots(size: StressSize, *families: str) -> Iterator[tuple[str, StressShot]]:
    """Yield generated shots with their names."""
    for shot in chosen_shots(size, families):
        yield path_of(shot.scene.name), shot
