"""Bullet in the plane, compared with closed forms.

Scenes use mu = 0.1 if the results don't depend on it, so that shots are short. On a Python without
pybullet, these tests are skipped with the adapter's own reason.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from shots import R

from ghostball.model import CUSHIONS, Ball, EventKind, Physics, Record, Result, Scene, Status, Table
from ghostball.reference_adapters.pybullet.engine import PybulletEngine, PybulletSettings

G = 9.81
TABLE = Table(length=2.0, width=1.0)


def run(scene: Scene, record: Record = "events", **settings: Any) -> Result:
    reason = PybulletEngine.unavailable()
    if reason is not None:
        pytest.skip(reason)
    return PybulletEngine(PybulletSettings(**settings)).simulate(scene, record=record)


def shot(
    *balls: dict[str, Any], table: Table | None = None, t_max: float | None = None, **physics: Any
) -> Scene:
    return Scene(
        name="shot",
        balls=[Ball(id=str(i), **ball) for i, ball in enumerate(balls)],
        physics=Physics(**{"rolling_friction": 0.1, **physics}),
        table=table,
        t_max=t_max,
    )


def log(result: Result) -> list[tuple[str, int, int]]:
    assert result.events is not None
    return [(EventKind(e["kind"]).label, int(e["a"]), int(e["b"])) for e in result.events]


@pytest.mark.parametrize("dt", [1e-3, 7e-3, 0.5])
def test_a_ball_stops_where_the_closed_form_says_at_any_step(dt: float) -> None:
    # Without the half kick the error is v dt / 2; a threshold for rest adds its own distance. Rest
    # is detected at the end of a step.
    result = run(shot({"position": (0, 0), "velocity": (0.6, 0.8)}), dt=dt)
    deceleration = 0.1 * G
    distance = 1.0 / (2.0 * deceleration)
    assert result.rest_positions[0] == pytest.approx([0.6 * distance, 0.8 * distance, R], abs=1e-11)
    assert 0.0 <= result.rest_time - 1.0 / deceleration <= dt
    assert not np.any(result.final_state.velocities)
    assert log(result) == [("roll-to-rest", 0, -1)]
    assert result.status is Status.REST


@pytest.mark.parametrize("cushion", CUSHIONS)
def test_only_the_cushions_that_exist_are_hit_and_each_by_its_index(cushion: Any) -> None:
    table = Table(length=1.0, width=1.0, cushions=(cushion,))
    balls = [
        {"position": (0.5 + 0.2 * x, 0.5 + 0.2 * y), "velocity": (1.2 * x, 1.2 * y)}
        for x, y in ((-1, 0), (1, 0), (0, -1), (0, 1))
    ]
    result = run(shot(*balls, table=table))
    index = CUSHIONS.index(cushion)
    collisions = [entry for entry in log(result) if entry[0] != "roll-to-rest"]
    assert collisions == [("ball-cushion", index, index)]


def test_a_ball_that_only_rolls_along_a_cushion_does_not_hit_it() -> None:
    # Bullet lists a plane this close as a contact without force.
    scene = shot({"position": (0.1, R + 1e-4), "velocity": (1, 0)}, table=TABLE)
    assert run(scene).collision_counts["ball-cushion"] == 0


def test_the_naive_configuration_keeps_what_pybullet_does_on_its_own() -> None:
    # Bullet's damping: v' = -mu g - k (1 + v) v with k = 0.04 1/s, so x = integral of v dv / -v'.
    scene = shot({"position": (0, 0), "velocity": (1, 0)})
    v = (np.arange(1000) + 0.5) / 1000
    expected = float(np.mean(v / (0.1 * G + 0.04 * (1 + v) * v)))
    result = run(scene, config="naive")
    assert result.rest_positions[0, 0] == pytest.approx(expected, rel=1e-3)
    assert result.rest_positions[0, 0] < 0.98 / (2 * 0.1 * G)
    assert result.settings["dt"] == 1 / 240
    assert run(scene).settings["dt"] == 1e-3
    assert run(scene, contact_steps="exact").settings["dt"] == 0.02


@pytest.mark.parametrize("speed", [1.0, 1e6, 1e8])
def test_exact_steps_at_speeds_that_close_a_gap_sooner_than_bullet_steps(speed: float) -> None:
    """Touching balls must not stay in place step after step."""
    scene = shot(
        {"position": (0, 0), "velocity": (speed, 0)},
        {"position": (0.3, 0)},
        t_max=0.5 / speed,
        rolling_friction=0.0,
    )
    result = run(scene, contact_steps="exact", max_steps=100)
    assert result.status is Status.T_MAX
    assert log(result) == [("ball-ball", 0, 1)]  # the collision stops one ball, not the cloth
    resolution = PybulletEngine(PybulletSettings(contact_steps="exact")).resolution(scene)
    assert resolution == max(1e-10, speed * 2.0**-52)
    contact = 0.3 - 2.0 * R
    np.testing.assert_allclose(
        result.rest_positions[:, 0], [contact, 0.8 - contact], rtol=0, atol=4.0 * resolution
    )


@pytest.mark.parametrize("steps", ["fixed", "exact"])
def test_the_hardest_impulses_are_bullets(steps: str) -> None:
    """An impulse above Bullet's limit would let the balls move into each other."""
    scene = shot(
        {"position": (0, 0), "velocity": (4000, 0), "mass": 1e6},
        {"position": (0.3, 0), "mass": 1e6},
        t_max=0.5 / 4000,
        rolling_friction=0.0,
    )
    result = run(scene, contact_steps=steps, dt=1e-6)
    assert log(result)[0] == ("ball-ball", 0, 1)
    np.testing.assert_allclose(
        result.final_state.velocities[0, :, 0], [0.0, 4000.0], rtol=0, atol=1e-6
    )
