"""Attribute many differences, in several processes."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from engine import Scene, UnsupportedSceneError
from reference_adapters import make_engine
from reference_adapters.registry import EngineUnavailableError, parse_spec
from validation.attribution._attribute import attribute
from validation.attribution._file import (
    belongs_to,
    read_attributions,
    write_attributions,
)
from validation.attribution.records import Attribution
from validation.compiling import compile_kernels
from validation.files import ResultsError
from validation.known_shot import ENGINES, KnownShot, known_shot
from validation.records import scene_hash
from validation.store import CaseRecord, ResultsFolder
from validation.worker import limit_of, run_tasks

_LOGGER = logging.getLogger("ghostball.validation")

Pair = tuple[Scene, str]
"""A scene, and an engine with its settings."""

TRUE = frozenset(ENGINES.values())
"""Engines whose motion is taken for the truth."""

Progress = Callable[[int, int, str], None]
"""Called with how many are done, of how many, and which was the last."""


def attribute_many(
    pairs: Sequence[Pair],
    *,
    jobs: int = 1,
    progress: Progress | None = None,
    time_limit: float | None = None,
) -> list[Attribution]:
    """Attribute the difference of each scene and engine, in their order.

    Parameters
    ----------
    pairs : sequence of (Scene, str)
        Those that an engine can't represent, or whose engine can't run here, are left out of what
        is returned.
    jobs : int
        Processes; 1, without a `time_limit`, is this one. With others, guard a script with
        `if __name__ == "__main__"`.
    progress : callable, optional
        See `Progress`.
    time_limit : float, optional [s]
        For each, which then runs in another process: one that takes longer, or whose engine
        crashes, is "not compared".

    Raises
    ------
    GhostballError
        Where an engine is unknown, or a scene has no truth.
    """
    done: dict[int, Attribution | None] = {}

    # Processes, not threads: the precision of ball arithmetic belongs to the process.
    tasks = run_tasks(
        enumerate(pairs), min(jobs, max(len(pairs), 1)), _numbered, _died, limit_of(time_limit)
    )
    with closing(tasks) as found:
        for index, one in found:
            done[index] = one
            if progress is not None:
                scene, label = pairs[index]
                progress(len(done), len(pairs), f"{scene.name} on {label}")
    return [one for index in range(len(pairs)) if (one := done[index]) is not None]


def attribute_results(
    results: ResultsFolder,
    *,
    jobs: int = 1,
    progress: Progress | None = None,
    time_limit: float | None = None,
) -> list[Attribution]:
    """Attribute every difference of a results folder, and write `attributions.jsonl` there.

    Parameters are those of `attribute_many`. Those that an earlier call left there, of the very
    same cases, are kept. Our engine and the certified one are left out: they are the truth.

    Raises
    ------
    GhostballError
        Where an attribution can't be computed, or nothing can be written.
    """
    wanted = [case for case in results.cases if case.outcome == "ran" and case.engine not in TRUE]
    earlier = _readable(results.path)
    kept = {
        _key(case): one
        for case in wanted
        for one in earlier
        if case.code_hash and belongs_to(one, case)
    }
    missing = [case for case in wanted if _key(case) not in kept]
    pairs = [(case.load_scene(), case.label) for case in missing]
    compile_kernels([scene for scene, _ in pairs], jobs, tangents=True)
    codes = {_key(case): case.code_hash for case in missing}
    for one in attribute_many(pairs, jobs=jobs, progress=progress, time_limit=time_limit):
        kept[one.scene, one.label] = replace(one, code_hash=codes[one.scene, one.label])
    found = [kept[_key(case)] for case in wanted if _key(case) in kept]
    write_attributions(results.path, found)
    return found


def _readable(folder: Path) -> list[Attribution]:
    """Return what an earlier call left; what can't be read is nothing to take over."""
    try:
        return read_attributions(folder)
    except ResultsError as error:
        _LOGGER.warning("no attribution is taken over: %s", error)
        return []


def attributions_of(results: ResultsFolder) -> list[Attribution]:
    """Return the attributions that a results folder holds of its very cases, scene by scene.

    One of another version of the code or of the scene is none of them.
    """
    stored = {(one.scene, one.label): one for one in read_attributions(results.path)}
    cases = {_key(case): case for case in results.cases}
    return [
        one
        for scene in results.scene_names
        for label in results.labels
        if (one := stored.get((scene, label))) is not None
        and (case := cases.get((scene, label))) is not None
        and belongs_to(one, case)
    ]


def _key(case: CaseRecord) -> tuple[str, str]:
    return case.scene, case.label


def _numbered(task: tuple[int, Pair]) -> tuple[int, Attribution | None]:
    index, pair = task
    return index, _one(pair)


def _died(task: tuple[int, Pair], reason: str) -> tuple[int, Attribution | None]:
    index, pair = task
    return index, _not_compared(pair, reason)


def _one(pair: Pair) -> Attribution | None:
    scene, label = pair
    try:
        engine = make_engine(label)
        found = attribute(scene, engine, label=label, known=_known(scene))
    except (UnsupportedSceneError, EngineUnavailableError):
        return None  # the results say so, with the reason
    # An engine may raise anything at a step that it wasn't asked to take before: kept, never fatal.
    except Exception as error:
        return _not_compared(pair, f"{type(error).__name__}: {error}")
    return replace(found, definition_hash=scene_hash(scene))


def _not_compared(pair: Pair, reason: str) -> Attribution:
    scene, label = pair
    _LOGGER.warning("%s on %s: not attributed: %s", scene.name, label, reason)
    name = parse_spec(label)[0]
    found = Attribution(scene.name, label, name, "not compared", "our engine", reason=reason)
    return replace(found, definition_hash=scene_hash(scene))


@lru_cache(maxsize=2)
def _known(scene: Scene) -> KnownShot:
    return known_shot(scene)
