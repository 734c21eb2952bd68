"""A scene as a whole: nobody changes it, and it goes to another process."""

from __future__ import annotations

import pickle

import pytest
from shots import POOL_TABLE, ball, scene_of


def test_a_scene_is_frozen():
    scene = scene_of(ball((0, 0)))
    with pytest.raises(ValueError, match="frozen"):
        scene.name = "other"
    with pytest.raises(ValueError, match="frozen"):
        scene.balls[0].radius = 1.0


def test_a_scene_survives_pickling_to_a_worker():
    scene = scene_of(ball((0.5, 0.25), (1, 0)), table=POOL_TABLE)
    assert pickle.loads(pickle.dumps(scene)) == scene
