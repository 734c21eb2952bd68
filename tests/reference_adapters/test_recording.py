"""The recorder of a time-stepping engine."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.model import Ball, Scene, Status, rolling_angular_velocity
from ghostball.reference_adapters.recording import FRAME_INTERVAL, Recorder, rolling_state

BALLS = [
    Ball(id="a", position=(0.0, 0.0), radius=0.03),
    Ball(id="b", position=(1.0, 0.5), velocity=(1.0, -2.0), radius=0.02),
]
SCENE = Scene(name="two", balls=BALLS)


def test_frames_are_kept_a_while_apart_or_by_force_and_at_the_end():
    recorder = Recorder(SCENE, "trajectory")
    random = np.random.default_rng(3)
    for step in range(9):
        positions, velocities = random.normal(size=(2, 1, 2, 2))
        state = rolling_state(positions, velocities, SCENE.radii)
        recorder.frame(0.4 * FRAME_INTERVAL * step, state, force=step == 4)
    result = recorder.result(
        engine="any", settings={}, status=Status.REST, final_state=state, rest_time=0.1, work={}
    )
    steps = result.trajectory.times[:-1] / (0.4 * FRAME_INTERVAL)
    assert steps.tolist() == pytest.approx([0, 3, 4, 7])
    assert result.trajectory.times[-1] == 0.1


def test_a_rolling_state_lies_on_the_cloth_and_spins_as_it_rolls():
    positions, velocities = np.ones((2, 1, 2, 2))
    state = rolling_state(positions, velocities, SCENE.radii)
    assert state.positions[0, :, 2].tolist() == [0.03, 0.02]
    assert state.velocities[0, :, 2].tolist() == [0.0, 0.0]
    spins = rolling_angular_velocity(state.velocities[0], SCENE.radii)
    assert state.angular_velocities[0].tolist() == spins.tolist()
