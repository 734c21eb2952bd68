"""The cushions of a scene as engines that step have them: infinite lines, or parts of these."""

from __future__ import annotations

import numpy as np

from ghostball.model import CUSHIONS, Scene, Side
from ghostball.reference_adapters.stepping.laws import fastest


def sides_of(scene: Scene) -> tuple[Side, ...]:
    """Return the cushions of a scene, in the order of `CUSHIONS`."""
    return () if scene.table is None else scene.table.sides


def reach_beyond(scene: Scene) -> float:
    """Return how far outside an open table a ball can get [m]; 0 where it is closed.

    A cushion is an infinite line; one ball can't have more than all the energy.
    """
    table = scene.table
    if table is None or len(table.cushions) == len(CUSHIONS):
        return 0.0
    speed = fastest(scene)
    frictions = [scene.rolling_frictions]
    if scene.physics.motion == "sliding":
        frictions.append(scene.sliding_frictions)
    deceleration = float(np.min(frictions)) * scene.physics.gravity
    distances = [speed**2 / (2.0 * deceleration)] if deceleration > 0.0 else []
    distances += [speed * scene.t_max] if scene.t_max is not None else []
    outside = float(np.max(np.abs(scene.positions)))  # open sides: a ball may start anywhere
    return outside + min(distances, default=0.0)


def reach_beyond_corners(scene: Scene) -> float:
    """Return how far beyond the corners cushions that end must go [m]: a ball may come from there.

    With a length of the table for ends that are no corners to a ball.
    """
    return reach_beyond(scene) + (0.0 if scene.table is None else scene.table.length)
