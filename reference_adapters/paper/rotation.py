"""How the paper turns its balls, section 5.3: once a frame, about an axis in the plane.

As printed: the axis is r = v x k, normalised, the angular velocity v / R, so that a frame turns by
|v| dt / R; its quaternion times the one so far is the new orientation. With k up a ball rolls about
k x v: as printed it turns backwards.

The velocity is the frame's, after its collisions. Within a frame that slows, this falls short of
the way that is rolled; between two that a collision parts, it has the wrong axis for a part of
a frame. A ball that slides, or spins about the vertical, turns as if it rolled.
"""

from __future__ import annotations

import numpy as np

from ghostball.model.arrays import FloatArray
from ghostball.model.trajectory.orientation import hamilton_product


def turned_by_frames(velocities: FloatArray, radii: FloatArray, dt: float) -> FloatArray:
    """Return the orientation that the paper's rule gives balls after each of k frames.

    `velocities` (k, n, 3) float64 [m/s]: of each frame, as it is shown.
    `radii` (n,) float64 [m].
    `dt` [s]: from each frame to the next.

    Returns (k, n, 4) float64: unit quaternions, w first; the first frame turns from (1, 0, 0, 0).
    """
    vx, vy = velocities[..., 0], velocities[..., 1]
    speed = np.hypot(vx, vy)
    moves = speed > 0.0
    half = 0.5 * dt * speed / radii
    turns = np.zeros((*speed.shape, 4))
    turns[..., 0] = np.cos(half)
    # v x k = (vy, -vx, 0)
    np.divide(np.sin(half) * vy, speed, out=turns[..., 1], where=moves)
    np.divide(-np.sin(half) * vx, speed, out=turns[..., 2], where=moves)
    for k in range(1, len(turns)):
        turns[k] = hamilton_product(turns[k], turns[k - 1])
    return turns
