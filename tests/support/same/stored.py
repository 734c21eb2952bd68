"""Checks that a scene, a run and a certificate are bit-identical after storing and reading."""

from __future__ import annotations

import tempfile
from dataclasses import fields
from pathlib import Path
from typing import Any, Final

import numpy as np
from stored_records import record

from ghostball.model import Scene, UnsupportedSceneError, energy_of
from ghostball.model.scene import toml
from ghostball.reference_adapters.certified import Certificate, CertifiedSettings, certify
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.results.records import status_name
from ghostball.validation.results.store import Results, ResultsWriter
from ghostball.validation.runs.sampling import motion_of
from same.plays import played

PROOF: Final = CertifiedSettings(start_precision=106, max_precision=106, max_events=2)
"""Limits of the proof of a scene; a certificate with two events has all kinds of stored values."""


def scene_file(scene: Scene) -> str | None:
    """Return the difference of a scene after writing it as TOML or JSON and reading it."""
    for name, other in (
        ("TOML", Scene.loads(toml.dumps(scene))),
        ("JSON", Scene.model_validate_json(scene.model_dump_json(by_alias=True))),
    ):
        # Compared as text, which distinguishes 0.0 and -0.0.
        if repr(other) != repr(scene):
            return f"the scene read back from {name} is {other!r} instead of {scene!r}"
    return None


def results(scene: Scene) -> str | None:
    """Return the difference of a run after storing it in a results folder and reading it."""
    result = played(scene)
    end = energy_of(scene, result.final_state)
    case = record(
        OURS,
        scene,
        settings=dict(result.settings),
        status=status_name(result.status),
        rest_positions=result.rest_positions,
        rest_time=float(result.rest_time),
        collision_counts=dict(result.collision_counts),
        energy_final=float(end.total[0]),
        work=dict(result.work),
    )
    motion = motion_of(result)
    with tempfile.TemporaryDirectory() as folder:
        writer = ResultsWriter(Path(folder, "results"))
        writer.begin({})
        writer.write((case, motion))
        writer.finish("complete")
        read = Results.open(writer.path)
        (other,) = read.cases
        moved = read.motion(other)
    assert moved is not None
    return _other_field("record", case, other) or _other_field("motion", motion, moved)


def proof(scene: Scene) -> str | None:
    """Return the difference of a certificate after storing and reading it."""
    try:
        certificate = certify(scene, PROOF, motion=True, cached=False)
    except UnsupportedSceneError:  # a slide in air
        return None
    return _other_field("proof", certificate, Certificate.from_json(certificate.to_json()))


def _other_field(what: str, one: Any, other: Any) -> str | None:
    for field in fields(one):
        ours, theirs = getattr(one, field.name), getattr(other, field.name)
        if not _equal(ours, theirs):
            return f"{field.name} of the {what} read back is {theirs!r} instead of {ours!r}"
    return None


def _equal(one: Any, other: Any) -> bool:
    if isinstance(one, tuple) and one and isinstance(one[0], np.ndarray):
        return len(one) == len(other) and all(map(_equal, one, other))
    if isinstance(one, np.ndarray):
        same_kind = isinstance(other, np.ndarray) and (one.shape, one.dtype) == (
            other.shape,
            other.dtype,
        )
        return same_kind and one.tobytes() == other.tobytes()
    return bool(one == other)
