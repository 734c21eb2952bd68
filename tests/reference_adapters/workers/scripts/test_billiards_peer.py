"""Simulations by python-billiards, if installed."""

from __future__ import annotations

import numpy as np
import pytest
from engine_facts import needs, play, rack

from ghostball.engine import simulate
from ghostball.model import UnsupportedSceneError
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.runs.engine_runs import run_engine
from ghostball.validation.scenes.library import find_scene


@needs("billiards")
def test_billiards_is_exact() -> None:
    scene = find_scene("galperin-1")
    result = run_engine(make_engine("billiards"), scene)
    truth = simulate(scene, record="events")
    assert np.abs(result.rest_positions - truth.rest_positions).max() < 1e-12
    assert result.collision_counts == truth.collision_counts
    energy = run_engine(make_engine("billiards"), rack()).energy(np.linspace(0, 1, 101)).total
    assert energy == pytest.approx(energy[0], rel=1e-12)
    with pytest.raises(UnsupportedSceneError, match="no friction"):
        play("billiards", find_scene("draw-shot"))
