"""Plays a shot of the board on an engine, as that can."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ghostball.engine import EngineFailedError, Record, Result, Scene
from ghostball.reference_adapters.base import ReferenceEngine
from ghostball.validation.runs.playing import ONE_BY_ONE, run_as_it_can


def play(engine: ReferenceEngine, scene: Scene, record: Record = "rest") -> Result:
    """Play a shot as an engine can: as it is, or with balls that slide, or one impact by one.

    Where nothing slows a ball, one that slides goes as one that always rolls; and where no two
    balls are hit at once, nor does the order of impacts matter.
    """
    variants: list[Mapping[str, Any]] = [{}, ONE_BY_ONE]
    if scene.physics.motion == "rolling":
        sliding: dict[str, Any] = {"motion": "sliding"}
        if not np.any(scene.rolling_frictions):
            sliding["sliding_friction"] = 0.0
        variants += [sliding, {**sliding, **ONE_BY_ONE}]
    result = run_as_it_can(engine, scene, variants, record)
    if not result.status.complete:
        raise EngineFailedError(engine.name, f"no end: {result.reason}")
    return result
