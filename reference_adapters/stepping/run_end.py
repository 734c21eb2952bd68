"""A run of a time-stepping engine: its steps, its status, and the reason for an early end."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ghostball.model import Record, Result, Samples, Scene, Status
from ghostball.reference_adapters.recording import Recorder
from ghostball.reference_adapters.stepping.plane import PlaneWorld, WorldStepper
from ghostball.reference_adapters.stepping.settings import SteppingSettings


def run(
    scene: Scene,
    record: Record,
    engine: str,
    settings: SteppingSettings,
    world: PlaneWorld,
    stepper: WorldStepper,
) -> Result:
    """Run until all balls rest, to `t_max`, or to a limit of the settings; return the result.

    `engine`: name of the engine in the result.
    """
    t_end = end_of(scene, settings)
    recorder = Recorder(scene, record)
    steps = 0
    stepper.recorded = record == "trajectory"

    recorder.start()
    stepper.record(recorder)
    while not stepper.at_rest and stepper.t < t_end and steps < settings.max_steps:
        started = stepper.t
        steps += stepper.steps(1 if stepper.recorded else settings.max_steps - steps)
        stepper.tell(recorder, started)
    state = stepper.state()
    status, reason = ending_of(scene, settings, stepper.t, state, at_rest=stepper.at_rest)
    return recorder.result(
        engine=engine,
        settings=settings_as_used(settings, world),
        status=status,
        final_state=state,
        rest_time=stepper.t,
        work={"steps": steps, "contacts_solved": world.contacts_solved},
        engine_time=stepper.engine_time(steps),
        reason=reason,
    )


def settings_as_used(settings: SteppingSettings, world: PlaneWorld) -> dict[str, Any]:
    """Return the settings with the values used in place of None."""
    return settings.model_dump() | {"dt": settings.step, "iterations": world.iterations}


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
