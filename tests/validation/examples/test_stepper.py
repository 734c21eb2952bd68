"""The example engine with time steps detects contacts at most one step late."""

import numpy as np
import pytest

from ghostball.model import UnsupportedSceneError
from ghostball.validation.examples.stepper import Stepper, StepperSettings
from ghostball.validation.runs.engine_runs import run_engine, run_ours
from ghostball.validation.scenes.library import find_scene


def test_the_stepper_detects_collisions_at_most_a_step_late():
    engine, scene = Stepper(StepperSettings(dt=5e-3)), find_scene("head-on")
    run, right = (play(scene) for play in (lambda shot: run_engine(engine, shot), run_ours))
    first, true = (one.events["t"][one.events["kind"] == 0][0] for one in (run, right))
    assert true <= first <= true + 5e-3
    fastest = np.linalg.norm(scene.velocities, axis=1).max()
    assert engine.resolution(scene) == pytest.approx(5e-3 * fastest)


def test_the_stepper_refuses_unsupported_features():
    with pytest.raises(UnsupportedSceneError):
        Stepper().simulate(find_scene("draw-shot"))
