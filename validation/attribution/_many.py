"""Attribute many differences, in several processes."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from functools import lru_cache

from engine import Scene, UnsupportedSceneError
from reference_adapters import make_engine
from reference_adapters.registry import EngineUnavailableError
from validation.attribution._attribute import attribute
from validation.attribution._file import scene_hash
from validation.attribution.records import Attribution
from validation.known_shot import KnownShot, known_shot

Pair = tuple[Scene, str]
"""A scene, and an engine with its settings."""

Progress = Callable[[int, int, str], None]
"""Called with how many are done, of how many, and which was the last."""


def attribute_many(
    pairs: Sequence[Pair],
    *,
    jobs: int = 1,
    progress: Progress | None = None,
    code_hash: str = "",
) -> list[Attribution]:
    """Attribute the difference of each scene and engine, in their order.

    Parameters
    ----------
    pairs : sequence of (Scene, str)
        Those that an engine can't represent, or whose engine can't run here, are left out of what
        is returned.
    jobs : int
        Processes. With more than one, guard a script with `if __name__ == "__main__"`.
    progress : callable, optional
        See `Progress`.
    code_hash : str
        Kept in the records.

    Raises
    ------
    GhostballError
        Where an engine is unknown, or a scene has no truth.
    """
    done: dict[int, Attribution | None] = {}

    def note(index: int, found: Attribution | None) -> None:
        done[index] = found
        if progress is not None:
            scene, label = pairs[index]
            progress(len(done), len(pairs), f"{scene.name} on {label}")

    if jobs == 1 or len(pairs) < 2:
        for index, pair in enumerate(pairs):
            note(index, _one(pair))
    else:
        # Not fork: pybullet's and numba's threads and locks don't survive it. Nor threads: the
        # precision of ball arithmetic belongs to the process.
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(min(jobs, len(pairs)), mp_context=context) as pool:
            waiting = {pool.submit(_one, pair): index for index, pair in enumerate(pairs)}
            try:
                for future in as_completed(waiting):
                    note(waiting[future], future.result())
            finally:
                pool.shutdown(wait=True, cancel_futures=True)
    found = (done[index] for index in range(len(pairs)))
    return [replace(one, code_hash=code_hash) for one in found if one is not None]


def _one(pair: Pair) -> Attribution | None:
    scene, label = pair
    try:
        engine = make_engine(label)
        engine_can = attribute(scene, engine, label=label, known=_known(scene))
    except (UnsupportedSceneError, EngineUnavailableError):
        return None  # the results say so, with the reason
    return replace(engine_can, definition_hash=scene_hash(scene))


@lru_cache(maxsize=2)
def _known(scene: Scene) -> KnownShot:
    return known_shot(scene)
