"""Simulation of one scene with one ball shot at many speeds and angles."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ghostball.engine.batch import Batch, workers_of
from ghostball.engine.running.calls import Limits
from ghostball.engine.shot import MAX_EVENTS, MAX_WORK, check_request
from ghostball.engine.starts import Given, play_starts
from ghostball.engine.strokes import numbers_of
from ghostball.model import Ball, Scene, rolling_angular_velocity
from ghostball.model.errors import GhostballError
from ghostball.model.sines import cosines_and_sines


def simulate_sweep(
    scene: Scene,
    speeds: ArrayLike,
    angles: ArrayLike,
    *,
    ball: int | str = 0,
    threads: int | None = None,
    max_events: int = MAX_EVENTS,
    max_work: int = MAX_WORK,
) -> Batch:
    """Simulate one scene with one ball shot at each of k speeds and angles.

    Parameters
    ----------
    scene : Scene
        The shot moves its ball `ball`. If this ball has an angular velocity of its own, or is
        struck by a cue, its spin is rotated with the direction and scaled with the speed, as if the
        tip hit the same spot; otherwise it rolls. An upward velocity is scaled with the speed, too.
    speeds : (k,) float64 [m/s], or one number for all; more than 0
        Speeds of the ball over the cloth.
    angles : (k,) float64 [rad], or one number for all; from the x axis, counterclockwise
    ball : int or str
        Index or id of the ball that is shot.
    threads, max_events, max_work
        As for `simulate_many`.

    Returns
    -------
    Batch
        Bit-identical to `simulate` with such scenes, but faster, because no scene is built.

    Raises
    ------
    UnsupportedSceneError, GhostballError
        If the scene, or an argument, is invalid; SceneError if a scene with such a shot would be
        invalid.
    """
    workers = workers_of(threads)
    check_request(scene, "rest", max_events, max_work)
    who = scene.index_of(ball, "ball")
    shot = scene.balls[who]
    with np.errstate(over="ignore", invalid="ignore"):  # the rules reject infinite numbers
        velocity, spin = _cue_motions(shot, speeds, angles)
    given = Given(
        who,
        np.broadcast_to(np.array(shot.position), velocity.shape)[:, None],
        velocity[:, None],
        spin[:, None],
        np.array([shot.angular_velocity is not None]),
    )
    return play_starts(scene, given, Limits(max_events, max_work), workers)


def _cue_motions(
    shot: Ball, speeds: ArrayLike, angles: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return velocities (k, 3) and angular velocities (k, 3) of the ball that is shot."""
    speed, angle = numbers_of("speeds", speeds), numbers_of("angles", angles)
    if len(speed) != len(angle) and 1 not in (len(speed), len(angle)):
        raise GhostballError(
            f"`speeds` and `angles` must have the same length, or one of them length 1, got "
            f"{len(speed)} and {len(angle)}. For a grid, give all pairs: numpy.meshgrid, raveled"
        )
    if np.any(speed <= 0.0):
        raise GhostballError(f"`speeds` must be more than 0 m/s, got {speed[speed <= 0.0][0]}")
    speed, angle = np.broadcast_arrays(speed, angle)
    cosine, sine = cosines_and_sines(angle)
    velocity = np.zeros((len(speed), 3))
    velocity[:, 0], velocity[:, 1] = speed * cosine, speed * sine
    along, over_cloth = _direction(shot)
    if over_cloth == 0.0 and shot.velocity[2] != 0.0:
        raise GhostballError(
            f'ball "{shot.id}" goes straight up or down, so its velocity can\'t be turned or '
            "scaled. Give it a velocity over the cloth, too"
        )
    if shot.velocity[2] != 0.0:
        velocity[:, 2] = speed / over_cloth * shot.velocity[2]
    if shot.angular_velocity is None:
        return velocity, rolling_angular_velocity(velocity, np.array(shot.radius))
    if over_cloth == 0.0:
        raise GhostballError(
            f"ball \"{shot.id}\" spins but doesn't move, so its spin can't be turned with the "
            "direction. Give it a velocity, or remove its angular velocity"
        )
    factor = speed / over_cloth
    # Cosine and sine of the angle from the ball's direction in the scene to its new direction.
    turned = cosine * along[0] + sine * along[1], sine * along[0] - cosine * along[1]
    wx, wy, wz = shot.angular_velocity
    spin = np.empty_like(velocity)
    spin[:, 0] = factor * (turned[0] * wx - turned[1] * wy)
    spin[:, 1] = factor * (turned[1] * wx + turned[0] * wy)
    spin[:, 2] = factor * wz
    return velocity, spin


def _direction(shot: Ball) -> tuple[tuple[float, float], float]:
    """Return the direction of a ball over the cloth, a unit vector, and its speed [m/s]."""
    x, y, _ = shot.velocity
    scale = max(abs(x), abs(y))  # the square of a tiny or huge speed may under- or overflow
    if scale == 0.0:
        return (1.0, 0.0), 0.0
    length = math.sqrt((x / scale) ** 2 + (y / scale) ** 2)
    return (x / scale / length, y / scale / length), scale * length
