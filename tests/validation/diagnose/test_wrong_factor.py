"""Each wrong coefficient is named, and no coefficient if none is wrong."""

from __future__ import annotations

from dataclasses import replace

import pytest

from ghostball import find_scene, make_engine, simulate
from ghostball.validation.diagnose.explanation import explain
from ghostball.validation.diagnose.wrong_factor import Factor, wrong_factor
from ghostball.validation.runs.engine_runs import run_engine
from ghostball.validation.truth.known_shot import known_shot


def with_first(scene, **changes):
    """Return our engine's result for a scene with a changed first ball, and this ball."""
    ball = scene.balls[0].model_copy(update=changes)
    other = scene.model_copy(update={"balls": (ball, *scene.balls[1:])})
    return simulate(other, record="trajectory"), ball


def found_in(name, **wrong):
    """Return the wrong factor that is found if our engine uses wrong coefficients."""
    scene = find_scene(name)
    physics = scene.physics.model_copy(update=wrong)
    result = simulate(scene.model_copy(update={"physics": physics}), record="trajectory")
    return wrong_factor(known_shot(scene), result)


@pytest.mark.parametrize(
    ("name", "field", "scale", "relation"),
    [
        ("stop", "rolling_friction", 5 / 7, "5/7 of"),
        ("half-ball-cut", "rolling_friction", 5 / 7, "5/7 of"),  # wrong collisions from 3.5 s on
        ("sliding-stun", "sliding_friction", 0.5, "1/2 of"),
        ("restitution-head-on", "ball_restitution", 0.9, "the square of"),
        ("restitution-bounce", "cushion_restitution", 1.25, "elastic, not"),
        ("english-check", "spinning_friction_rate", 2.0, "2 times"),
    ],
)
def test_a_wrong_coefficient_is_named_with_its_value(name, field, scale, relation):
    right = getattr(find_scene(name).physics, field)
    found = found_in(name, **{field: scale * right})
    assert (found.what, found.ball, found.right) == (field, "", right)
    assert found.value == pytest.approx(scale * right, rel=1e-4)
    assert found.relation == relation
    assert found.after < 1e-3 * found.before


@pytest.mark.parametrize(
    ("name", "field", "scale"),
    [
        ("head-on", "ball_restitution", 0.95),
        ("restitution-head-on", "ball_restitution", 1.04),
        ("half-ball-cut", "ball_restitution", 0.95),
        ("stop", "rolling_friction", 0.97),
        ("restitution-bounce", "cushion_restitution", 0.96),
    ],
)
def test_a_coefficient_that_is_a_little_wrong_is_named_too(name, field, scale):
    # Fails if the search tries so few factors that the scene's value is the nearest of them.
    right = getattr(find_scene(name).physics, field)
    found = found_in(name, **{field: scale * right})
    assert (found.what, found.right) == (field, right)
    assert found.scale == pytest.approx(scale, rel=1e-3)


def test_a_step_beside_a_wrong_coefficient_hides_it_not():
    # A time-stepping engine whose balls have 0.95 times the restitution of the scene.
    scene = find_scene("head-on")
    physics = scene.physics.model_copy(update={"ball_restitution": 0.95})
    weaker = scene.model_copy(update={"physics": physics})
    result = run_engine(make_engine("pymunk"), weaker)
    found = wrong_factor(known_shot(scene), replace(result, scene=scene))
    assert found.what == "ball_restitution"
    assert found.value == pytest.approx(0.95, rel=5e-3)


def test_a_wrong_mass_and_a_wrong_spin_are_named_with_their_ball():
    scene = find_scene("unequal-balls")
    result, heavy = with_first(scene, mass=0.8 * scene.balls[0].mass)
    found = wrong_factor(known_shot(scene), result)
    assert (found.what, found.ball, found.relation) == ("mass", heavy.id, "4/5 of")
    scene = find_scene("draw-shot")
    spin = tuple((0.4 * scene.angular_velocities[0]).tolist())
    result, cue = with_first(scene, angular_velocity=spin)
    found = wrong_factor(known_shot(scene), result)
    assert (found.what, found.ball, found.relation) == ("spin", cue.id, "2/5 of")


def test_what_a_shot_cannot_tell_apart_is_said():
    # In a collision, only the ratio of the masses matters.
    scene = find_scene("draw-shot")
    result, _ = with_first(scene, mass=0.8 * scene.balls[0].mass)
    found = wrong_factor(known_shot(scene), result)
    assert found.what == "mass"
    assert len(found.rivals) == 1
    assert found.rivals[0].startswith("the mass of")


def test_it_begins_at_the_collision_that_it_is_of():
    found = found_in("restitution-head-on", ball_restitution=0.81)
    met = next(iter(known_shot(find_scene("restitution-head-on")).result.events))["t"]
    assert 0.9 * met < found.since < 1.1 * met
    assert found_in("stop", rolling_friction=0.01).since < 0.1


def test_no_coefficient_is_named_where_none_is_wrong():
    assert found_in("half-ball-cut") is None
    scene = find_scene("half-ball-cut")
    assert wrong_factor(known_shot(scene), run_engine(make_engine("pymunk"), scene)) is None


def test_the_error_of_a_step_is_no_wrong_coefficient():
    # Fails if a coefficient is named: a late collision looks like a slightly weaker collision.
    assert explain(find_scene("head-on"), make_engine("pymunk")).factor is None


FACTOR = Factor("rolling_friction", "", 0.02, 0.02, 0.1, 0.001, 3.0)


@pytest.mark.parametrize(
    ("what", "right", "value", "relation"),
    [
        ("rolling_friction", 0.02, 0.0, "none of"),
        ("rolling_friction", 0.02, 0.06, "3 times"),
        ("rolling_friction", 0.02, 0.02 * 0.7149, "5/7 of"),
        ("rolling_friction", 0.02, 0.02 * 0.9666, "0.967 times"),
        ("ball_restitution", 0.9, 0.9487, "the root of"),
        ("ball_restitution", 1.0, 0.5, "1/2 of"),
    ],
)
def test_a_relation_is_as_simple_as_it_is_true(what, right, value, relation):
    assert replace(FACTOR, what=what, right=right, value=value).relation == relation
