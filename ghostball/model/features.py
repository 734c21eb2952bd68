"""Features: the physics that a scene needs, and whether an engine supports it."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ghostball.model.errors import UnsupportedSceneError
from ghostball.model.impact_laws import BALL_LAWS, CUSHION_LAWS, LawEntry
from ghostball.model.scene.scene import Scene
from ghostball.model.scene.sides import CUSHIONS


class Feature(enum.Enum):
    """A piece of physics that a scene may need; the value is its name in reports.

    `ROLLING` is the model of the paper (docs/paper.md): balls roll from the start and after every
        impact, and never slide.
    Engines whose balls slide until they roll have `SLIDING`, not `ROLLING`.
    """

    ROLLING = "pure rolling"
    SLIDING = "sliding that becomes rolling"
    FRICTIONLESS_CLOTH = "cloth without rolling friction"
    VERTICAL_SPIN = "spin about the vertical axis"
    BALL_RESTITUTION = "ball-ball restitution below 1"
    BALL_FRICTION = "ball-ball friction"
    SPEED_DEPENDENT_FRICTION = "speed-dependent ball friction"
    MATHAVAN_BALL = "ball impacts after Mathavan 2014"
    UNEQUAL_MASSES = "balls of different masses"
    UNEQUAL_RADII = "balls of different radii"
    PER_BALL_FRICTION = "friction coefficients per ball"
    UNBOUNDED_CLOTH = "unbounded cloth"
    OPEN_SIDES = "table with open sides"
    POLYGON = "non-rectangular table"
    POCKETS = "pockets with jaws"
    POSTS = "posts on the table"
    MIRROR_CUSHION = "mirror cushions"
    CUSHION_RESTITUTION = "cushions with normal restitution"
    FALLING_RESTITUTION = "cushions whose restitution falls with speed"
    CUSHION_TANGENTIAL = "cushions with tangential restitution"
    FRICTIONAL_CUSHION = "cushions with friction (frictional)"
    HAN_CUSHION = "cushions after Han 2005"
    MATHAVAN_CUSHION = "cushions after Mathavan 2010"
    STRONGE_CUSHION = "cushions after Stronge 2000"
    AIR_DRAG = "air drag"
    QUADRATIC_ROLLING = "rolling friction with a quadratic term"
    FLIGHT = "airborne balls"
    COMPLIANT = "impacts that last"


@dataclass(frozen=True)
class Capability:
    """How an engine supports a feature.

    `how` describes the approximation, or says why the feature is unsupported.
    """

    support: Literal["exact", "approximate", "none"]
    how: str = ""


EXACT = Capability("exact")
_NONE = Capability("none")
Capabilities = Mapping[Feature, Capability]


def scene_features(scene: Scene) -> tuple[Feature, ...]:
    """Return the features that `scene` needs, in the order of `Feature`."""
    physics, table = scene.physics, scene.table
    several = len(scene.balls) > 1
    speed_dependent = physics.ball_friction == "alciatore"
    needed: dict[Feature, bool] = {
        Feature.ROLLING: physics.motion == "rolling",
        Feature.SLIDING: physics.motion == "sliding",
        Feature.FRICTIONLESS_CLOTH: bool(np.any(scene.rolling_frictions == 0.0)),
        Feature.VERTICAL_SPIN: bool(np.any(scene.angular_velocities[:, 2] != 0.0)),
        Feature.BALL_RESTITUTION: physics.ball_restitution < 1.0 and several,
        Feature.BALL_FRICTION: physics.ball_friction != 0.0 and not speed_dependent and several,
        Feature.SPEED_DEPENDENT_FRICTION: speed_dependent and several,
        Feature.UNEQUAL_MASSES: len({ball.mass for ball in scene.balls}) > 1,
        Feature.UNEQUAL_RADII: len({ball.radius for ball in scene.balls}) > 1,
        Feature.PER_BALL_FRICTION: _has_friction_per_ball(scene),
        Feature.UNBOUNDED_CLOTH: table is None or not table.cushions,
        Feature.OPEN_SIDES: table is not None and 0 < len(table.cushions) < len(CUSHIONS),
        Feature.POLYGON: table is not None and bool(table.vertices),
        Feature.POCKETS: table is not None and bool(table.holes),
        Feature.POSTS: table is not None and bool(table.posts),
        Feature.AIR_DRAG: physics.air_drag > 0.0,
        Feature.QUADRATIC_ROLLING: physics.rolling_friction_quadratic > 0.0,
        Feature.FLIGHT: physics.airborne,
        Feature.COMPLIANT: physics.impacts == "compliant" and several,
    }
    if several:
        needed |= _features_of_law(BALL_LAWS, physics.ball_impact)
    if table is not None and table.has_cushions:
        needed |= _features_of_law(CUSHION_LAWS, physics.cushion)
        falls = physics.cushion_restitution_loss > 0.0 and physics.cushion != "mirror"
        needed[Feature.FALLING_RESTITUTION] = falls
        tangential = physics.cushion_tangential_restitution < 1.0
        needed[Feature.CUSHION_TANGENTIAL] = physics.cushion == "restitution" and tangential
    return tuple(feature for feature in Feature if needed.get(feature, False))


def _features_of_law(laws: tuple[LawEntry, ...], name: str) -> dict[Feature, bool]:
    return {Feature[law.feature]: True for law in laws if law.name == name and law.feature}


def _has_friction_per_ball(scene: Scene) -> bool:
    # All balls may differ from the scene in the same way: an engine that supports a single
    # coefficient would use that of the scene.
    physics = scene.physics
    own = bool(np.any(scene.rolling_frictions != physics.rolling_friction))
    if physics.motion == "sliding":
        own |= bool(np.any(scene.sliding_frictions != physics.sliding_friction))
        own |= bool(np.any(scene.spinning_friction_rates != physics.spinning_friction_rate))
    return own


def has_feature(capabilities: Capabilities, feature: Feature) -> bool:
    """Return whether an engine supports a feature, exactly or approximately.

    A feature that isn't in `capabilities` is unsupported.
    """
    return capabilities.get(feature, _NONE).support != "none"


def missing_features(capabilities: Capabilities, scene: Scene) -> tuple[str, ...]:
    """Return a sentence for each feature of `scene` that the capabilities lack."""
    sentences = []
    for feature in scene_features(scene):
        if not has_feature(capabilities, feature):
            capability = capabilities.get(feature, _NONE)
            because = f" ({capability.how})" if capability.how else ""
            sentences.append(f"no {feature.value}{because}")
    return tuple(sentences)


def check_supported(engine: str, capabilities: Capabilities, scene: Scene) -> None:
    """Raise `UnsupportedSceneError` if the engine lacks a feature of the scene."""
    missing = missing_features(capabilities, scene)
    if missing:
        raise UnsupportedSceneError(engine, missing)
