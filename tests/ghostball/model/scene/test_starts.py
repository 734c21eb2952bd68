"""The start of struck balls: on the cloth, and in scenes with airborne balls."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from shots import FLIES, R

from ghostball.engine import simulate
from ghostball.model import Ball, EventKind, Physics, Scene, SceneError, Strike
from ghostball.model.scene import check_whole, stroke_of
from ghostball.model.scene.strike import bounced

JUMP = Strike(speed=4.0, direction=0.3, elevation=0.8, offset_left=0.1, cue_mass=0.25)


def scene_with(strike: Strike, airborne: bool = True, **ball) -> Scene:
    physics = Physics(**FLIES) if airborne else Physics(motion="sliding")
    return Scene(
        name="jump", physics=physics, balls=[Ball(id="a", position=(0, 0), strike=strike, **ball)]
    )


def test_on_the_cloth_what_is_vertical_goes_into_the_table():
    scene = scene_with(JUMP, airborne=False)
    velocity, spin, _ = stroke_of(JUMP, scene.balls[0].radius, scene.balls[0].mass)
    assert velocity[2] < -1.0
    assert scene.velocities.tolist() == [[*velocity[:2], 0.0]]
    assert scene.angular_velocities.tolist() == [list(spin)]


@pytest.mark.parametrize("ball", [{}, {"sliding_friction": 0.31, "mass": 0.2, "radius": 0.03}])
def test_a_struck_ball_that_may_fly_bounces_off_the_table(ball):
    scene = scene_with(JUMP, **ball)
    (struck,) = scene.balls
    velocity, spin, _ = stroke_of(JUMP, struck.radius, struck.mass)
    friction = ball.get("sliding_friction", FLIES["sliding_friction"])
    pushed = np.array([velocity]), np.array([spin])
    expected = bounced(*pushed, struck.radius, friction, FLIES["table_restitution"])
    assert [list(struck.velocity)] == expected[0].tolist()
    assert [list(struck.angular_velocity)] == expected[1].tolist()
    assert struck.velocity[2] == -0.5 * velocity[2] > 0.0
    # The ball flies at once, and lands with the speed with which it rose.
    result = simulate(scene, record="events")
    lands = result.events["t"][result.events["kind"] == EventKind.BALL_CLOTH][0]
    assert lands == pytest.approx(2.0 * struck.velocity[2] / scene.physics.gravity, rel=1e-14)


def test_the_end_of_a_cue_that_hits_low_throws_the_ball_up():
    low = Strike(speed=2.0, direction=0.0, offset_up=-0.4)
    (struck,) = scene_with(low).balls
    assert struck.velocity == stroke_of(low, R, struck.mass).velocity
    assert struck.velocity[2] > 0.05
    assert scene_with(low, airborne=False).velocities[0, 2] == 0.0


def test_a_ball_begins_as_the_scene_has_it_that_it_is_put_into():
    flying = scene_with(JUMP)
    held = Scene(name="held", physics=Physics(motion="sliding"), balls=flying.balls)
    assert held.balls == scene_with(JUMP, airborne=False).balls
    assert Scene(name="jump", physics=flying.physics, balls=held.balls) == flying
    assert flying.velocities[0, 2] > 0.0  # the scene's own balls are unchanged


def test_copies_are_known_and_what_would_begin_otherwise_is_refused():
    scene = scene_with(JUMP)
    for same in (copy.deepcopy(scene), pickle.loads(pickle.dumps(scene)), scene.model_copy()):
        check_whole(same)
        assert same == scene
    physics = scene.physics.model_copy(update={"table_restitution": 0.6})
    with pytest.raises(SceneError, match="which would have changed it"):
        check_whole(scene.model_copy(update={"physics": physics}))


def test_a_scene_without_its_strikes_moves_alike():
    for scene in (scene_with(JUMP), scene_with(JUMP, airborne=False)):
        moving = scene.without_strikes()
        assert moving.balls[0].strike is None
        assert moving != scene
        for name in ("velocities", "angular_velocities", "rolls"):
            assert getattr(moving, name).tobytes() == getattr(scene, name).tobytes()
        ends = [simulate(one).rest_positions for one in (scene, moving)]
        assert np.array_equal(*ends)
        assert moving.without_strikes() is moving
