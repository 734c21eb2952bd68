"""Shots that our engine plays right, put to the law that every engine is held to."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from ghostball.model import Scene
from ghostball.reference_adapters.certified import CertifiedSettings
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.checks.law import asked_of
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.stress.families import chosen_trials, path_of
from ghostball.validation.stress.families.shipped import ShippedTrial
from ghostball.validation.stress.trial import Suite
from ghostball.validation.suite.case import plain_settings, run_case
from ghostball.validation.suite.judge import Case
from ghostball.validation.truth.scene_truth import Truth, truth_of

PROOF = CertifiedSettings(time_limit=5.0)
"""How long a proof of one shot may take."""


@dataclass(frozen=True)
class Judged:
    """What the law says of our engine's run of a shot.

    `faults`: what it breaks, one sentence each.
    `reference`: what is known of the shot without our engine: all of it; what a proof says up to
        where it can't tell contacts apart; a part of it for another reason; or nothing.
    """

    record: CaseRecord
    faults: tuple[str, ...]
    reference: Literal["whole", "ambiguous", "part", "none"]
    why: str


def judged(scene: Scene, *, reference: bool = True) -> Judged:
    """Play a shot with our engine, and hold it to the law as every command does.

    `reference`: whether the shot is compared with a closed form or a proof.
    """
    truth = truth_of(scene, settings=PROOF) if reference else Truth(None, missing="not asked for")
    engine = make_engine("ghostball")
    asked = asked_of([(engine.name, plain_settings(engine))], Criteria())
    record, _ = run_case(Case(scene, "ghostball", truth, asked))
    faults = tuple(check.sentence for check in record.checks if check.passed is False)
    if record.outcome != "ran":
        faults = (f"{record.outcome}: {record.reason}",)
    return Judged(record, faults, *_reference(truth))


def _reference(truth: Truth) -> tuple[Literal["whole", "ambiguous", "part", "none"], str]:
    proof = truth.certificate
    if "rest" in truth.independent:
        return "whole", ""
    if proof is None:
        return "none", truth.no_certificate
    return ("ambiguous" if proof.ending == "ambiguous" else "part"), proof.reason


def stress_scenes(suite: Suite, *families: str) -> Iterator[tuple[str, Scene]]:
    """Yield the scenes of the stress trials, with the names of the trials; shipped ones apart."""
    for family, trial in chosen_trials(suite, families):
        if not isinstance(trial, ShippedTrial):
            for k, scene in enumerate(trial.examples()):
                yield f"{path_of(family, trial)}/{k}", scene
