"""Certified results of a scene as a `Result`."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from ghostball.model import COLLISION_KINDS, EVENT_DTYPE, Record, Result, Samples, Scene, Status
from ghostball.model.arrays import FloatArray
from ghostball.model.features import Capabilities
from ghostball.reference_adapters.base import EngineBase, EngineSettings
from ghostball.reference_adapters.certified.api import CAPABILITIES, NAME, certify
from ghostball.reference_adapters.certified.certificate import Certificate, Enclosure, Ending
from ghostball.reference_adapters.certified.settings import CertifiedSettings

_STATUS: dict[Ending, Status] = {
    "event limit": Status.EVENT_LIMIT,
    "ambiguous": Status.UNPROVED,
    "sustained contact": Status.UNPROVED,
    "precision cap": Status.UNPROVED,
    "time limit": Status.UNPROVED,
}


class CertifiedEngine(EngineBase):
    """The same model in ball arithmetic, with proved events; see `reference_adapters.certified`."""

    name: ClassVar[str] = NAME
    Settings: ClassVar[type[EngineSettings]] = CertifiedSettings

    @property
    def capabilities(self) -> Capabilities:
        """How each feature of a scene is supported; the same for all settings."""
        return CAPABILITIES

    def resolution(self, scene: Scene) -> Literal["proved"]:  # noqa: ARG002
        """Return "proved", because the positions are certified."""
        return "proved"

    def certify(self, scene: Scene, *, motion: bool = False) -> Certificate:
        """Return the certificate; see `certify`."""
        return certify(scene, self.settings, motion=motion)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Return the certified result, rounded to the nearest doubles.

        If the proof ends early, the final state is that after the last proved event, and `reason`
        names the cause. `wall_time` is that of the computation, even if the certificate was read
        from the disk.

        Raises `UnsupportedSceneError` if the scene has physics that can't be certified.
        """
        self.check(scene)
        certificate = self.certify(scene, motion=record == "trajectory")
        return result_of(scene, certificate, self.settings, record)


def result_of(
    scene: Scene, certificate: Certificate, settings: CertifiedSettings, record: Record
) -> Result:
    """Return a certificate as a `Result`."""
    counts = dict.fromkeys((kind.label for kind in COLLISION_KINDS), 0)
    for event in certificate.events:
        if event.kind in COLLISION_KINDS:
            counts[event.kind.label] += 1
    if certificate.proved:
        status = Status.REST if certificate.rested else Status.T_MAX
    else:
        status = _STATUS[certificate.ending]
    t_end = float(certificate.t_end)
    events = None
    if record != "rest":
        rows = [(float(e.t), int(e.kind), e.a, e.b) for e in certificate.events]
        events = np.array(rows, dtype=EVENT_DTYPE)
    return Result(
        engine=NAME,
        settings=settings.model_dump(),
        scene=scene,
        status=status,
        final_state=_final_state(scene, certificate),
        rest_time=t_end,
        collision_counts=counts,
        work={
            "events": certificate.events_proved,
            "ties": sum(event.tie for event in certificate.events),
            "precision": certificate.precision,
        },
        wall_time=certificate.seconds,
        events=events,
        trajectory=certificate.trajectory(scene),
        reason="" if certificate.proved else f"{certificate.ending}: {certificate.reason}",
    )


def _final_state(scene: Scene, certificate: Certificate) -> Samples:
    n = len(scene.balls)
    positions, velocities = np.zeros((1, n, 3)), np.zeros((1, n, 3))
    dimensions = 3 if scene.physics.airborne else 2
    positions[0, :, 2] = scene.radii
    positions[0, :, :dimensions] = _nearest(certificate.positions)
    velocities[0, :, :dimensions] = _nearest(certificate.velocities)
    return Samples(positions, velocities, _nearest(certificate.spins)[np.newaxis])


def _nearest(vectors: tuple[tuple[Enclosure, ...], ...]) -> FloatArray:
    return np.array([[float(e) for e in vector] for vector in vectors], dtype=np.float64)
