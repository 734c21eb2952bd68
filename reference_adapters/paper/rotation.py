"""The paper's rotation of balls, section 5.3: once per frame, about an axis in the plane.

As printed, the axis is r = v x k, normalised, and the angular velocity v / R, so a frame rotates
the ball by |v| dt / R; its quaternion times the previous one is the new orientation. With k up, a
ball rolls about k x v, so as printed it rotates backwards.

The velocity is that of the frame after its collisions. In a frame with friction, the rotation is
smaller than that of the rolled distance; in a frame with a collision, the axis is wrong for a part
of the frame. A ball that slides, or has vertical spin, rotates as if it rolled.
"""

from __future__ import annotations

import numpy as np

from ghostball.model.arrays import FloatArray
from ghostball.model.trajectory.orientation import hamilton_product


def turned_by_frames(velocities: FloatArray, radii: FloatArray, dt: float) -> FloatArray:
    """Return the orientations of balls by the paper's rule, after each of k frames.

    `velocities`: (k, n, 3) float64 [m/s], of each frame, as displayed.
    `radii`: (n,) float64 [m].
    `dt`: time between frames [s].

    Returns (k, n, 4) float64, unit quaternions, w first; the first frame starts from (1, 0, 0, 0).
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
