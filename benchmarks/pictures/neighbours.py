"""Shots that begin almost alike: how far apart they come, and what the tangent map says of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import Result, Scene
from ghostball.engine.sensitivity import PARTS
from ghostball.validation.runs.our_run import run_ours
from ghostball.validation.runs.rolling import rolling_spin
from ghostball.validation.runs.sampling import events_of, union_times

FloatArray = NDArray[np.float64]

SIZES = (1e-4, 1e-7, 1e-10, 1e-13)
"""By how much the fastest ball of a neighbouring shot is faster [m/s]. The first is the paper's
(section 4.2): changes as small as .0001 vastly change the final resting state."""

_UNIFORM, _LIMIT = 200, 600  # instants: on a grid, and at most


@dataclass(frozen=True, eq=False)
class Separation:
    """How far apart two shots come that begin almost alike, and what the tangent map says of it.

    Attributes
    ----------
    size : float [m/s]
        What the second shot's fastest ball is faster by at the start.
    apart : (k,) float64 [m]
        The largest distance of a ball in one shot from where it is in the other.
    predicted : (k,) float64 [m]
        That by the tangent map of the first shot; nan where no derivative exists.
    """

    size: float
    apart: FloatArray
    predicted: FloatArray


@dataclass(frozen=True, eq=False)
class Neighbours:
    """A shot with its neighbours.

    Attributes
    ----------
    scene : str
    rest_time : float [s]
    times : (k,) float64 [s]
    growth : (k,) float64 [m]
        The largest `Result.sensitivity` of a ball; nan where no derivative exists.
    separations : tuple of Separation
    """

    scene: str
    rest_time: float
    times: FloatArray
    growth: FloatArray
    separations: tuple[Separation, ...]


def neighbours_of(scene: Scene) -> Neighbours:
    """Compare a shot with those whose fastest ball is faster by `SIZES`."""
    result = run_ours(scene)
    times = union_times(result.rest_time, events_of(result)["t"], uniform=_UNIFORM, limit=_LIMIT)
    growth = _finite(np.max(result.sensitivity(times), axis=1))
    return Neighbours(
        scene.name, result.rest_time, times, growth, tuple(_separations(result, times))
    )


def _separations(result: Result, times: FloatArray) -> list[Separation]:
    scene = result.scene
    fastest = int(np.argmax(np.linalg.norm(scene.velocities, axis=1)))
    direction = np.zeros((1, len(scene.balls), PARTS))
    along = scene.velocities[fastest, :2] / np.linalg.norm(scene.velocities[fastest, :2])
    direction[0, fastest, 2:4] = along
    tangent = result.tangent(direction).sample(times)[:, 0, :, :2]
    growth = _finite(np.max(np.linalg.norm(tangent, axis=2), axis=1))
    places = result.sample(times).positions
    separations = []
    for size in SIZES:
        faster = run_ours(_faster(scene, fastest, size * along))
        distance = np.linalg.norm(faster.sample(times).positions - places, axis=2)
        separations.append(Separation(size, np.max(distance, axis=1), size * growth))
    return separations


def _faster(scene: Scene, ball: int, by: FloatArray) -> Scene:
    """Return the scene with more velocity for a ball; one that rolls rolls on."""
    balls = [one.model_dump(exclude_unset=True) for one in scene.balls]
    velocity = scene.velocities[ball].copy()
    velocity[:2] += by
    balls[ball]["velocity"] = tuple(velocity[:2].tolist())
    if scene.rolls[ball]:
        spin = float(scene.angular_velocities[ball, 2])
        balls[ball]["angular_velocity"] = (
            rolling_spin(velocity.tolist(), float(scene.radii[ball]), spin) if spin else None
        )
    return Scene.model_validate({**scene.model_dump(by_alias=True), "balls": balls})


def _finite(values: FloatArray) -> FloatArray:
    """Return the values with nan for what isn't finite."""
    finite: FloatArray = np.where(np.isfinite(values), values, np.nan)
    return finite
