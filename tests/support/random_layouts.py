"""Options of random scenes, and contacts of their balls with cushions."""

import numpy as np

from ghostball.model.features import Feature
from ghostball.validation.scenes.random_parts import reach

FEW = range(200)
"""Numbers of the random scenes for fast tests; these scenes have few balls."""

FEATURE_OPTIONS = {
    Feature.ROLLING: (("motion", "rolling"),),
    Feature.SLIDING: (("motion", "sliding"),),
    Feature.FRICTIONLESS_CLOTH: (("cloth", "frictionless"),),
    Feature.VERTICAL_SPIN: (("spin", "vertical"), ("spin", "struck")),
    Feature.BALL_RESTITUTION: (("restitution", "lossy"), ("restitution", "none")),
    Feature.BALL_FRICTION: (("friction", "constant"),),
    Feature.SPEED_DEPENDENT_FRICTION: (("friction", "alciatore"),),
    Feature.MATHAVAN_BALL: (("ball-law", "mathavan2014"),),
    Feature.UNEQUAL_MASSES: (("masses", "unequal"),),
    Feature.UNEQUAL_RADII: (("radii", "unequal"),),
    Feature.PER_BALL_FRICTION: (("own-friction", "yes"),),
    Feature.UNBOUNDED_CLOTH: (("table", "none"),),
    Feature.OPEN_SIDES: (("table", "open"),),
    Feature.POLYGON: (("table", "polygon"),),
    Feature.POCKETS: (("table", "pockets"),),
    Feature.POSTS: (("table", "posts"),),
    Feature.MIRROR_CUSHION: (("cushion", "mirror"),),
    Feature.CUSHION_RESTITUTION: (("cushion", "restitution"), ("cushion", "tangential")),
    Feature.FALLING_RESTITUTION: (("cushion", "falling"),),
    Feature.CUSHION_TANGENTIAL: (("cushion", "tangential"),),
    Feature.FRICTIONAL_CUSHION: (("cushion", "frictional"),),
    Feature.HAN_CUSHION: (("cushion", "han2005"),),
    Feature.MATHAVAN_CUSHION: (("cushion", "mathavan2010"),),
    Feature.STRONGE_CUSHION: (("cushion", "stronge2000"),),
    Feature.AIR_DRAG: (("air", "yes"),),
    Feature.QUADRATIC_ROLLING: (("quadratic", "yes"),),
    Feature.COMPLIANT: (("impacts", "compliant"),),
    Feature.FLIGHT: tuple(("flight", how) for how in ("low", "jump", "drop", "on-top")),
}
"""Options of the generator for each feature; a new feature needs an entry."""


def options_in(scene):
    return dict(tag.split("=") for tag in scene.tags)


def has(feature, options):
    return any(options[aspect] == option for aspect, option in FEATURE_OPTIONS[feature])


def touching_rails(scene):
    """Return which ball touches which cushion, (n, 4)."""
    touches = np.zeros((len(scene.balls), 4), dtype=bool)
    height, flies = scene.physics.cushion_height, scene.physics.airborne
    for i, ball in enumerate(scene.balls):
        edge = reach({"radius": ball.radius}, {"airborne": flies, "cushion_height": height})
        for side in () if scene.table is None else scene.table.sides:
            gap = side.distance(*ball.position[:2]) - edge
            touches[i, side.cushion] = abs(gap) < 1e-14 and ball.position[2] == ball.radius
    return touches
