"""How far the shots of a run can be predicted, kept in its results folder and measured once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from ghostball.engine import Scene, UnsupportedSceneError
from ghostball.validation.diagnose.predictability.measure import predictability_of
from ghostball.validation.diagnose.predictability.prediction import (
    Predictability,
    load_predictability,
    save_predictability,
)
from ghostball.validation.results.records import scene_hash
from ghostball.validation.suite.unchanged import code_hash

Progress = Callable[[int, int, str], None]
"""Called before each scene with how many are done, how many there are, and the scene's name."""


def predict_scenes(
    scenes: Sequence[Scene], folder: Path, *, reuse: bool = True, progress: Progress | None = None
) -> list[Predictability]:
    """Measure how far each shot can be predicted, and store each in a results folder at once.

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
        Where the folder can't be read or written.
    """
    code = code_hash()
    earlier = load_predictability(folder) if reuse and code else {}
    known: list[Predictability] = []

    def measured() -> Iterator[Predictability]:
        for done, scene in enumerate(scenes):
            if progress is not None:
                progress(done, len(scenes), scene.name)
            stored = earlier.get(scene.name)
            asked = (scene_hash(scene), code)
            if stored is None or (stored.definition_hash, stored.code_hash) != asked:
                try:
                    stored = replace(predictability_of(scene), code_hash=code)
                except UnsupportedSceneError:
                    continue
                yield stored
            known.append(stored)

    save_predictability(folder, measured())
    return known
