"""Growth of small changes of a shot, from an exactly recorded motion.

The results of Ghostball's engine and certified motions use this module.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ghostball.model import Events, ExactTrajectory, Phase, Scene, UnsupportedSceneError
from ghostball.model.trajectory import TangentMap
from ghostball.model.trajectory.segment import PHASE


def tangents_of(
    scene: Scene, trajectory: ExactTrajectory, events: Events, directions: ArrayLike | None
) -> TangentMap:
    """Return the effects of small changes of a shot; see `model.trajectory.Tangents`.

    Raises `UnsupportedSceneError` if balls pushed each other in impacts that last.
    """
    if any(np.any(rows[:, PHASE] == Phase.COMPRESSED) for rows in trajectory.segments):
        raise UnsupportedSceneError(
            "ghostball",
            ('no tangent map for `impacts` = "compliant" if several balls push each other',),
        )
    # Imported here, because most shots don't need these modules.
    from ghostball.engine.sensitivity import rounding_of, tangent_of  # noqa: PLC0415

    if directions is None:
        return rounding_of(scene, trajectory, events)
    return tangent_of(scene, trajectory, events, directions)
