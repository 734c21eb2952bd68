"""The status of a finished run of a time-stepping engine, and the reason for an early end."""

from __future__ import annotations

import math

import numpy as np

from ghostball.model import Samples, Scene, Status
from ghostball.reference_adapters.stepping.settings import SteppingSettings


def end_of(scene: Scene, settings: SteppingSettings) -> float:
    """Return the time at which a run ends, unless all balls come to rest earlier [s]."""
    t_max = math.inf if scene.t_max is None else scene.t_max
    return min(t_max, settings.max_time)


def ending_of(
    scene: Scene, settings: SteppingSettings, t: float, state: Samples, *, at_rest: bool
) -> tuple[Status, str]:
    """Return the status of a run that ended at time t [s], and the reason for an early end, or "".

    `state`: Samples, arrays (1, n, 3), the state of the balls at that time.
    """
    if at_rest:
        return Status.REST, ""
    if scene.t_max is not None and t >= scene.t_max:
        return Status.T_MAX, ""
    speeds = np.linalg.norm(state.velocities[0], axis=1)
    surfaces = scene.radii * np.linalg.norm(state.angular_velocities[0], axis=1)
    fastest = int(np.argmax(np.maximum(speeds, surfaces)))
    by_time = t >= settings.max_time
    limit = "`max_time`" if by_time else "`max_steps`"
    value = f"{settings.max_time:g} s" if by_time else f"{settings.max_steps} (at t = {t:.6g} s)"
    return (
        Status.STEP_LIMIT,
        f'{limit} = {value} was reached in scene "{scene.name}" before all balls came to rest: '
        f'ball "{scene.balls[fastest].id}" moves at {speeds[fastest]:.3g} m/s with a surface '
        f"speed of {surfaces[fastest]:.3g} m/s. Raise {limit}, or set `t_max`",
    )
