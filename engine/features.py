"""What a scene asks of an engine, feature by feature, and how an engine says what it can do."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from engine.errors import UnsupportedSceneError
from engine.scene import CUSHIONS, Scene


class Feature(enum.Enum):
    """A piece of physics that a scene may need; the value is how a report names it."""

    ROLLING = "rolling without slip"
    SLIDING = "sliding that turns into rolling"
    FRICTIONLESS_CLOTH = "cloth without rolling resistance"
    VERTICAL_SPIN = "spin about the vertical axis"
    BALL_RESTITUTION = "ball-ball restitution below 1"
    BALL_FRICTION = "ball-ball friction"
    UNEQUAL_MASSES = "balls of different mass"
    UNEQUAL_RADII = "balls of different radius"
    UNBOUNDED_CLOTH = "a cloth without cushions"
    OPEN_SIDES = "a table with open sides"
    MIRROR_CUSHION = "cushions that mirror"
    CUSHION_RESTITUTION = "cushions with normal restitution"
    CUSHION_TANGENTIAL = "cushions with tangential restitution"
    FRICTIONAL_CUSHION = "cushions with friction (frictional)"
    HAN_CUSHION = "cushions after Han 2005"
    MATHAVAN_CUSHION = "cushions after Mathavan 2010"
    AIR_DRAG = "air drag"
    FLIGHT = "balls that leave the cloth"


@dataclass(frozen=True)
class Capability:
    """How an engine represents a feature: `support`, and `how` (approximate) or why not (none)."""

    support: Literal["exact", "approximate", "none"]
    how: str = ""


EXACT = Capability("exact")
Capabilities = Mapping[Feature, Capability]


def scene_features(scene: Scene) -> tuple[Feature, ...]:
    """Return the features that `scene` needs, in the order of `Feature`."""
    physics, table = scene.physics, scene.table
    needed: dict[Feature, bool] = {
        Feature.ROLLING: physics.motion == "rolling",
        Feature.SLIDING: physics.motion == "sliding",
        Feature.FRICTIONLESS_CLOTH: physics.rolling_friction == 0.0,
        Feature.VERTICAL_SPIN: bool(np.any(scene.angular_velocities[:, 2] != 0.0)),
        Feature.BALL_RESTITUTION: physics.ball_restitution < 1.0 and len(scene.balls) > 1,
        Feature.BALL_FRICTION: physics.ball_friction != 0.0 and len(scene.balls) > 1,
        Feature.UNEQUAL_MASSES: len({ball.mass for ball in scene.balls}) > 1,
        Feature.UNEQUAL_RADII: len({ball.radius for ball in scene.balls}) > 1,
        Feature.UNBOUNDED_CLOTH: table is None or not table.cushions,
        Feature.OPEN_SIDES: table is not None and 0 < len(table.cushions) < len(CUSHIONS),
        Feature.AIR_DRAG: physics.air_drag > 0.0,
        Feature.FLIGHT: physics.airborne,
    }
    if table is not None and table.cushions:
        restitution = physics.cushion == "restitution"
        needed |= {
            Feature.MIRROR_CUSHION: physics.cushion == "mirror",
            Feature.CUSHION_RESTITUTION: restitution,
            Feature.CUSHION_TANGENTIAL: restitution
            and physics.cushion_tangential_restitution < 1.0,
            Feature.FRICTIONAL_CUSHION: physics.cushion == "frictional",
            Feature.HAN_CUSHION: physics.cushion == "han2005",
            Feature.MATHAVAN_CUSHION: physics.cushion == "mathavan2010",
        }
    return tuple(feature for feature in Feature if needed.get(feature, False))


def missing_features(capabilities: Capabilities, scene: Scene) -> tuple[str, ...]:
    """Return a sentence for each feature of `scene` that the capabilities lack; () is "can do"."""
    sentences = []
    for feature in scene_features(scene):
        capability = capabilities.get(feature, Capability("none"))
        if capability.support == "none":
            because = f" ({capability.how})" if capability.how else ""
            sentences.append(f"no {feature.value}{because}")
    return tuple(sentences)


def check_supported(engine: str, capabilities: Capabilities, scene: Scene) -> None:
    """Raise `UnsupportedSceneError` where the engine lacks a feature of the scene."""
    missing = missing_features(capabilities, scene)
    if missing:
        raise UnsupportedSceneError(engine, missing)
