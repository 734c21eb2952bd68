"""The judge of a run against the proof of its shot, and the trials of one shot that it judges.

Exact motion is held to the limits of `scenes/common.expect.toml`: no event missing, none invented,
and positions within 32 roundings of the state per event. An engine that steps sees contacts late;
what it is asked for instead is `SteppedRule`'s.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from engine import GhostballError, Result, Scene, UnsupportedSceneError
from reference_adapters import ReferenceEngine
from reference_adapters.certified import Certificate, CertifiedSettings, certify
from reference_adapters.registry import OURS
from validation.criteria import common_criteria
from validation.faults import faults_of
from validation.grading import Grade, grade
from validation.stress.judges import VISIBLE, is_exact
from validation.stress.trial import Trial, Verdict, play

SteppedRule = Literal["collisions", "places"]
"""What of an engine that steps is judged.

"collisions": that these are the proved ones, and that no ball ends more than `VISIBLE` of a
diameter off. "places": where balls are, over the longest way; of shots that go for any number of
diameters, and whose lengths have any size.
"""

PERMITTED = 0.01
"""Error that "places" permits, in units of the longest way that a ball went.

Contacts are seen up to a step late. This is no grade of how exact an engine is, which `validate`
gives: it tells a shot that is played from one that is lost.
"""

STILL = 1e-9
"""How far a ball may move that can't, in radii, in engines that step."""

LONGEST = 2.0
"""Simulated time [s] beyond which an engine isn't asked that may step through it."""


@dataclass(frozen=True)
class AsProved:
    """Whether a run has the events of the shot's proof, and no others; and ends where it does.

    As far as the proof goes, and the shot can be predicted in double precision.

    Attributes
    ----------
    stepped : "collisions" or "places"
        See `SteppedRule`.
    settings : CertifiedSettings
        How far the shot is proved.
    cached : bool
        Whether the proof is kept on the disk.
    """

    stepped: SteppedRule = "collisions"
    settings: CertifiedSettings = CertifiedSettings()  # noqa: RUF009 - frozen
    cached: bool = True

    def __call__(self, result: Result) -> Verdict:
        """Judge a run, recorded with its trajectory.

        Raises
        ------
        GhostballError
            Where nothing is proved of its shot, so that nothing would be judged: the shot asks for
            another judge.
        """
        return self.judge(result, self.proof(result.scene))

    def proof(self, scene: Scene) -> Certificate:
        """Return the proof of a shot.

        Raises
        ------
        GhostballError
            Where it says nothing.
        """
        try:
            proof = certify(scene, self.settings, motion=True, cached=self.cached)
        except UnsupportedSceneError as error:  # of no engine that is tried
            raise GhostballError(f"scene {scene.name!r} can't be proved: {error}") from error
        if not proof.events and not proof.proved:
            raise GhostballError(f"nothing is proved of scene {scene.name!r}: {proof.reason}")
        return proof

    def judge(self, result: Result, proof: Certificate) -> Verdict:
        """Judge a run against a proof."""
        if not is_exact(result) and self.stepped == "places":
            return near(result, proof)
        scene, found = result.scene, grade(result, proof)
        faults = list(faults_of(found, scene))
        off = float(np.max(found.position_errors, initial=0.0)) / (2.0 * float(scene.radii.max()))
        if not is_exact(result):
            if not off <= VISIBLE:
                faults.append(f"a ball ends {off:.3g} diameters off, at most {VISIBLE:g}")
            nearest = off / VISIBLE
        else:
            faults += _moved(found) if not faults else []
            nearest = (found.quality_factor or 0.0) / quality_limit()
        values = {
            "quality_factor": found.quality_factor,
            "events": found.events,
            "extent": found.extent,
            "missing": len(found.missing),
            "invented": len(found.invented),
        }
        return Verdict.of(scene, faults, nearest, values)


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
    """One shot that is proved, of any size, judged with the rule "places" for engines that step.

    Attributes
    ----------
    name : str
    scene : Scene
    """

    name: str
    scene: Scene

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Prove the shot, run it, compare."""
        judge = AsProved("places")
        proof = judge.proof(self.scene)
        refuse_long(engine, self.scene, float(proof.t_end))
        result = play(engine, self.scene)
        return result if isinstance(result, Verdict) else judge.judge(result, proof)

    def examples(self) -> Iterable[Scene]:
        """Yield the scene."""
        yield self.scene


def refuse_long(engine: ReferenceEngine, scene: Scene, t_end: float) -> None:
    """Refuse for an engine other than ours a shot that would take it too many steps.

    Raises
    ------
    UnsupportedSceneError
    """
    if engine.name != OURS and t_end > LONGEST:
        why = f"{t_end:.3g} s of motion, more than the {LONGEST:g} s that steps are asked for"
        raise UnsupportedSceneError(engine.name, (f"{why} (scene {scene.name!r})",))


def near(result: Result, proof: Certificate) -> Verdict:
    """Judge a run by where its balls are at the end of the proof."""
    scene = result.scene
    start = scene.positions[:, :2]
    end = np.array([[float(e) for e in position] for position in proof.positions])
    found = result.sample([float(proof.t_end)]).positions[0, :, :2]
    way = float(np.max(np.hypot(*(end - start).T)))
    return judge_places(scene, found, end, max(PERMITTED * way, STILL * float(min(scene.radii))))


def judge_places(
    scene: Scene,
    found: NDArray[np.float64],
    right: NDArray[np.float64],
    permitted: float,
) -> Verdict:
    """Judge where balls are: (n, 2) [m], against where they should be."""
    off = np.hypot(*(found - right).T)
    if not np.all(np.isfinite(off)):
        return Verdict.of(scene, ["a position isn't finite"], 10.0)
    k = int(np.argmax(off))
    worst = float(off[k])
    faults = []
    if worst > permitted:
        faults.append(
            f'ball "{scene.balls[k].id}" is {worst:.3g} m off, more than {permitted:.3g} m'
        )
    return Verdict.of(scene, faults, worst / permitted, {"error": worst})
