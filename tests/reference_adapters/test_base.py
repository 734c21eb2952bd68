"""How far a ball may go in a step, against what our engine says of its fastest speed."""

from __future__ import annotations

import random

import numpy as np
import pytest
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.reference_adapters.base import resolution_of_step
from ghostball.validation.scenes.library import find_scene

DT = 1e-3


@pytest.mark.parametrize("seed", range(20))
def test_a_single_ball_never_gets_faster_than_its_step_allows(seed: int) -> None:
    """Breaks with a wrong sign of the slip, or share of it: some seeds speed up, some slow down."""
    chance = random.Random(seed)
    velocity = (chance.uniform(-1.0, 1.0), chance.uniform(-1.0, 1.0))
    spin = tuple(chance.uniform(-100.0, 100.0) for _ in range(3))
    scene = scene_of(ball((0, 0), velocity, angular_velocity=spin), motion="sliding")
    result = simulate(scene, record="trajectory")
    times = [0.0, *(float(t) for t in result.events["t"])]
    fastest = float(np.max(np.linalg.norm(result.sample(times).velocities, axis=2)))
    assert resolution_of_step(DT, scene) == pytest.approx(DT * fastest, rel=1e-12)


def test_a_ball_that_only_spins_comes_to_two_sevenths_of_its_surface_speed() -> None:
    scene = scene_of(ball((0, 0), angular_velocity=(30.0, -40.0, 500.0)), motion="sliding")
    assert resolution_of_step(DT, scene) == pytest.approx(DT * 2 / 7 * R * 50.0, rel=1e-14)


def test_spin_without_friction_on_the_cloth_moves_nothing() -> None:
    spun = ball((0, 0), angular_velocity=(0.0, -40.0, 0.0))
    scene = scene_of(spun, motion="sliding", sliding_friction=0.0, rolling_friction=0.0, t_max=1.0)
    assert resolution_of_step(DT, scene) == 0.0


def test_a_ball_that_rolls_is_as_fast_as_it_starts_to_the_bit() -> None:
    """Breaks where the rounding of its spin counts as slip."""
    scene = find_scene("half-ball-rolling")
    assert resolution_of_step(DT, scene) == DT * 1.0


def test_an_engine_with_steps_is_not_exact_where_only_spin_moves_balls() -> None:
    assert resolution_of_step(DT, find_scene("wedged")) == pytest.approx(DT * 0.8164286, rel=1e-6)
