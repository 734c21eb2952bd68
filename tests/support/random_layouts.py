"""What random scenes are looked at for: their options, and which balls touch which cushions."""

import numpy as np

from ghostball.validation.scenes.random_parts import reach
from ghostball.validation.scenes.random_scenes import OF_FEATURES

FEW = range(200)
"""What `make test` plays, each with a few balls; more of them take most of the time."""


def options_in(scene):
    return dict(tag.split("=") for tag in scene.tags)


def has(feature, options):
    return any(options[aspect] == option for aspect, option in OF_FEATURES[feature])


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
