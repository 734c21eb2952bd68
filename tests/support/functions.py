"""Functions as engines, and a valid answer of such a function."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ghostball.model import Scene
from ghostball.reference_adapters import ReferenceEngine
from ghostball.reference_adapters.function import engine_of
from ghostball.validation.scenes.library import find_scene

SCENE = find_scene("half-ball-cut")
ONE = find_scene("stop")


def still(scene: Scene, **more: Any) -> dict[str, Any]:
    """Return a valid answer for a shot in which nothing moves."""
    sample = (0.0, scene.positions, scene.velocities)
    return {"rest_positions": scene.positions, "events": [], "samples": [sample]} | more


def engine(function: Callable[..., Any], where: str = "mine:simulate") -> ReferenceEngine:
    return engine_of(function, where)()
