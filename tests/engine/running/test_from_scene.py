"""Tests of the conversion of a scene to arrays; a scene that doesn't fit is rejected."""

from __future__ import annotations

import numpy as np
import pytest
from more_obstacles import played_among
from shots import R, ball, scene_of

from ghostball.engine.core import state as st
from ghostball.engine.running.from_scene import state_of
from ghostball.model import Status, UnsupportedSceneError


def test_more_obstacles_than_bits_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Otherwise a contact step would keep balls off the wrong obstacle."""
    disc = (st.DISC, 50.0, 50.0, 0.0, 0.0, 0.01, 0.0, 4)
    scene = scene_of(ball((0.0, 0.0), (1.0, 0.0)), rolling_friction=0.1)
    assert played_among(monkeypatch, scene, *[disc] * st.MOST_OBSTACLES).status is Status.REST
    scene = scene.model_copy()
    with pytest.raises(UnsupportedSceneError, match=r"at most 53 obstacles on the .* got 54"):
        played_among(monkeypatch, scene, *[disc] * (st.MOST_OBSTACLES + 1))


def test_a_ball_begins_to_roll_or_slide_as_its_scene_says() -> None:
    """Fails if the check for single balls and the check for arrays differ near rolling."""
    chance, balls = np.random.default_rng(1), []
    for k in range(500):
        vx, vy = chance.uniform(-1.0, 1.0, 2).tolist()
        near = 1.0 + chance.integers(-14, 15, 2) * 2.0**-52
        spin = (-vy / R * near[0], vx / R * near[1], 3.0)
        balls.append(ball((float(k), 0.0), (vx, vy), angular_velocity=tuple(map(float, spin))))
    scene = scene_of(*balls, motion="sliding", preset="pool")
    rolls = state_of(scene)[:, st.PHASE] == st.ROLLING
    assert 50 < np.count_nonzero(rolls) < 450
    np.testing.assert_array_equal(rolls, scene.rolls)
