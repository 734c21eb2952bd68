"""What physics a scene asks of an engine, feature by feature, and which of it an engine has."""

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
    """A piece of physics that a scene may need; the value is how a report names it.

    `ROLLING` is the paper's model: a ball always rolls and never slides, from the first instant and
    after every impact. An engine whose balls slide until they roll has `SLIDING`, not `ROLLING`.
    """

    ROLLING = "balls that always roll, never slide"
    SLIDING = "sliding that turns into rolling"
    FRICTIONLESS_CLOTH = "cloth without rolling resistance"
    VERTICAL_SPIN = "spin about the vertical axis"
    BALL_RESTITUTION = "ball-ball restitution below 1"
    BALL_FRICTION = "ball-ball friction"
    SPEED_DEPENDENT_FRICTION = "speed-dependent ball friction"
    MATHAVAN_BALL = "ball impacts after Mathavan 2014"
    UNEQUAL_MASSES = "balls of different mass"
    UNEQUAL_RADII = "balls of different radius"
    PER_BALL_FRICTION = "balls with a friction of their own"
    UNBOUNDED_CLOTH = "cloth without cushions"
    OPEN_SIDES = "table with open sides"
    POLYGON = "table that is no rectangle"
    POCKETS = "pockets with jaws"
    POSTS = "posts on the table"
    MIRROR_CUSHION = "cushions that mirror"
    CUSHION_RESTITUTION = "cushions with normal restitution"
    FALLING_RESTITUTION = "cushions whose restitution falls with speed"
    CUSHION_TANGENTIAL = "cushions with tangential restitution"
    FRICTIONAL_CUSHION = "cushions with friction (frictional)"
    HAN_CUSHION = "cushions after Han 2005"
    MATHAVAN_CUSHION = "cushions after Mathavan 2010"
    AIR_DRAG = "air drag"
    QUADRATIC_ROLLING = "rolling friction that grows with the square of the speed"
    FLIGHT = "balls that leave the cloth"


@dataclass(frozen=True)
class Capability:
    """How an engine represents a feature: `support`, and `how` (approximate) or why not (none)."""

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
        Feature.PER_BALL_FRICTION: _has_friction_of_its_own(scene),
        Feature.UNBOUNDED_CLOTH: table is None or not table.cushions,
        Feature.OPEN_SIDES: table is not None and 0 < len(table.cushions) < len(CUSHIONS),
        Feature.POLYGON: table is not None and bool(table.vertices),
        Feature.POCKETS: table is not None and bool(table.holes),
        Feature.POSTS: table is not None and bool(table.posts),
        Feature.AIR_DRAG: physics.air_drag > 0.0,
        Feature.QUADRATIC_ROLLING: physics.rolling_friction_quadratic > 0.0,
        Feature.FLIGHT: physics.airborne,
    }
    if several:
        needed |= _needed_by(BALL_LAWS, physics.ball_impact)
    if table is not None and table.has_cushions:
        needed |= _needed_by(CUSHION_LAWS, physics.cushion)
        falls = physics.cushion_restitution_loss > 0.0 and physics.cushion != "mirror"
        needed[Feature.FALLING_RESTITUTION] = falls
        tangential = physics.cushion_tangential_restitution < 1.0
        needed[Feature.CUSHION_TANGENTIAL] = physics.cushion == "restitution" and tangential
    return tuple(feature for feature in Feature if needed.get(feature, False))


def _needed_by(laws: tuple[LawEntry, ...], name: str) -> dict[Feature, bool]:
    return {Feature[law.feature]: True for law in laws if law.name == name and law.feature}


def _has_friction_of_its_own(scene: Scene) -> bool:
    # All may differ from the scene's in the same way: an engine that knows one friction only would
    # take the scene's.
    physics = scene.physics
    own = bool(np.any(scene.rolling_frictions != physics.rolling_friction))
    if physics.motion == "sliding":
        own |= bool(np.any(scene.sliding_frictions != physics.sliding_friction))
        own |= bool(np.any(scene.spinning_friction_rates != physics.spinning_friction_rate))
    return own


def has_feature(capabilities: Capabilities, feature: Feature) -> bool:
    """Whether an engine has a feature, exactly or nearly; it hasn't what it doesn't mention."""
    return capabilities.get(feature, _NONE).support != "none"


def missing_features(capabilities: Capabilities, scene: Scene) -> tuple[str, ...]:
    """Return a sentence for each feature of `scene` that the capabilities lack; () is "can do"."""
    sentences = []
    for feature in scene_features(scene):
        if not has_feature(capabilities, feature):
            capability = capabilities.get(feature, _NONE)
            because = f" ({capability.how})" if capability.how else ""
            sentences.append(f"no {feature.value}{because}")
    return tuple(sentences)


def check_supported(engine: str, capabilities: Capabilities, scene: Scene) -> None:
    """Raise `UnsupportedSceneError` where the engine lacks a feature of the scene."""
    missing = missing_features(capabilities, scene)
    if missing:
        raise UnsupportedSceneError(engine, missing)
