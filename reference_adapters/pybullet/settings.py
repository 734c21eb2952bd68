"""Settings of the pybullet adapter, and bounds of Bullet's."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from ghostball.reference_adapters.stepping.settings import SteppingSettings

SHORTEST_STEP = float(np.finfo(np.float64).eps)
"""Shortest step that Bullet makes [s]; it takes a shorter one for none, and moves nothing."""

MOST_IMPULSE = 1e10
"""Bound of Bullet's solver on the impulse of a contact in a step [N s]: more stops no ball."""


class PybulletSettings(SteppingSettings):
    """Settings of the pybullet adapter.

    `dt` is 1e-3 s tuned, pybullet's own 1/240 s naive, 0.02 s in exact steps; `iterations`
    pybullet's own 50.
    """

    NAIVE_DT: ClassVar[float] = 1.0 / 240.0
    EXACT_IF_NAIVE: ClassVar[bool] = False

    iterations: Annotated[int, Field(ge=1)] = 50
