"""How far the shots of a run can be predicted, kept in its results folder and measured once."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from engine import Scene, UnsupportedSceneError
from validation.diagnose.predictability.measure import predictability_of
from validation.diagnose.predictability.prediction import Predictability
from validation.diagnose.predictability.prediction_file import (
    load_predictability,
    save_predictability,
)
from validation.results.files import ResultsError
from validation.results.records import scene_hash
from validation.suite.unchanged import Code

logger = logging.getLogger("ghostball.validation")

Progress = Callable[[int, int, str], None]
"""Called before each scene with how many are done, how many there are, and the scene's name."""


def predict_scenes(
    scenes: Sequence[Scene], folder: Path, *, reuse: bool = True, progress: Progress | None = None
) -> list[Predictability]:
    """Measure how far each shot can be predicted, and store that in a results folder.

    Parameters
    ----------
    scenes : sequence of Scene
        What our engine doesn't represent, nothing is said of.
    folder : Path
    reuse : bool
        Whether what the folder holds is kept where it was measured of the very scene by the very
        code; see `validation.suite.unchanged`.
    progress : callable, optional
        See `Progress`.

    Raises
    ------
    ResultsError
        Where the folder can't be written.
    """
    code = Code.now()
    earlier = _earlier(folder) if reuse and code.hash else {}
    known = []
    for done, scene in enumerate(scenes):
        if progress is not None:
            progress(done, len(scenes), scene.name)
        stored = earlier.get(scene.name)
        if stored is not None and (stored.definition_hash, stored.code_hash) == (
            scene_hash(scene),
            code.hash,
        ):
            known.append(stored)
            continue
        try:
            measured = predictability_of(scene)
        except UnsupportedSceneError:
            continue
        known.append(replace(measured, code_hash=code.hash if code.holds() else ""))
    save_predictability(folder, known)
    return known


def _earlier(folder: Path) -> dict[str, Predictability]:
    try:
        return load_predictability(folder)
    except ResultsError as error:
        logger.warning("every shot is predicted anew, and the file replaced: %s", error)
        return {}
