"""Measures how far a shot can be predicted, from runs of our engine."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import EventKind, Result, Scene
from ghostball.engine.running.skips import has_drag
from ghostball.engine.sensitivity import PARTS
from ghostball.validation.diagnose.predictability.prediction import Predictability, Separation
from ghostball.validation.grading.tolerances import TOLERANCE
from ghostball.validation.results.records import scene_hash
from ghostball.validation.runs.our_run import run_ours
from ghostball.validation.runs.rolling import rolling_spin
from ghostball.validation.runs.sampling import events_of, union_times
from ghostball.validation.truth.horizons import rounding_horizon

FloatArray = NDArray[np.float64]

CHAOS = "chaos"
"""Tag of scenes whose shots are also compared with neighbouring ones."""

SIZES = (1e-4, 1e-7, 1e-10, 1e-13)
"""By how much the fastest ball of a neighbouring shot is faster [m/s]. The first is the paper's
(section 4.2): changes as small as .0001 vastly change the final resting state."""

_UNIFORM, _LIMIT = 200, 600  # instants: on a grid, and at most


def predictability_of(scene: Scene, result: Result | None = None) -> Predictability:
    """Measure how far a shot can be predicted.

    Parameters
    ----------
    scene : Scene
    result : Result, optional
        Its run by our engine, recorded with `record="trajectory"`, where there is one.

    Raises
    ------
    UnsupportedSceneError
        Where our engine lacks physics that the scene needs.
    """
    result = run_ours(scene) if result is None else result
    horizon = rounding_horizon(scene)
    if math.isinf(horizon) and not _has_no_derivative(scene):
        # A proof goes on after a tie, or a contact that lasts; what grew before says no more.
        own = result.horizon(TOLERANCE)
        if math.isfinite(own) and not np.all(np.isfinite(result.sensitivity(own))):
            horizon = own
    times = union_times(result.rest_time, events_of(result)["t"], uniform=_UNIFORM, limit=_LIMIT)
    return Predictability(
        scene.name,
        result.rest_time,
        TOLERANCE,
        horizon if math.isfinite(horizon) else None,
        _ends(result, horizon),
        times,
        _finite(np.max(result.sensitivity(times), axis=1)),
        separations_of(result, times) if CHAOS in scene.tags and scene.velocities.any() else (),
        scene_hash(scene),
    )


def separations_of(result: Result, times: FloatArray) -> tuple[Separation, ...]:
    """Compare a shot with those whose fastest ball is faster by `SIZES`, at `times`."""
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
    return tuple(separations)


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


def _ends(result: Result, horizon: float) -> str:
    """Return what a horizon comes from."""
    if not math.isfinite(horizon):
        return ""
    if np.all(np.isfinite(result.sensitivity(horizon))):
        return "growth"
    if _has_no_derivative(result.scene):
        return "no derivative in air, or in flight" if horizon == 0.0 else "growth"
    events = events_of(result)
    collisions = events[(events["kind"] <= EventKind.BALL_CUSHION) & (events["t"] <= horizon)]
    last = collisions[collisions["t"] == horizon]
    balls = [*last["a"], *last["b"][last["kind"] == EventKind.BALL_BALL]]
    tied = len(set(balls)) < len(balls)
    return "several collisions at one instant" if tied else "sustained contact"


def _has_no_derivative(scene: Scene) -> bool:
    return has_drag(scene) or scene.physics.airborne


def _finite(values: FloatArray) -> FloatArray:
    """Return the values with nan for what isn't finite."""
    finite: FloatArray = np.where(np.isfinite(values), values, np.nan)
    return finite
