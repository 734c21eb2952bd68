"""The laws of a scene as coefficients of Bullet's bodies.

Bullet multiplies the coefficients of the two bodies of a contact. So every law of the scene is
split in two factors, such that each pair of bodies multiplies to what the scene says.
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
"""Ball-ball friction that stands for 0 where cloth or cushions need some [1].

Of an impact at 10 m/s it leaves 1e-11 m/s of throw.
"""


@dataclass(frozen=True)
class Coefficients:
    """The scene's laws as factors per body, such that each pair multiplies to the scene's value.

    `ball_restitution`, `cushion_restitution`, `ball_friction`, `cushion_friction`: factors [1].
    `table_restitution`: factor of the table [1]: 0 where balls stay on the cloth.
    `table_friction` (n,) float64: factor of the table under each ball [1]. Where they differ, each
        ball lies on a table of its own.
    `rolling_friction`, `spinning_friction` (n,) float64: lengths [m] of each ball, for Bullet's own
        resistance: its moment is length x friction of the table x normal force.
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
        """Split the laws of `scene`; `planar` leaves all friction out.

        A ball that rolls without slip under a moment M about its contact decelerates by
        M R / (I + m R^2) = M / (7/5 m R): for mu_r g the length is (7/5) mu_r R / table friction.
        One that spins decelerates by M / I: for a rate s it is (2/5) R^2 s / (g table friction).
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
        """Whether each ball lies on a table of its own."""
        return bool(np.any(self.table_friction != self.table_friction[0]))
