"""Shots made larger, faster, heavier by powers of two: doubles scale so exactly."""

from __future__ import annotations

import numpy as np

from ghostball.model import GhostballError, Result, Scene


def differences(one: Result, other: Result, length: int, time: int) -> list[str]:
    """Return what of a scaled run isn't the run, scaled; exactly."""
    assert one.events is not None
    assert other.events is not None
    x, t = 2.0**length, 2.0**time
    faults = []
    if len(one.events) != len(other.events) or any(
        not np.array_equal(one.events[name], other.events[name]) for name in ("kind", "a", "b")
    ):
        return [f"{len(other.events)} events, or others, instead of {len(one.events)}"]
    pairs = {
        "instants of events": (one.events["t"] * t, other.events["t"]),
        "the end": (np.array([one.rest_time * t]), np.array([other.rest_time])),
        "positions": (one.final_state.positions * x, other.final_state.positions),
        "velocities": (one.final_state.velocities * (x / t), other.final_state.velocities),
        "spins": (one.final_state.angular_velocities / t, other.final_state.angular_velocities),
    }
    for name, (wanted, found) in pairs.items():
        if not np.array_equal(wanted, found):
            off = float(np.max(np.abs(found - wanted) / np.max(np.abs(wanted))))
            faults.append(f"{name} differ by {off:.3g} of the largest")
    return faults


def scaled(scene: Scene, length: int, time: int, mass: int) -> Scene:
    """Return the scene with lengths, times and masses multiplied by powers of two.

    Everything else follows from its unit: speeds, gravity, spins and their decay, drag, the height
    of cushions. Frictions and restitutions have none.

    Raises
    ------
    GhostballError
        Where a law has a constant with a unit that isn't a field.
    """
    x, t, m = 2.0**length, 2.0**time, 2.0**mass
    physics = scene.physics
    if physics.ball_friction == "alciatore":
        raise GhostballError("a law with constants of its own can't be scaled")
    balls = []
    for ball in scene.balls:
        fields = ball.model_dump(exclude_none=True)
        fields["position"] = tuple(x * c for c in ball.position)
        fields["velocity"] = tuple(x / t * c for c in ball.velocity)
        fields["radius"] = x * ball.radius
        fields["mass"] = m * ball.mass
        if ball.angular_velocity is not None:
            fields["angular_velocity"] = tuple(c / t for c in ball.angular_velocity)
        if ball.spinning_friction_rate is not None:
            fields["spinning_friction_rate"] = ball.spinning_friction_rate / t**2
        balls.append(fields)
    table = scene.table
    return Scene.model_validate(
        scene.model_dump(exclude_none=True)
        | {
            "balls": balls,
            "t_max": None if scene.t_max is None else t * scene.t_max,
            "table": table
            and table.model_dump() | {"length": x * table.length, "width": x * table.width},
            "physics": physics.model_dump()
            | {
                "gravity": physics.gravity * x / t**2,
                "spinning_friction_rate": physics.spinning_friction_rate / t**2,
                "air_drag": physics.air_drag / x,
                "rolling_friction_quadratic": physics.rolling_friction_quadratic / x,
            }
            | (
                {"cushion_height": x * physics.cushion_height}
                if physics.cushion in ("han2005", "mathavan2010")
                else {}
            ),
        }
    )
