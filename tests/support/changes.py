"""Check tangent maps against small changes of a recorded shot."""

from __future__ import annotations

import numpy as np

from ghostball.engine import simulate
from ghostball.engine.sensitivity import QUALITY, ROUNDING
from ghostball.model import Result, Scene


def recorded(scene: Scene) -> Result:
    """Simulate a scene and record its trajectory."""
    return simulate(scene, record="trajectory")


def one_direction(n: int, **parts: tuple[float, ...]) -> np.ndarray:
    """Return a change of the first ball's position `r`, velocity `v` or angular velocity `w`."""
    direction = np.zeros((1, n, 7))
    for name, place in (("r", slice(0, 2)), ("v", slice(2, 4)), ("w", slice(4, 7))):
        if name in parts:
            direction[0, 0, place] = parts[name]
    return direction


def moved(scene: Scene, change: np.ndarray) -> Scene:
    """Return the scene with changes (n, 7) of all balls' states; rolling balls still roll."""
    balls = []
    for one, rolls, d in zip(scene.balls, scene.rolls, change, strict=True):
        update = {
            name: (*np.add(vector[:2], by), *vector[2:])
            for name, vector, by in (
                ("position", one.position, d[:2]),
                ("velocity", one.velocity, d[2:4]),
            )
        }
        if not rolls:
            update["angular_velocity"] = tuple(np.add(one.angular_velocity, d[4:]))
        balls.append({**one.model_dump(exclude_none=True), **update})
    return Scene.model_validate({**scene.model_dump(by_alias=True), "balls": balls})


def check_derivatives(scene: Scene) -> None:
    """Check the tangent map against central differences, at times throughout the shot."""
    result = recorded(scene)
    times = np.linspace(0.05, 0.95, 7) * result.rest_time
    for change in directions_of(result.scene, 3):
        after, before, predicted = _both_sides(result, change, times)
        difference = recorded(after).sample(times).positions
        difference -= recorded(before).sample(times).positions
        error = np.max(np.abs(difference[..., :2] - predicted[..., :2]), axis=(1, 2))
        rounding = 2 * QUALITY * ROUNDING * np.max(result.sensitivity(times), axis=1)
        assert np.all(error < 1e-5 * np.max(np.abs(predicted), axis=(1, 2)) + rounding)


def _both_sides(result, change, times):
    """Return the scene with a tiny change, with the opposite change, and the predicted difference.

    The prediction of the tangent map, (k, n, 7) at `times`, starts from the actual difference of
    the two scenes, whose numbers are rounded.
    """
    (largest,) = np.max(np.abs(result.tangent(change[np.newaxis]).sample(times)), axis=(0, 2, 3))
    size = 1e-7 / largest
    after, before = (moved(result.scene, sign * size * change) for sign in (1, -1))
    real = np.hstack(
        [
            (after.positions - before.positions)[:, :2],
            (after.velocities - before.velocities)[:, :2],
            after.angular_velocities - before.angular_velocities,
        ]
    )
    real[result.scene.rolls, 4:] = 0.0
    return after, before, result.tangent(real[np.newaxis]).sample(times)[:, 0]


def directions_of(scene: Scene, count: int) -> np.ndarray:
    """Return random changes of the positions, and of the velocities of moving balls, (count, n, 7).

    Only moving balls that don't roll get changes of the angular velocity.
    """
    generator = np.random.default_rng(7)
    n = len(scene.balls)
    directions = np.zeros((count, n, 7))
    moving = np.any(scene.velocities != 0.0, axis=1)
    directions[:, :, :2] = 0.01 * generator.normal(size=(count, n, 2))
    directions[:, moving, 2:4] = generator.normal(size=(count, int(moving.sum()), 2))
    free = moving & ~scene.rolls
    directions[:, free, 4:] = 10.0 * generator.normal(size=(count, int(free.sum()), 3))
    return directions
