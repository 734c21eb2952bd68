"""Simulations by pooltool, if installed."""

from __future__ import annotations

import numpy as np
import pytest
from engine_facts import needs, play

from ghostball.engine import simulate
from ghostball.model import UnsupportedSceneError
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.runs.engine_runs import run_engine
from ghostball.validation.scenes.library import find_scene


@needs("pooltool")
@pytest.mark.slow
def test_pooltool_parts_balls_by_a_micrometre() -> None:
    for name in ("follow-shot", "sliding-swerve", "han-check", "cushion-stronge"):
        scene = find_scene(name)
        result = run_engine(make_engine("pooltool"), scene)
        truth = simulate(scene, record="events")
        assert np.abs(result.rest_positions - truth.rest_positions).max() < 2e-6, name
        assert result.collision_counts == truth.collision_counts
    with pytest.raises(UnsupportedSceneError, match="slide before they roll"):
        play("pooltool", find_scene("half-ball-cut"))
