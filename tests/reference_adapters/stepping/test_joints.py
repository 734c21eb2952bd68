"""Rolling balls that the joints of an engine slow: where they stop, to the engine's rounding."""

from __future__ import annotations

import numpy as np
import pytest
from engine_facts import needs, play
from shots import ball, scene_of

from ghostball.model import EventKind, Scene, UnsupportedSceneError
from ghostball.validation.scenes.library import find_scene

DT = 1e-3
SLOWING = 0.02 * 9.81
SPEED = 1000.5 * SLOWING * DT  # [m/s]: the joints stop the ball in the middle of a step
ENGINES = {"pymunk": 0.5 * SPEED * DT, "box2d": -0.5 * SPEED * DT}
"""How much too far a ball rolls [m]: a joint acts after, or before, the ball has moved."""


def roll() -> Scene:
    return scene_of(ball((0, 0), (0.6 * SPEED, 0.8 * SPEED)), rolling_friction=0.02)


@pytest.mark.parametrize(
    ("name", "too_far"), [pytest.param(*fact, marks=needs(fact[0])) for fact in ENGINES.items()]
)
def test_a_joint_stops_a_ball_half_a_step_early_or_late(name: str, too_far: float) -> None:
    """Fails if the adapter shifts velocities, with a wrong force, or with an inexact stop."""
    result = play(f"{name}:cloth=own", roll(), record="events")
    assert result.events is not None
    distance = np.hypot(*result.rest_positions[0, :2])
    exact = SPEED**2 / (2.0 * SLOWING)
    assert distance - exact == pytest.approx(too_far, rel=0.01)
    assert result.rest_time == pytest.approx(SPEED / SLOWING, abs=1.01 * DT)
    assert result.events["kind"].tolist() == [EventKind.ROLL_TO_REST]


@pytest.mark.parametrize("name", [pytest.param(name, marks=needs(name)) for name in ENGINES])
def test_a_joint_knows_no_slip(name: str) -> None:
    with pytest.raises(UnsupportedSceneError, match="without slip and spin"):
        play(f"{name}:cloth=own", find_scene("slide-to-rest"))
