"""How far the shots of a run can be predicted, kept in its results folder and measured once."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ghostball.engine import Scene, UnsupportedSceneError
from ghostball.engine.running.from_scene import admit
from ghostball.validation.diagnose.predictability.measure import predictability_of
from ghostball.validation.diagnose.predictability.prediction import (
    Predictability,
    PredictionStore,
)
from ghostball.validation.parallel.pool import Done, Progress
from ghostball.validation.results.record_store import Name
from ghostball.validation.results.records import scene_hash
from ghostball.validation.runs.runner import run
from ghostball.validation.suite.unchanged import code_hash


def predict_scenes(
    scenes: Sequence[Scene],
    folder: Path,
    *,
    reuse: bool = True,
    progress: Progress[Predictability] | None = None,
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
        Called with how many are known, of how many, and the last that was measured.

    Raises
    ------
    ResultsError
        Where the folder can't be read or written.
    KeyboardInterrupt
        What was measured until then is kept.
    """
    asked: dict[Name, Scene] = {(scene.name,): scene for scene in scenes if _is_represented(scene)}
    ran = run(
        {name: scene_hash(scene) for name, scene in asked.items()},
        lambda names: (asked[name] for name in names),
        predictability_of,
        _measured,
        PredictionStore(folder, code_hash()),
        reuse=reuse,
        progress=progress,
    )
    if ran.interrupted:
        raise KeyboardInterrupt
    return [ran.records[name] for name in asked]


def _measured(done: Done[Scene, Predictability]) -> Predictability:
    assert done.given is not None  # it is measured in this process
    return done.given


def _is_represented(scene: Scene) -> bool:
    try:
        admit(scene)
    except UnsupportedSceneError:
        return False
    return True
