"""The judge of a run against the proof of its shot, and the trials of one shot that it judges.

Exact motion is held to the limits of `scenes/common.expect.toml` for an engine that errs by
rounding alone: on events and their times, places, and the energy. An engine that steps sees
contacts late: it is asked what `ghostball validate` asks of it, by the same rows, with this proof
as the truth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, partial
from typing import ClassVar

import numpy as np

from ghostball.model import GhostballError, Result, Scene, UnsupportedSceneError
from ghostball.reference_adapters import ReferenceEngine
from ghostball.reference_adapters.certified import Certificate, CertifiedSettings, certify
from ghostball.reference_adapters.certified.engine import result_of
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.checks.criteria import common_criteria
from ghostball.validation.checks.law import faults_of
from ghostball.validation.checks.metrics import measure
from ghostball.validation.checks.proof_metrics import PROOF_METRICS, graded
from ghostball.validation.grading.certified_growth import growth_of_proof
from ghostball.validation.grading.certified_widths import is_differentiated
from ghostball.validation.grading.gradable import gradable
from ghostball.validation.grading.grading import Grade
from ghostball.validation.grading.horizon import GRID, growth_along_proof, horizon
from ghostball.validation.grading.tolerances import OFF_BY, ROUNDINGS, TOLERANCE, UNIT_ROUNDOFF
from ghostball.validation.results.records import CERTIFIED
from ghostball.validation.stress.invariants import is_exact
from ghostball.validation.stress.trial import Judge, Trial, Verdict, play
from ghostball.validation.truth.scene_truth import Truth, truth_of

LONGEST = 2.0
"""Simulated time [s] beyond which an engine isn't asked that may step through it."""


@dataclass(frozen=True)
class MatchesProof:
    """Whether a run has the events of the shot's proof, and no others; and ends where it does.

    As far as the proof goes, and the shot can be predicted in double precision.

    `least`: events that must be proved; None: all of them, to the shot's end. A proof that ends
        before is a fault: what it doesn't say isn't judged. With 0 it may say nothing: somebody
        else asks that enough is proved.
    `cached`: whether the proof is kept on the disk.
    """

    settings: CertifiedSettings = CertifiedSettings()  # noqa: RUF009 - frozen
    least: int | None = None
    cached: bool = True

    def __call__(self, result: Result) -> Verdict:
        """Judge a run, recorded with its trajectory.

        Raises `GhostballError` where nothing is proved of its shot, so that nothing would be
        judged: the shot asks for another judge.
        """
        return self.judge(result, self.proof(result.scene))

    def proof(self, scene: Scene) -> Certificate:
        """Return the proof of a shot.

        Raises `GhostballError` where it says nothing.
        """
        try:
            proof = certify(scene, self.settings, motion=True, cached=self.cached)
        except UnsupportedSceneError as error:  # of no engine that is tried
            raise GhostballError(f"scene {scene.name!r} can't be proved: {error}") from error
        if not proof.events and not proof.proved and self.least != 0:
            raise GhostballError(f"nothing is proved of scene {scene.name!r}: {proof.reason}")
        return proof

    def judge(self, result: Result, proof: Certificate) -> Verdict:
        """Judge a run against a proof."""
        scene = result.scene
        if too_little := proved_too_little(scene, proof, self.least):
            return Verdict.of(scene, [too_little], 10.0)
        if not is_exact(result):
            return Verdict.of(scene, ())  # the law has judged it
        truth = _truth_of(scene, proof)
        measured = measure(result, truth, PROOF_METRICS)
        found = graded(result, proof, truth.graded)
        faults = list(faults_of(found, scene, measured.values))
        faults += [f"{name}: {measured.notes[name]}" for name in sorted(measured.incomplete)]
        faults += _moved(found) if not faults else []
        faults += self_reported_growth(result, proof, found.until)
        nearest = (found.quality_factor or 0.0) / quality_limit()
        values = {
            "quality_factor": found.quality_factor,
            "events": found.events,
            "extent": found.extent,
            "proved": proof.proved,
            "missing": len(found.missing),
            "invented": len(found.invented),
        }
        return Verdict.of(scene, faults, nearest, values)


def _truth_of(scene: Scene, proof: Certificate) -> Truth:
    """Return the reference that a proof gives: the certified motion, if complete, and rounding."""
    return Truth(
        CERTIFIED,
        missing="the shot isn't proved to its end",
        proved=result_of(scene, proof, CertifiedSettings(), "trajectory") if proof.proved else None,
        certificate=proof,
        rounding=growth_along_proof(scene, proof).rounding(scene),
        graded=gradable(scene, proof),
    )


def proved_too_little(scene: Scene, proof: Certificate, least: int | None) -> str:
    """Return what is wrong where a proof ends before it must, else ""; see `MatchesProof.least`."""
    found = len(proof.events)
    if proof.proved or (least is not None and found >= least):
        return ""
    must = "all to its end" if least is None else f"{least}"
    return (
        f"only {found} events of scene {scene.name!r} are proved, {must} must be: "
        f"{proof.ending}: {proof.reason}"
    )


def self_reported_growth(result: Result, proof: Certificate, until: float = math.inf) -> list[str]:
    """Return what a run says of its own predictability that the proved motion contradicts.

    Its horizon, and how far rounding displaces its balls; as far as the shot is proved, and up to
    an instant `until` [s]. No grade depends on them, but users do. In air and in flight our engine
    says, as documented, that it knows no derivative, which contradicts nothing; along a proved
    flight the grader follows none either.
    """
    if float(np.max(np.linalg.norm(result.scene.velocities, axis=1))) < LEAST_SPEED:
        return []
    physics = result.scene.physics
    slowed = physics.air_drag > 0.0 or physics.rolling_friction_quadratic > 0.0
    if slowed and np.isinf(result.sensitivity([0.0])).all():
        return []
    if not is_differentiated(result.scene):
        return []
    # Our engine's own estimate rounds states only, not gaps.
    growth = growth_of_proof(result.scene, proof, gaps=False)
    error = ROUNDINGS * UNIT_ROUNDOFF
    end, ends = min(float(proof.t_end), until), growth.derivative_ends
    # Where no derivative exists both say so, and beyond the proof the grader says nothing.
    least, said, most = (
        min(known, end, ends)
        for known in (
            horizon(growth, TOLERANCE / OFF_BY, error),
            result.horizon(TOLERANCE, error),
            horizon(growth, TOLERANCE * OFF_BY, error),
        )
    )
    faults = []
    if not least - GRID <= said <= most + GRID:
        faults.append(f"`horizon()` is {said:.6g} s, the proved motion's {least:.6g} to {most:.6g}")
    # Amid the longest time without an event, for the run's own events come sooner or later.
    marks = np.append(growth.times[growth.times < most], most)
    longest = int(np.argmax(np.diff(marks, append=most)))
    t = float(np.mean(marks[longest : longest + 2]))
    right, claimed = growth.sizes([t])[0], result.sensitivity([t])[0]
    agree = (claimed <= OFF_BY * right) & (right <= OFF_BY * claimed)
    differing = ~agree & (right > 0.0)
    if np.any(differing):
        k = int(np.argmax(differing))
        faults.append(
            f"`sensitivity` of ball {k} at t = {t:.6g} s is {claimed[k]:.4g} m, the proved "
            f"motion's {right[k]:.4g} m"
        )
    return faults


LEAST_SPEED = 2.0**-500
"""Speed [m/s] below which squares vanish, and our engine's map says that there is no derivative."""


@cache
def quality_limit() -> float:
    """Return the quality factor at which an exact engine breaks, of the common criteria."""
    (limit,) = (one.limit for one in common_criteria().criteria if one.metric == "quality_factor")
    return float(limit)


def _moved(found: Grade) -> list[str]:
    """Return what is wrong where nothing can have moved, and so no quality factor says it."""
    if found.quality_factor is not None or found.extent != "whole":
        return []
    off = float(np.max(found.position_errors))
    return [f"a ball that rounding doesn't move is {off:.3g} m off"] if not off <= 0.0 else []


@dataclass(frozen=True)
class ProvedTrial(Trial):
    """One shot that is proved, of any size.

    `least`, `cached`: as of `MatchesProof`.
    `also`: another judge of the same run.
    """

    name: str
    scene: Scene
    least: int | None = None
    cached: bool = True
    also: Judge | None = None
    limit: ClassVar[float] = 300.0  # the first one compiles the tangent map

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Prove the shot, run it, compare."""
        judge = MatchesProof(least=self.least, cached=self.cached)
        proof = judge.proof(self.scene)
        refuse_long(engine, self.scene, float(proof.t_end))
        result = play(engine, self.scene, truth=partial(truth_of, self.scene))
        if isinstance(result, Verdict):
            return result
        verdict = judge.judge(result, proof)
        return verdict if self.also is None else verdict.joined(self.also(result))


def refuse_long(engine: ReferenceEngine, scene: Scene, t_end: float) -> None:
    """Refuse for an engine other than ours a shot that would take it too many steps."""
    if engine.name != OURS and t_end > LONGEST:
        why = f"{t_end:.3g} s of motion, more than the {LONGEST:g} s that steps are asked for"
        raise UnsupportedSceneError(engine.name, (f"{why} (scene {scene.name!r})",))
