"""Every feature of a scene on every engine: it runs, or is refused by name and with a reason."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from shots import R, ball, scene_of

from ghostball.engine import Scene, Status, Table, UnsupportedSceneError
from ghostball.engine.scene.features import Feature, scene_features
from ghostball.reference_adapters import ReferenceEngine, engine_class, make_engine, parse_spec
from ghostball.reference_adapters.base import resolution_of
from ghostball.reference_adapters.registry import engine_names

ROOT = Path(__file__).parents[2]

SPECS = (
    "ghostball",
    "pymunk",
    "pymunk:mode=landed",
    "pymunk:config=default",
    "pybullet",
    "pybullet:mode=landed",
    "pybullet:config=default",
    "mujoco",
    "mujoco:mode=landed",
    "mujoco:config=default",
    "box2d",
    "box2d:mode=landed",
    "box2d:config=default",
    "dart",
    "dart:mode=landed",
    "dart:config=default",
    "physx",
    "physx:mode=landed",
    "physx:cloth=own",
    "physx:config=default",
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


def hit(other: dict[str, Any] = OBJECT, **physics: Any) -> Scene:
    return scene_of(CUE, other, t_max=0.1, **physics)


SLIDING = {"motion": "sliding"}

# The least scene that needs each feature.
SCENES = {
    Feature.ROLLING: hit(),
    Feature.SLIDING: hit(**SLIDING),
    Feature.FRICTIONLESS_CLOTH: hit(rolling_friction=0.0),
    Feature.VERTICAL_SPIN: hit(ball((0.6, 0.51), angular_velocity=(0, 0, 9)), **SLIDING),
    Feature.BALL_RESTITUTION: hit(ball_restitution=0.9),
    Feature.BALL_FRICTION: hit(ball_friction=0.05, **SLIDING),
    Feature.SPEED_DEPENDENT_FRICTION: hit(ball_friction="alciatore", **SLIDING),
    Feature.MATHAVAN_BALL: hit(ball_impact="mathavan2014", ball_friction=0.05, **SLIDING),
    Feature.UNEQUAL_MASSES: hit({**OBJECT, "mass": 0.3}),
    Feature.UNEQUAL_RADII: hit({**OBJECT, "radius": 0.9 * R}),
    Feature.PER_BALL_FRICTION: hit({**OBJECT, "rolling_friction": 0.1}),
    Feature.UNBOUNDED_CLOTH: hit(),
    Feature.OPEN_SIDES: scene_of(
        CUE, table=Table(length=1.0, width=1.0, cushions=("left",)), t_max=0.1
    ),
    Feature.MIRROR_CUSHION: cushion_shot("mirror"),
    Feature.CUSHION_RESTITUTION: cushion_shot("restitution", cushion_restitution=0.8),
    Feature.CUSHION_TANGENTIAL: cushion_shot("restitution", cushion_tangential_restitution=0.8),
    Feature.FRICTIONAL_CUSHION: cushion_shot("frictional", **SLIDING),
    Feature.HAN_CUSHION: cushion_shot("han2005", **SLIDING),
    Feature.MATHAVAN_CUSHION: cushion_shot("mathavan2010", **SLIDING),
    Feature.AIR_DRAG: hit(air_drag=0.004),
    Feature.QUADRATIC_ROLLING: hit(rolling_friction_quadratic=0.004),
    Feature.FLIGHT: hit(airborne=True, **SLIDING),
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
def test_an_engine_names_every_feature_and_says_how_or_why_not(spec: str) -> None:
    # A feature left out would be refused without a reason, or be taken for exact by a report. It is
    # said of engines that aren't installed, too.
    name, settings = parse_spec(spec)
    engine = engine_class(name)
    capabilities = engine(engine.Settings.model_validate(settings)).capabilities
    assert set(capabilities) == set(Feature)
    for capability in capabilities.values():
        assert capability.support == "exact" or capability.how


def test_no_engine_has_features_that_nobody_named() -> None:
    """Broken by `dict.fromkeys(Feature, EXACT)`, which claims whatever comes next as exact."""
    of_anyone = {"reference_adapters/elsewhere.py"}  # of a run whose engine says nothing
    found = {
        path.relative_to(ROOT).as_posix()
        for package in ("engine", "reference_adapters")
        for path in (ROOT / package).rglob("*.py")
        if "fromkeys(Feature" in path.read_text("utf-8")
    }
    assert found == of_anyone


@pytest.mark.parametrize("spec", sorted({*SPECS, *engine_names()}))
def test_an_engine_states_how_far_off_it_may_be(spec: str) -> None:
    """Broken by an engine of ours that states nothing: nothing would be known of it."""
    name, settings = parse_spec(spec)
    engine = engine_class(name)
    stated = resolution_of(engine(engine.Settings.model_validate(settings)), hit())
    assert (stated == "proved") == (name == "certified")
    if stated != "proved":
        assert stated is not None
        assert (stated == 0.0) == (name in ("ghostball", "billiards"))


@pytest.mark.parametrize("feature", Feature)
@pytest.mark.parametrize("spec", SPECS)
def test_a_scene_runs_or_is_refused_as_the_capabilities_say(spec: str, feature: Feature) -> None:
    # Breaks where an adapter runs what it says that it lacks, or can't run what it says it can.
    engine, scene = engine_of(spec), SCENES[feature]
    needed = scene_features(scene)
    lacks = [f for f in needed if engine.capabilities[f].support == "none"]
    if not lacks:
        result = engine.simulate(scene)
        assert result.status is Status.T_MAX
        assert sum(result.collision_counts.values()) == (feature is not Feature.OPEN_SIDES)
        return
    with pytest.raises(UnsupportedSceneError, match="can't represent") as caught:
        engine.simulate(scene)
    assert len(caught.value.features) == len(lacks)
    for sentence, lacking in zip(caught.value.features, lacks, strict=True):
        assert sentence == f"no {lacking.value} ({engine.capabilities[lacking].how})"


@pytest.mark.parametrize(
    "spec",
    [
        "pymunk",
        "pymunk:mode=landed",
        "pybullet",
        "pybullet:mode=landed",
        "mujoco",
        "box2d",
        "dart",
        "physx",
    ],
)
def test_impacts_one_after_another_are_refused_by_solvers_that_take_them_together(
    spec: str,
) -> None:
    engine = engine_of(spec)
    with pytest.raises(UnsupportedSceneError, match='no impacts = "sequential"'):
        engine.simulate(hit(impacts="sequential"))
    assert engine.simulate(scene_of(CUE, impacts="sequential", t_max=0.1)).status is Status.T_MAX
