"""The laws of a scene as coefficients of Bullet's bodies.

Bullet multiplies the coefficients of the two bodies of a contact. Every coefficient of the scene is
therefore split into two factors with the right product for each pair of bodies.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ghostball.model import Scene
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.stepping.laws import (
    ball_friction,
    cushion_friction,
    multiplied_restitutions,
)

SMALLEST_FRICTION = 1e-12
"""Ball-ball friction used for 0 if the cloth or the cushions have friction [1].

An impact at 10 m/s then has a throw of 1e-11 m/s.
"""


@dataclass(frozen=True)
class Coefficients:
    """The scene's laws as factors per body; the product for each pair is the value of the scene.

    `ball_restitution`, `cushion_restitution`, `ball_friction`, `cushion_friction`: factors [1].
    `table_restitution`: factor of the table [1]; 0 if balls stay on the cloth.
    `table_friction`: (n,) float64, factor of the table under each ball [1]. If they differ, each
        ball has its own table.
    `rolling_friction`, `spinning_friction`: (n,) float64, lengths for each ball, for Bullet's
        rolling and spinning friction [m]: the moment is length x friction of the table x normal
        force.
    """

    ball_restitution: float
    cushion_restitution: float
    ball_friction: float
    cushion_friction: float
    table_restitution: float
    table_friction: FloatArray
    rolling_friction: FloatArray
    spinning_friction: FloatArray

    @classmethod
    def of(cls, scene: Scene, *, planar: bool) -> Coefficients:
        """Split the laws of `scene` into factors; with `planar`, all friction is 0.

        A ball that rolls without slip under a moment M about its contact decelerates by M R / (I +
        m R^2) = M / (7/5 m R): for mu_r g, the length is (7/5) mu_r R / table friction. A spinning
        ball decelerates by M / I: for a rate s, the length is (2/5) R^2 s / (g table friction).
        """
        physics = scene.physics
        restitution, cushion = multiplied_restitutions(physics)
        none = np.zeros(len(scene.balls))
        if planar:
            return cls(restitution, cushion, 0.0, 0.0, 0.0, none, none, none)
        friction = math.sqrt(max(ball_friction(scene), SMALLEST_FRICTION))
        table = scene.sliding_frictions / friction
        return cls(
            restitution,
            cushion,
            friction,
            cushion_friction(physics) / friction,
            physics.table_restitution / restitution if physics.airborne else 0.0,
            table,
            1.4 * scene.rolling_frictions * scene.radii / table,
            0.4 * scene.spinning_friction_rates * scene.radii**2 / (physics.gravity * table),
        )

    @property
    def own_tables(self) -> bool:
        """Whether each ball has its own table."""
        return bool(np.any(self.table_friction != self.table_friction[0]))
