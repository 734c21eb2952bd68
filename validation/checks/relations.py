"""Relations that must hold between a shot and a second shot made from it.

Each relation is a metric. If a scene has a limit on this metric, the engine also simulates the
second shot. A relation needs no reference result. It has no value if it doesn't hold for a shot of
this kind.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from ghostball.model import Ball, Result, Scene, SceneError, Table, UnsupportedSceneError
from ghostball.reference_adapters.base import ReferenceEngine
from ghostball.validation.checks.energy_curve import conserves_energy
from ghostball.validation.checks.metric import (
    MetricGroup,
    NotMeasuredError,
    RunAndTruth,
    RunIncompleteError,
)
from ghostball.validation.grading.tolerances import ROUNDINGS, UNIT_ROUNDOFF
from ghostball.validation.runs.engine_runs import run_engine, run_ours

RELATIONS: Final = MetricGroup()

RETURN_DISTANCE = 1e-3
"""Largest distance from the start that counts as a return, in radii of the smallest ball."""

_IMAGES: Final = {"left": "bottom", "right": "top", "bottom": "left", "top": "right"}


def _engine_of(run: RunAndTruth) -> ReferenceEngine:
    """Return the engine that simulates the second shot."""
    if run.engine is None:
        raise NotMeasuredError("this metric needs an engine that simulates a second shot")
    run.require_end()
    return run.engine


@RELATIONS.metric(
    "mirror_error",
    "m",
    "largest distance between the mirrored final positions and those of the mirrored shot, with x "
    "and y swapped and the balls in reverse order",
    on_demand=True,
)
def _mirror_error(run: RunAndTruth) -> float:
    # In reverse order, to detect results that depend on the order of balls. An exact engine gives
    # bit-identical results in both cases.
    engine, result = _engine_of(run), run.result
    other = _played(engine, mirrored(result.scene))
    ends = other.rest_positions[::-1][:, [1, 0, 2]]
    return float(np.max(np.linalg.norm(ends - result.rest_positions, axis=1)))


def mirrored(scene: Scene) -> Scene:
    """Return a scene with x and y swapped and its balls in reverse order.

    Raises `NotMeasuredError` if the table is no rectangle.
    """
    table = scene.table
    if table is not None:
        if table.obstacles:
            raise NotMeasuredError("only a rectangular table has a mirror image that is a table")
        cushions = tuple(_IMAGES[side] for side in table.cushions)
        table = Table(length=table.width, width=table.length, cushions=cushions)
    balls = tuple(_image(ball) for ball in reversed(scene.balls))
    return scene.model_copy(update={"table": table, "balls": balls})


def _image(ball: Ball) -> Ball:
    """Return a ball with x and y swapped; a mirror reverses its spin, which is an axial vector."""
    ball = ball.without_strike()
    (x, y, z), (vx, vy, vz) = ball.position, ball.velocity
    spin = ball.angular_velocity
    return ball.model_copy(
        update={
            "position": (y, x, z),
            "velocity": (vy, vx, vz),
            "angular_velocity": None if spin is None else (-spin[1], -spin[0], -spin[2]),
        }
    )


@RELATIONS.metric(
    "reversal_error",
    "m",
    "largest distance from the start after the shot is simulated backwards from its end, unless "
    "rounding alone prevents the return",
    on_demand=True,
)
def _reversal_error(run: RunAndTruth) -> float:
    return _way_back(run)[0]


@RELATIONS.metric(
    "reversal_factor",
    "1",
    "`reversal_error` in units of the error that one rounding per event would cause on the way "
    "back",
    on_demand=True,
)
def _reversal_factor(run: RunAndTruth) -> float:
    error, rounding = _way_back(run)
    return error / rounding


def _way_back(run: RunAndTruth) -> tuple[float, float]:
    """Return the largest distance from the start after the way back, and that of rounding [m].

    Each collision of two balls multiplies errors by about ten, so after some dozens of collisions
    per ball, rounding alone prevents the return. The tangent map of Ghostball's engine on the way
    back gives the size of this effect. Exact motion backwards would reduce errors of the way there
    to their original size; the way back adds errors of its own.
    """
    engine, result = _engine_of(run), run.result
    scene, turn = result.scene, result.rest_time
    if not conserves_energy(scene):
        raise NotMeasuredError("not applicable: energy is lost, so the reversed shot differs")
    if turn <= 0.0:
        raise NotMeasuredError("nothing moves")
    rounding = rounding_of_way_back(scene, turn)
    if ROUNDINGS * rounding > RETURN_DISTANCE * float(np.min(scene.radii)):
        raise NotMeasuredError("rounding alone keeps the reversed shot from returning to its start")
    try:
        back = scene_from_end(result, turn, -1.0)
    except SceneError as error:
        raise RunIncompleteError(f"its final state isn't a valid initial state: {error}") from error
    off = _played(engine, back).rest_positions - scene.positions
    return float(np.max(np.linalg.norm(off[:, :2], axis=1))), rounding


def rounding_of_way_back(scene: Scene, turn: float) -> float:
    """Return the distance from the start that rounding causes on the way back from a time [m].

    It is the rms effect of one rounding at each event, for the ball with the largest displacement,
    and at least one rounding of the largest coordinate.
    """
    there = run_ours(scene.model_copy(update={"t_max": turn}), "rest")
    back = run_ours(scene_from_end(there, turn, -1.0))
    least = float(np.max(np.abs(scene.positions)))
    return UNIT_ROUNDOFF * max(float(np.max(back.sensitivity([turn]))), least)


def scene_from_end(result: Result, t_max: float, sign: float = 1.0) -> Scene:
    """Return the scene that starts at the end of a run; with `sign` -1 it runs backwards.

    For balls that always roll without friction: their velocity determines their spin. All
    horizontal coordinates are copied to the bit.

    Raises `SceneError` if the final positions aren't valid initial positions.
    """
    positions, velocities, _ = (samples[0] for samples in result.final_state)
    balls = [
        ball.without_strike().model_copy(
            update={
                "position": (*r[:2], ball.radius),
                "velocity": (*v[:2], 0.0),
                "angular_velocity": None,
            }
        )
        for ball, r, v in zip(
            result.scene.balls, positions.tolist(), (sign * velocities + 0.0).tolist(), strict=True
        )
    ]
    scene = result.scene
    return Scene(
        name=scene.name, t_max=t_max, physics=scene.physics, table=scene.table, balls=tuple(balls)
    )


def _played(engine: ReferenceEngine, scene: Scene) -> Result:
    """Simulate the second shot; an engine that doesn't finish it fails."""
    try:
        result = run_engine(engine, scene, "rest")
    except UnsupportedSceneError as error:
        raise NotMeasuredError(f"the engine doesn't support the second shot: {error}") from error
    if not result.status.complete:
        raise RunIncompleteError(f"the second shot stopped early ({result.status.value})")
    return result
