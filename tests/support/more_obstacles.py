"""Obstacles on a table that no scene can have yet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from ghostball.engine.running import from_scene

_OWN = from_scene.obstacles_of


def add_obstacles(monkeypatch: pytest.MonkeyPatch, *rows: Sequence[float]) -> None:
    """Let every table have these rows too, with the coefficients of the scene's cushions."""

    def obstacles_of(scene, *more):
        coefficients = from_scene.coefficients_of(scene.physics)
        return np.vstack([_OWN(scene, *more), *((*row, *coefficients) for row in rows)])

    monkeypatch.setattr(from_scene, "obstacles_of", obstacles_of)
