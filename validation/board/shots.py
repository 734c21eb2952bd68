"""The shots of the board: scene files, and each as an engine can play it."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, Final

import numpy as np

from ghostball.engine import Scene
from ghostball.engine.scene.features import missing_features
from ghostball.reference_adapters.base import ReferenceEngine

FOLDER: Final = Path(str(files("ghostball.validation.board")))
"""Where the lists of columns lie, and in scenes/ what they play."""


def scene_path(name: str) -> Path:
    """Return the file of a scene of the board."""
    return FOLDER / "scenes" / f"{name}.toml"


@cache
def board_scene(name: str) -> Scene:
    """Return a scene of the board."""
    return Scene.load(scene_path(name))


def playable(scene: Scene, engine: ReferenceEngine) -> Scene:
    """Return a scene as an engine can play it: as it is, impact by impact, or with sliding balls.

    Where nothing slows a ball, one that slides goes as one that always rolls; and where no two
    balls are hit at once, nor does the order of impacts matter. As it is where none of that helps.
    """
    sliding: dict[str, Any] = {}
    if scene.physics.motion == "rolling":
        sliding = {"motion": "sliding"}
        if not np.any(scene.rolling_frictions):
            sliding["sliding_friction"] = 0.0
    for more in ({}, sliding):
        for impacts in ({}, {"impacts": "sequential"}):
            changes = {**more, **impacts}
            physics = scene.physics.model_copy(update=changes)
            name = "-".join([scene.name, *(["sliding"] if more else []), *impacts.values()])
            shot = scene.model_copy(update={"physics": physics, "name": name})
            if _can_play(engine, shot):
                return shot
    return scene


def _can_play(engine: ReferenceEngine, scene: Scene) -> bool:
    lacks = getattr(engine, "lacks", None)
    return not missing_features(engine.capabilities, scene) and not (lacks and lacks(scene))
