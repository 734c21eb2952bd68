"""Obstacles that no scene file can describe."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.engine.running import from_scene, obstacle_rows
from ghostball.model import Result, Scene

Play = Callable[..., Result]

_OWN = obstacle_rows.obstacles_of


def add_obstacles(monkeypatch: pytest.MonkeyPatch, *rows: Sequence[float]) -> None:
    """Add obstacles to every table, with the coefficients of the scene's cushions."""

    def obstacles_of(scene, *more):
        coefficients = obstacle_rows.coefficients_of(scene.physics)
        return np.vstack([_OWN(scene, *more), *((*row, *coefficients) for row in rows)])

    monkeypatch.setattr(from_scene, "obstacles_of", obstacles_of)


def played_among(monkeypatch: pytest.MonkeyPatch, scene: Scene, *rows: Sequence[float]) -> Result:
    """Simulate a scene with additional obstacles."""
    add_obstacles(monkeypatch, *rows)
    return simulate(scene, record="trajectory")
