"""Run generated shots on engines: cases of the suite, like any other.

>>> from ghostball.validation.stress import StressSize, chosen_shots, run_stress
>>> outcome = run_stress(chosen_shots(StressSize(), ["grazing"]), ["ghostball"], Path("out"))
>>> outcome.exit_status
0
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from ghostball.reference_adapters import ReferenceEngine
from ghostball.reference_adapters.base import resolution_of
from ghostball.reference_adapters.registry import OURS, EngineUnavailableError, make_engine
from ghostball.validation.parallel.cluster import Cluster
from ghostball.validation.parallel.pool import Progress
from ghostball.validation.results.record_store import Name
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.runs.runner import Reuse
from ghostball.validation.stress.shots import StressShot
from ghostball.validation.suite.suite import SuiteResult, run_suite

DEFAULT_ENGINES: tuple[str, ...] = (
    "ghostball",
    "pymunk",
    "pymunk:contact_steps=exact",
    "pybullet",
    "pybullet:contact_steps=exact",
    "paper-discrete",
    "paper-continuous",
)
"""Engines that run if no engine is named."""


def run_stress(
    shots: Sequence[StressShot],
    labels: Sequence[str],
    out: Path,
    *,
    jobs: int = 1,
    cluster: Cluster | None = None,
    progress: Progress[CaseRecord] | None = None,
    compiling: Progress[str] | None = None,
    reuse: bool = True,
    announce: Callable[[Reuse[CaseRecord]], None] | None = None,
    time_limit: float | None = None,
    relations: Sequence[str] | None = None,
) -> SuiteResult:
    """Run shots on engines; results of other shots by the same code stay in the folder.

    `labels`: engines, each `NAME` or `NAME:key=value,...`.
    All other parameters are those of `suite.run_suite`; no motion is stored.

    Raises `GhostballError` before anything runs if an engine is unknown or the folder can't be
    used.
    """
    return run_suite(
        [one.scene for one in shots],
        labels,
        out,
        jobs=jobs,
        cluster=cluster,
        progress=progress,
        compiling=compiling,
        criteria={one.scene.name: one.criteria for one in shots},
        reuse=reuse,
        announce=announce,
        time_limit=time_limit,
        only=_pairs(shots, labels),
        keeps_motion=False,
        relations=relations,
    )


def _pairs(shots: Sequence[StressShot], labels: Sequence[str]) -> set[Name]:
    """Return the pairs of shot and engine, without those that would take hours."""
    pairs: set[Name] = set()
    for label in labels:
        try:
            engine = make_engine(label)
        except EngineUnavailableError:  # its cases report this
            engine = None
        pairs |= {(one.scene.name, label) for one in shots if _is_asked(one, engine)}
    return pairs


def _is_asked(shot: StressShot, engine: ReferenceEngine | None) -> bool:
    if shot.stepped or engine is None:
        return shot.stepped
    try:
        return engine.name == OURS or resolution_of(engine, shot.scene) in (0.0, "proved")
    except Exception:  # an engine of a user: its case fails later and reports the error
        return True
