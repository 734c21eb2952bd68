"""What a stepping engine records: frames of balls that roll are the whole states, to the bit."""

from __future__ import annotations

import numpy as np

from ghostball.model import Ball, Scene, Status, rolling_angular_velocity
from ghostball.reference_adapters.recording import FRAME_INTERVAL, Recorder, rolling_state

BALLS = [
    Ball(id="a", position=(0.0, 0.0), radius=0.03),
    Ball(id="b", position=(1.0, 0.5), velocity=(1.0, -2.0), radius=0.02),
]
SCENE = Scene(name="two", balls=BALLS)


def recorded(rolling: bool):
    recorder = Recorder(SCENE, "trajectory")
    random = np.random.default_rng(3)
    state = None
    for step in range(9):
        t, force = 0.4 * FRAME_INTERVAL * step, step == 4
        positions, velocities = random.normal(size=(2, 2, 2))
        state = rolling_state(positions[np.newaxis], velocities[np.newaxis], SCENE.radii)
        if rolling:
            recorder.rolling_frame(t, positions, velocities, force=force)
        else:
            recorder.frame(t, state, force=force)
    result = recorder.result(
        engine="any", settings={}, status=Status.REST, final_state=state, rest_time=0.1, work={}
    )
    return result.trajectory


def test_frames_of_rolling_balls_are_the_whole_states_to_the_bit():
    # Breaks where such a frame is kept at other instants, or completed by another formula.
    whole, rolling = recorded(False), recorded(True)
    assert len(whole.times) == 5  # steps 0, 3, 4 (by force) and 7, and the end
    for name in ("times", "positions", "velocities", "angular_velocities"):
        assert getattr(rolling, name).tobytes() == getattr(whole, name).tobytes()


def test_a_rolling_state_lies_on_the_cloth_and_spins_as_it_rolls():
    positions, velocities = np.ones((2, 1, 2, 2))
    state = rolling_state(positions, velocities, SCENE.radii)
    assert state.positions[0, :, 2].tolist() == [0.03, 0.02]
    assert state.velocities[0, :, 2].tolist() == [0.0, 0.0]
    spins = rolling_angular_velocity(state.velocities[0], SCENE.radii)
    assert state.angular_velocities[0].tolist() == spins.tolist()
