"""Tests of shots with lengths, times and masses scaled by powers of two: bit-identical results."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import Physics, Scene
from ghostball.validation.stress.extremes import KINDS, bank, cut

SIZES = (
    (0, 30, 0), (19, -13, 20), (-11, 30, -20), (0, -13, 0), (-11, 0, 0), (19, 0, 0),
    (-30, -40, 0), (40, 7, -40), (100, 50, 60), (-100, -60, 30),
)  # fmt: skip
"""Powers of two as factors on lengths, times and masses: speeds times 1e-9 to 1e4, tables of 0.2 mm
to 2e5 m, masses times 1e-6 to 1e6; then far more extreme factors.
"""

AIR = Physics(preset="pool", ball_friction=0.06, air_drag=0.0041)
"""The drag coefficient scales like 1 / length."""


def scaled(scene: Scene, x: float, t: float, m: float) -> Scene:
    """Return the scene with lengths, times and masses multiplied by powers of two.

    All other values follow from their units; frictions and restitutions have none. A law with
    constants that have units, such as "alciatore", doesn't scale.
    """
    balls = [
        ball.model_dump()
        | {
            "position": tuple(x * c for c in ball.position),
            "velocity": tuple(x / t * c for c in ball.velocity),
            "angular_velocity": tuple(w / t for w in ball.angular_velocity or ()) or None,
            "radius": x * ball.radius,
            "mass": m * ball.mass,
        }
        for ball in scene.balls
    ]
    physics = scene.physics.model_dump()
    physics["gravity"] *= x / t**2
    physics["spinning_friction_rate"] /= t**2
    physics["air_drag"] /= x
    if physics["cushion"] == "han2005":
        physics["cushion_height"] *= x
    table = scene.table and {"length": x * scene.table.length, "width": x * scene.table.width}
    return Scene(name="scaled", balls=balls, table=table, physics=physics, t_max=t * scene.t_max)


@pytest.mark.parametrize("physics", [*(Physics(**kind) for kind in KINDS.values()), AIR])
@pytest.mark.parametrize("shape", [cut, bank])
def test_a_shot_is_the_same_at_any_size(physics, shape):
    scene = shape(physics, t_max=0.4)
    one = simulate(scene, record="events")
    # For a tiny or very short shot in air, the drag would be rejected.
    for length, time, mass in SIZES[:6] if physics is AIR else SIZES:
        x, t = 2.0**length, 2.0**time
        other = simulate(scaled(scene, x, t, 2.0**mass), record="events")
        for column in ("kind", "a", "b"):
            assert np.array_equal(other.events[column], one.events[column])
        assert np.array_equal(other.events["t"], t * one.events["t"])
        assert other.rest_time == t * one.rest_time
        for found, first, unit in zip(
            other.final_state, one.final_state, (x, x / t, 1.0 / t), strict=True
        ):
            assert np.array_equal(found, unit * first)
