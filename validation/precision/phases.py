"""Start a shot earlier, so that the time steps of an engine have another phase.

An engine detects a contact up to one step late, so its error depends on the phase of the step at
the contact, like a sawtooth. No engine here can change the length of its first step. But a shot can
start a fraction of a step earlier, at states from which the cloth leads to those of the scene, if
nothing happens in between. It is the same shot up to rounding, with another phase of all steps.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from ghostball.model import Ball, Scene, SceneError, Status
from ghostball.validation.runs.engine_runs import run_ours
from ghostball.validation.runs.rolling import rolling_spin

RETURN_TOLERANCE: Final = 1e-12
"""Largest difference, in m, m/s and m/s of a surface, between the scene and the shot started
earlier.

Rounding causes 1e-15; any event in between causes much more.
"""


def part_of_step(turn: int) -> float:
    """Return the phase of the step for a sample: 0, 1/2, 1/4, 3/4, 1/8, ...

    The first 1, 2, 4, 8, ... phases are spread evenly. This is the sequence of van der Corput
    (1935) in base 2: the binary digits of the index, mirrored at the point.
    """
    part, digit = 0.0, 0.5
    while turn:
        turn, bit = divmod(turn, 2)
        part += bit * digit
        digit /= 2.0
    return part


def start_of(scene: Scene, step: float | None, turn: int) -> Scene:
    """Return the shot with the start for a sample and a step [s], or the scene itself.

    `step`: None for an engine without a time step: all samples have the same start.
    """
    if step is None:
        return scene
    return started_earlier(scene, part_of_step(turn) * step) or scene


def started_earlier(scene: Scene, dt: float) -> Scene | None:
    """Return the scene `dt` [s] before its start, or None if the earlier state isn't known.

    Its `t_max` is later by `dt`. The earlier state isn't known if a ball had a collision in
    between, or would start on the other side of a cushion or inside a ball.

    Rolling: v = v0 + mu g dt along v0. Sliding: the slip keeps its direction and grows by 7/2 mu g
    dt. Spin about the vertical grows by its deceleration. The result is checked by simulating it
    for `dt` on Ghostball's engine.
    """
    if dt == 0.0:
        return scene
    try:
        balls = [_earlier(scene, i, dt) for i in range(len(scene.balls))]
        t_max = None if scene.t_max is None else scene.t_max + dt
        earlier = Scene(**{**dict(scene), "balls": balls, "t_max": t_max})
    except SceneError:
        return None
    return earlier if _returns(earlier, scene, dt) else None


def _earlier(scene: Scene, i: int, dt: float) -> Ball:
    """Return the undisturbed state of a ball `dt` before."""
    ball, physics = scene.balls[i], scene.physics
    r, v = np.array(ball.position), np.array(ball.velocity)
    w = scene.angular_velocities[i].copy()
    w[2] += np.copysign(scene.spinning_friction_rates[i] * dt, w[2]) if w[2] != 0.0 else 0.0
    speed, radius, g = ball.speed, ball.radius, physics.gravity
    slides = physics.motion == "sliding" and not scene.rolls[i]
    if slides:
        slip = np.array([v[0] - radius * w[1], v[1] + radius * w[0]])
        u = slip / np.hypot(*slip)
        a = -scene.sliding_frictions[i] * g * np.array([*u, 0.0])
        rate = 2.5 * scene.sliding_frictions[i] * g / radius
        w[:2] -= rate * dt * np.array([-u[1], u[0]])
    elif speed > 0.0:
        a = -scene.rolling_frictions[i] * g * v / speed
    else:
        a = np.zeros(3)
    start, velocity = r - v * dt + 0.5 * a * dt**2, v - a * dt
    if not slides:
        w[:] = rolling_spin(velocity.tolist(), radius, float(w[2]))
    return Ball(
        **{
            **dict(ball.without_strike()),
            "position": tuple(start.tolist()),
            "velocity": tuple(velocity.tolist()),
            "angular_velocity": tuple(w.tolist()),
        }
    )


def _returns(earlier: Scene, scene: Scene, dt: float) -> bool:
    """Return True if the earlier shot reaches the states of the scene without events."""
    run = run_ours(earlier.model_copy(update={"t_max": dt}), "events")
    if run.status is not Status.T_MAX or run.events is None or len(run.events):
        return False
    state, radii = run.final_state, scene.radii[:, np.newaxis]
    differences = (
        state.positions[0] - scene.positions,
        state.velocities[0] - scene.velocities,
        radii * (state.angular_velocities[0] - scene.angular_velocities),
    )
    return max(float(np.abs(d).max()) for d in differences) <= RETURN_TOLERANCE
