"""Scenes from arrays equal scenes from balls, and the same rules apply."""

import numpy as np
import pytest
from shots import POOL_TABLE, R, ball, scene_of

from ghostball.model import Ball, Scene, SceneError, Strike


def test_a_scene_from_arrays_is_that_from_balls():
    names = ["cue", "eight"]
    by_balls = scene_of(
        ball((0.5, 0.6), (1.0, 0.2), id="cue", angular_velocity=(1.0, 2.0, 3.0), mass=0.2),
        ball((1.5, 0.6), id="eight", angular_velocity=(0.0, 0.0, 0.0), mass=0.2),
        table=POOL_TABLE,
        preset="pool",
    )
    from_arrays = Scene.from_arrays(
        [[0.5, 0.6], [1.5, 0.6]],
        np.array([[1.0, 0.2], [0.0, 0.0]]),
        [[1.0, 2.0, 3.0], [0.0, 0.0, 0.0]],
        ids=names,
        masses=0.2,
        **{name: getattr(by_balls, name) for name in ("name", "physics", "table")},
    )
    assert from_arrays == by_balls


def test_what_is_left_out_is_that_of_a_ball():
    scene = Scene.from_arrays(np.array([[0.0, 0.0], [1.0, 0.0]]), name="rest")
    assert [one.id for one in scene.balls] == ["ball-0", "ball-1"]
    assert scene.balls[1] == Ball(id="ball-1", position=(1.0, 0.0))
    assert Scene.from_arrays([[0, 0, 0.5]], name="large", radii=[0.5]).balls[0].radius == 0.5


def test_strikes_are_given_by_index():
    strike = Strike(speed=2.0, direction=0.3, offset_up=0.2)
    scene = Scene.from_arrays(
        [[0.0, 0.0], [1.0, 0.0]], name="a", strikes={1: strike}, physics={"preset": "pool"}
    )
    assert [one.strike for one in scene.balls] == [None, strike]
    assert scene.velocities[1, 0] > 0.0 == scene.velocities[0, 0]


STRIKE = Strike(speed=2.0, direction=0.0)


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"positions": [0, 1]}, r"`positions` must have the shape \(balls, 2 or 3\), got \(2,\)"),
        ({"positions": [["a", "b"]]}, "`positions` must be an array of numbers"),
        ({"positions": [[0, 0]], "velocities": [[1, 2]] * 2}, "`velocities` must have 1 entries"),
        ({"positions": [[0, 0]], "radii": [[R]]}, "`radii` must be one number, or one for each"),
        ({"positions": [[0, 0]], "radii": [R, R]}, "`radii` must have 1 entries"),
        ({"positions": [[0, 0], [1, 1]], "ids": ["a"]}, "`ids` must have 2 entries"),
        ({"positions": np.empty((0, 2))}, r"`balls` must have at least 1 item\(s\)"),
        ({"positions": [[0, 0], [np.nan, 1]]}, r"`balls\[1\].position\[0\]` must be a finite"),
        ({"positions": [[0, 0], [0.01, 0]]}, "overlap by 0.04715 m"),
        ({"positions": [[0, 0]], "masses": -1.0}, r"`balls\[0\].mass` must be greater than 0"),
        ({"positions": [[0, 0]], "strikes": {1: STRIKE}}, "by index, 0 to 0, got 1. Give"),
        ({"positions": [[0, 0]], "strikes": {"cue": STRIKE}}, "by index, 0 to 0, got 'cue'"),
        (
            {"positions": [[0, 0]], "velocities": [[0, 0]], "strikes": {0: STRIKE}},
            r"`balls\[0\]` must not have both a strike and its own velocity",
        ),
        ({"positions": [[0, 0]], "tmax": 1.0}, "`tmax` is not a known field. Did you mean `t_max`"),
    ],
)
def test_wrong_arrays_are_refused(arrays, message):
    with pytest.raises(SceneError, match=message):
        Scene.from_arrays(name="wrong", **arrays)
