"""Friction of balls and cushions in Pymunk, compared with closed forms and Ghostball's engine."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shots import R, ball, random_cloth_shot, scene_of

from ghostball.engine import simulate
from ghostball.model import Result, Scene
from ghostball.model.features import missing_features
from ghostball.reference_adapters.pymunk.engine import PymunkEngine, PymunkSettings

TOUCHING = 2 * R * (1 + 1e-9)


def exact(scene: Scene) -> Result:
    return PymunkEngine(PymunkSettings(contact_steps="exact")).simulate(scene, record="events")


def cut_shot(
    cut: float, speed: float, spin: tuple[float, float, float], **physics: object
) -> Scene:
    """Return an immediate collision at an angle `cut` [rad], on a cloth without friction."""
    return scene_of(
        ball((0, 0), (speed, 0), angular_velocity=spin),
        ball((TOUCHING * math.cos(cut), TOUCHING * math.sin(cut))),
        t_max=1e-3,
        **{"motion": "sliding", "sliding_friction": 1e-9, "rolling_friction": 0.0, **physics},
    )


def throw(result: Result, cut: float) -> float:
    """Return the angle of the object ball from the line of centres, towards the cue ball's path."""
    vx, vy, _ = result.final_state.velocities[0, 1]
    return cut - math.atan2(vy, vx)


@pytest.mark.parametrize("speed", [0.5, 3.0])
@pytest.mark.parametrize("cut", [0.2, 1.1])
@pytest.mark.parametrize("friction", [0.02, 0.06, "alciatore"])
@pytest.mark.parametrize("side", [0.0, 0.4, -0.4])
def test_throw_of_a_collision_without_topspin(
    speed: float, cut: float, friction: float | str, side: float
) -> None:
    """Alciatore, proof A.14: tan = min(mu v cos / slip, 1/7) slip / (v cos), with mu at this slip.

    Fails for the inertia of a disc (1/3) instead of a sphere, or for the coefficient at another
    speed.
    """
    spin = side * speed / R
    slip = speed * math.sin(cut) - R * spin
    mu = 9.951e-3 + 0.108 * math.exp(-1.088 * abs(slip)) if friction == "alciatore" else friction
    along = speed * math.cos(cut)
    expected = math.atan(math.copysign(min(mu, abs(slip) / along / 7), slip))
    scene = cut_shot(cut, speed, (0, 0, spin), ball_friction=friction)
    assert throw(exact(scene), cut) == pytest.approx(expected, abs=1e-7)


# --- Ghostball's engine as the reference ------------------------------------------------------

ENGINE = PymunkEngine(PymunkSettings(contact_steps="exact"))
REPRESENTED = [
    seed for seed in range(25) if not missing_features(ENGINE.capabilities, random_cloth_shot(seed))
]


@pytest.mark.parametrize("seed", REPRESENTED)
def test_exact_steps_play_the_game_that_our_engine_plays(seed: int) -> None:
    """Only for a few collisions, because each one amplifies the gap of 1e-10 m about ten times.

    Any different law, sign or coefficient changes positions by millimetres.
    """
    scene = random_cloth_shot(seed)
    whole = simulate(scene, record="events")
    collisions = whole.events["t"][whole.events["b"] >= 0]
    few = float(collisions[3]) if len(collisions) > 3 else whole.rest_time
    scene = scene.model_copy(update={"t_max": min(few * (1 - 1e-3), 1.0)})
    ours, theirs = simulate(scene, record="events"), exact(scene)
    assert theirs.collision_counts == ours.collision_counts
    errors = theirs.rest_positions - ours.rest_positions
    assert np.max(np.abs(errors)) < 1e-7
    for found, wanted in zip(theirs.final_state, ours.final_state, strict=True):
        np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=1e-5)
