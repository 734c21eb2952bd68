"""The declarations of engines: support of each feature, and resolution."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import pytest
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.model import Scene, Status, Table, UnsupportedSceneError
from ghostball.model.features import Feature, scene_features
from ghostball.reference_adapters import ReferenceEngine, engine_class, make_engine, parse_spec
from ghostball.reference_adapters.base import resolution_of, resolution_of_step
from ghostball.reference_adapters.registry import engine_names
from ghostball.validation.scenes.library import find_scene

DT = 1e-3


@pytest.mark.parametrize("seed", range(8))
def test_a_single_ball_never_gets_faster_than_its_step_allows(seed: int) -> None:
    """Fails for a wrong sign or share of the slip; in some seeds balls gain speed."""
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
    """The rounding of a rolling ball's spin must not count as slip."""
    scene = find_scene("half-ball-rolling")
    assert resolution_of_step(DT, scene) == DT * 1.0


def test_an_engine_with_steps_is_not_exact_where_balls_are_slower_than_numbers_go() -> None:
    assert resolution_of_step(1e-3, scene_of(ball((0.5, 0.5), (5e-324, 0.0)))) > 0.0
    assert resolution_of_step(1e-3, scene_of(ball((0.5, 0.5)))) == 0.0


def test_an_engine_with_steps_is_not_exact_where_only_spin_moves_balls() -> None:
    assert resolution_of_step(DT, find_scene("wedged")) == pytest.approx(DT * 0.8164286, rel=1e-6)


SPECS = (
    "ghostball",
    "pymunk",
    "pymunk:contact_steps=exact",
    "pymunk:config=naive",
    "pymunk:cloth=own",
    "pybullet",
    "pybullet:contact_steps=exact",
    "pybullet:config=naive",
    "pybullet:cloth=own",
    "mujoco",
    "mujoco:contact_steps=exact",
    "mujoco:config=naive",
    "box2d",
    "box2d:contact_steps=exact",
    "box2d:config=naive",
    "box2d:cloth=own",
    "rapier:cloth=own",
    "dart",
    "dart:contact_steps=exact",
    "dart:config=naive",
    "physx",
    "physx:contact_steps=exact",
    "physx:cloth=own",
    "physx:config=naive",
    "newton",
    "newton:solver=xpbd,contact_steps=exact",
    "newton:cloth=own",
    "newton:config=naive",
    "planck",
    "planck:config=naive",
    "matter-js:contact_steps=exact",
    "cannon-es",
    "paper-discrete",
    "paper-continuous",
    "paper-continuous:cushions=searched",
    "certified",
)


TABLE = Table(length=1.0, width=1.0)


CUE = ball((0.5, 0.5), (1.0, 0.0))


OBJECT = ball((0.6, 0.51))


def cushion_shot(law: str, **physics: Any) -> Scene:
    return scene_of(ball((0.9, 0.5), (1.0, 0.2)), table=TABLE, t_max=0.1, cushion=law, **physics)


def collision(other: dict[str, Any] = OBJECT, **physics: Any) -> Scene:
    return scene_of(CUE, other, t_max=0.1, **physics)


def on_table(**table: Any) -> Scene:
    return scene_of(CUE, OBJECT, table=Table.model_validate(table), t_max=0.1)


SLIDING = {"motion": "sliding"}


# The simplest scene that needs each feature.
SCENES = {
    Feature.ROLLING: collision(),
    Feature.SLIDING: collision(**SLIDING),
    Feature.FRICTIONLESS_CLOTH: collision(rolling_friction=0.0),
    Feature.VERTICAL_SPIN: collision(ball((0.6, 0.51), angular_velocity=(0, 0, 9)), **SLIDING),
    Feature.BALL_RESTITUTION: collision(ball_restitution=0.9),
    Feature.BALL_FRICTION: collision(ball_friction=0.05, **SLIDING),
    Feature.SPEED_DEPENDENT_FRICTION: collision(ball_friction="alciatore", **SLIDING),
    Feature.MATHAVAN_BALL: collision(ball_impact="mathavan2014", ball_friction=0.05, **SLIDING),
    Feature.UNEQUAL_MASSES: collision({**OBJECT, "mass": 0.3}),
    Feature.UNEQUAL_RADII: collision({**OBJECT, "radius": 0.9 * R}),
    Feature.PER_BALL_FRICTION: collision({**OBJECT, "rolling_friction": 0.1}),
    Feature.UNBOUNDED_CLOTH: collision(),
    Feature.OPEN_SIDES: scene_of(
        CUE, table=Table(length=1.0, width=1.0, cushions=("left",)), t_max=0.1
    ),
    Feature.POLYGON: on_table(vertices=[(0.0, 0.0), (1.0, 0.0), (0.5, 1.0)]),
    Feature.POCKETS: on_table(preset="wpa-9ft", length=1.0, width=1.0),
    Feature.POSTS: on_table(length=1.0, width=1.0, posts=[{"centre": (0.2, 0.2), "radius": 0.05}]),
    Feature.MIRROR_CUSHION: cushion_shot("mirror"),
    Feature.CUSHION_RESTITUTION: cushion_shot("restitution", cushion_restitution=0.8),
    Feature.FALLING_RESTITUTION: cushion_shot("restitution", cushion_restitution_loss=0.15),
    Feature.CUSHION_TANGENTIAL: cushion_shot("restitution", cushion_tangential_restitution=0.8),
    Feature.FRICTIONAL_CUSHION: cushion_shot("frictional", **SLIDING),
    Feature.HAN_CUSHION: cushion_shot("han2005", **SLIDING),
    Feature.MATHAVAN_CUSHION: cushion_shot("mathavan2010", **SLIDING),
    Feature.STRONGE_CUSHION: cushion_shot("stronge2000", **SLIDING),
    Feature.AIR_DRAG: collision(air_drag=0.004),
    Feature.QUADRATIC_ROLLING: collision(rolling_friction_quadratic=0.004),
    Feature.FLIGHT: collision(airborne=True, **SLIDING),
    Feature.COMPLIANT: collision(impacts="compliant"),
}


def engine_of(spec: str) -> ReferenceEngine:
    reason = engine_class(parse_spec(spec)[0]).unavailable()
    if reason is not None:
        pytest.skip(reason)
    return make_engine(spec)


def test_each_feature_has_a_scene() -> None:
    assert set(SCENES) == set(Feature)
    for feature, scene in SCENES.items():
        assert feature in scene_features(scene)


@pytest.mark.parametrize("spec", sorted({*SPECS, *engine_names()}))
def test_an_engine_says_of_every_feature_how_or_why_not_and_how_far_off_it_may_be(
    spec: str,
) -> None:
    # A missing feature would be rejected without a reason, or count as exact in a report. Without a
    # resolution, the accuracy is unknown. Engines that aren't installed declare both, too.
    name, settings = parse_spec(spec)
    kind = engine_class(name)
    engine = kind(kind.Settings.model_validate(settings))
    assert set(engine.capabilities) == set(Feature)
    for capability in engine.capabilities.values():
        assert capability.support == "exact" or capability.how
    stated = resolution_of(engine, collision())
    assert (stated == "proved") == (name == "certified")
    if stated != "proved":
        assert stated is not None
        assert (stated == 0.0) == (name in ("ghostball", "billiards"))


@pytest.mark.parametrize("spec", SPECS)
def test_a_scene_runs_or_is_refused_as_the_capabilities_say(spec: str) -> None:
    # An adapter must reject unsupported features, and run all supported ones.
    engine = engine_of(spec)
    for feature, scene in SCENES.items():
        lacks = [f for f in scene_features(scene) if engine.capabilities[f].support == "none"]
        if not lacks:
            result = engine.simulate(scene)
            assert result.status is Status.T_MAX, feature
            collisions = sum(result.collision_counts.values())
            assert collisions == (feature is not Feature.OPEN_SIDES), feature
            continue
        with pytest.raises(UnsupportedSceneError, match="can't represent") as caught:
            engine.simulate(scene)
        assert caught.value.features == tuple(
            f"no {one.value} ({engine.capabilities[one].how})" for one in lacks
        )


@pytest.mark.parametrize(
    "spec",
    [
        "pymunk",
        "pymunk:contact_steps=exact",
        "pybullet",
        "pybullet:contact_steps=exact",
        "mujoco",
        "box2d",
        "dart",
        "physx",
        "newton",
    ],
)
def test_impacts_one_after_another_are_refused_by_solvers_that_take_them_together(
    spec: str,
) -> None:
    engine = engine_of(spec)
    with pytest.raises(UnsupportedSceneError, match='no impacts = "sequential"'):
        engine.simulate(collision(impacts="sequential"))
    assert engine.simulate(scene_of(CUE, impacts="sequential", t_max=0.1)).status is Status.T_MAX
