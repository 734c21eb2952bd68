"""The example engine of `ghostball init` is wrong only in inelastic collisions."""

import numpy as np
import pytest

from ghostball.reference_adapters import make_engine
from ghostball.validation.runs.engine_runs import run_engine, run_ours
from ghostball.validation.scenes.library import find_scene


@pytest.mark.parametrize("name", ["stop", "wall-bounce", "head-on"])
def test_the_error_of_the_first_engine_is_that_of_its_step(name):
    scene = find_scene(name)
    right = run_ours(scene).rest_positions
    errors = []
    for dt in (1e-2, 1e-3):
        engine = make_engine(f"ghostball.validation.examples.first_engine:simulate:dt={dt}")
        errors.append(np.abs(run_engine(engine, scene).rest_positions - right).max())
    fastest = np.linalg.norm(scene.velocities, axis=1).max()
    assert errors[0] < 4.0 * fastest * 1e-2
    assert errors[1] < 0.5 * errors[0]
