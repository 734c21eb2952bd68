"""The best known motion of a scene, and its source.

`explain` compares a run with this motion, which can be sampled at any time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ghostball.model import GhostballError, Result, Scene
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.certified import CertifiedSettings
from ghostball.reference_adapters.certified.engine import result_of
from ghostball.validation.runs.engine_runs import run_ours
from ghostball.validation.truth.certificates import certificate_of
from ghostball.validation.truth.closed_forms import closed_form
from ghostball.validation.truth.integration import integrated, may_be_integrated
from ghostball.validation.truth.scene_truth import truth_of

KnownBy = Literal["certified", "closed form", "integration", "our engine"]
"""Source of a motion; a closed form gives only its end, and Ghostball's engine the rest."""

ENGINES: dict[KnownBy, str] = {
    "certified": "certified",
    "closed form": "ghostball",
    "integration": "integration",
    "our engine": "ghostball",
}
"""Name of the engine that computed the motion."""


class NoKnownShotError(GhostballError):
    """A scene without any known motion."""


@dataclass(frozen=True, eq=False)
class KnownShot:
    """The best known motion of a scene.

    `result`: with its trajectory.
    `rest_positions` (n, 3) float64 [m]: final positions of the balls.
    `why`: why it isn't certified; else "".
    """

    kind: KnownBy
    result: Result
    rest_positions: FloatArray
    why: str = ""

    @property
    def engine(self) -> str:
        """Name of the engine that computed the motion."""
        return ENGINES[self.kind]

    @property
    def scene(self) -> Scene:
        """The scene."""
        return self.result.scene

    def positions(self, instant: float | None) -> FloatArray:
        """Return the centres at a time [s], or at the end: (n, 2) float64 [m]."""
        if instant is None:
            return self.rest_positions[:, :2]
        centres: FloatArray = self.result.sample([instant]).positions[0, :, :2]
        return centres


def farthest(one: Result, other: Result, times: FloatArray) -> FloatArray:
    """Return the largest horizontal distance of a ball between two runs, (k,) [m], at some times.

    `times` (k,) float64 [s].
    """
    a, b = (run.sample(times).positions[..., :2] for run in (one, other))
    found: FloatArray = np.max(np.linalg.norm(a - b, axis=2), axis=1)
    return found


def known_shot(scene: Scene) -> KnownShot:
    """Return the best known motion of a scene.

    Raises `NoKnownShotError` if it can't be certified and Ghostball's engine doesn't finish;
    `UnsupportedSceneError` if neither supports the scene.
    """
    certificate, why = certificate_of(scene)
    if certificate is not None and certificate.proved:
        certified = result_of(scene, certificate, CertifiedSettings(), "trajectory")
        return KnownShot("certified", certified, certified.rest_positions)
    why = why if certificate is None else f"{certificate.ending}: {certificate.reason}"
    ours = run_ours(scene)
    if not ours.status.complete:
        raise NoKnownShotError(
            f'scene "{scene.name}": there is no reference result: it isn\'t certified ({why}), and '
            f"Ghostball's engine stopped early: {ours.status.value}"
        )
    if closed_form(scene) is not None:
        truth = truth_of(scene, "closed-form", parts={"rest"})
        assert truth.rest_positions is not None  # a closed form always has them
        return KnownShot("closed form", ours, truth.rest_positions, why)
    if may_be_integrated(scene):
        integration, _ = integrated(scene)
        if integration is not None:
            motion = result_of(scene, integration.shot, CertifiedSettings(), "trajectory")
            return KnownShot("integration", motion, motion.rest_positions, why)
    return KnownShot("our engine", ours, ours.rest_positions, why)
