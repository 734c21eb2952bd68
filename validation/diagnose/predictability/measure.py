"""Measures how far a shot can be predicted, from runs of our engine."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import Result, Scene
from ghostball.engine.running.skips import has_drag
from ghostball.engine.sensitivity import PARTS
from ghostball.validation.diagnose.predictability.prediction import Predictability, Separation
from ghostball.validation.grading.event_logs import events_in
from ghostball.validation.grading.horizon import growth_along, horizon
from ghostball.validation.grading.tolerances import ROUNDINGS, TIE, TOLERANCE, UNIT_ROUNDOFF
from ghostball.validation.results.records import scene_hash
from ghostball.validation.runs.our_run import run_ours
from ghostball.validation.runs.rolling import rolling_spin
from ghostball.validation.runs.sampling import events_of, union_times
from ghostball.validation.truth.proof import proof_of

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
    growth = growth_along(scene, proof_of(scene)[0], result)
    until = horizon(growth, TOLERANCE, ROUNDINGS * UNIT_ROUNDOFF)
    ends = "growth" if math.isfinite(until) else ""
    if math.isinf(until) and math.isfinite(growth.derivative_ends):
        # What grew before a tie, or a contact that lasts, says nothing of what comes after it.
        until, ends = growth.derivative_ends, _why_unknown(result, growth.derivative_ends)
    times = union_times(result.rest_time, events_of(result)["t"], uniform=_UNIFORM, limit=_LIMIT)
    return Predictability(
        scene.name,
        result.rest_time,
        TOLERANCE,
        until if math.isfinite(until) else None,
        ends,
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


def _why_unknown(result: Result, t: float) -> str:
    """Return why no derivative exists from an instant on [s]."""
    if has_drag(result.scene) or result.scene.physics.airborne:
        return "no derivative in air, or in flight"
    last = [one for one in events_in(events_of(result)) if abs(one.t - t) <= TIE * t]
    balls = [ball for one in last for ball in one.balls]
    tied = len(set(balls)) < len(balls)
    return "several collisions at one instant" if tied else "sustained contact"


def _finite(values: FloatArray) -> FloatArray:
    """Return the values with nan for what isn't finite."""
    finite: FloatArray = np.where(np.isfinite(values), values, np.nan)
    return finite
