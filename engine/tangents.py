"""Finds how small changes of a shot grow, for whatever records its motion exactly.

Our engine gives it along with what it records, and proofs do.
"""

from __future__ import annotations

from numpy.typing import ArrayLike

from ghostball.model import Events, ExactTrajectory, Scene
from ghostball.model.trajectory import TangentMap


def tangents_of(
    scene: Scene, trajectory: ExactTrajectory, events: Events, directions: ArrayLike | None
) -> TangentMap:
    """Return what becomes of small changes of a shot; see `model.trajectory.Tangents`."""
    # Most shots are never asked.
    from ghostball.engine.sensitivity import rounding_of, tangent_of  # noqa: PLC0415

    if directions is None:
        return rounding_of(scene, trajectory, events)
    return tangent_of(scene, trajectory, events, directions)
