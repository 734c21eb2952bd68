"""Growth of small changes of a shot, from an exactly recorded motion.

The results of our engine and certified motions use this module.
"""

from __future__ import annotations

from numpy.typing import ArrayLike

from ghostball.model import Events, ExactTrajectory, Scene
from ghostball.model.trajectory import TangentMap


def tangents_of(
    scene: Scene, trajectory: ExactTrajectory, events: Events, directions: ArrayLike | None
) -> TangentMap:
    """Return the effects of small changes of a shot; see `model.trajectory.Tangents`."""
    # Imported here, because most shots don't need these modules.
    from ghostball.engine.sensitivity import rounding_of, tangent_of  # noqa: PLC0415

    if directions is None:
        return rounding_of(scene, trajectory, events)
    return tangent_of(scene, trajectory, events, directions)
