"""Bullet in the plane against closed forms: what it promises and what it counts.

Scenes use mu = 0.1 where nothing depends on it, to be short. On a Python without pybullet these
tests are skipped with the adapter's own reason.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ghostball.model import CUSHIONS, Ball, EventKind, Physics, Record, Result, Scene, Status, Table
from ghostball.reference_adapters.pybullet.engine import PybulletEngine, PybulletSettings

R = 0.028575
G = 9.81
TABLE = Table(length=2.0, width=1.0)

EXACT_ERROR = 1e-8
"""A gap of 1e-10 m turns the line of centres by 2e-9 rad, and no ball below rolls 3 m [m]."""


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


def after_one_collision(scene: Scene) -> tuple[np.ndarray, float]:
    """Rest positions (2, 2) of a ball rolling along +x into a resting one; its speed there."""
    cue, other = scene.balls
    deceleration = scene.physics.rolling_friction * scene.physics.gravity
    offset = other.position[1] - cue.position[1]
    reach = cue.radius + other.radius
    along = math.sqrt(reach**2 - offset**2)
    rolled = other.position[0] - along - cue.position[0]
    speed = math.sqrt(cue.speed**2 - 2.0 * deceleration * rolled)
    normal = np.array([along, offset]) / reach
    impulse = (
        (1 + scene.physics.ball_restitution) * speed * normal[0] / (1 / cue.mass + 1 / other.mass)
    )
    starts = np.array([[other.position[0] - along, cue.position[1]], other.position[:2]])
    leaves = np.array([[speed, 0.0] - impulse / cue.mass * normal, impulse / other.mass * normal])
    speeds = np.linalg.norm(leaves, axis=1, keepdims=True)
    return starts + leaves * speeds / (2.0 * deceleration), speed


HALF_BALL = shot({"position": (0, 0), "velocity": (1, 0)}, {"position": (0.3, R)})


@pytest.mark.parametrize("dt", [1e-3, 7e-3, 0.5])
def test_a_ball_stops_where_the_closed_form_says_at_any_step(dt: float) -> None:
    # A missing half kick is off by v dt/2; a threshold for rest by its own distance.
    result = run(shot({"position": (0, 0), "velocity": (0.6, 0.8)}), dt=dt)
    deceleration = 0.1 * G
    distance = 1.0 / (2.0 * deceleration)
    assert result.rest_positions[0] == pytest.approx([0.6 * distance, 0.8 * distance, R], abs=1e-11)
    assert result.rest_time == pytest.approx(1.0 / deceleration, abs=1e-11)
    assert not np.any(result.final_state.velocities)
    assert log(result) == [("roll-to-rest", 0, -1)]
    assert result.status is Status.REST


@pytest.mark.parametrize("dt", [1e-3, 1e-4])
def test_native_error_is_first_order_in_the_step(dt: float) -> None:
    # Bullet sees the contact after up to v dt of overlap, which turns the line of centres by up to
    # v dt tan(phi)/2R. Both bounds shrink with the step; a solver that loses energy breaks them.
    expected, speed = after_one_collision(HALF_BALL)
    result = run(HALF_BALL, dt=dt)
    late = speed * dt
    distances = np.linalg.norm(expected - [[0.3, 0.0]], axis=1)
    turned = late * math.tan(math.radians(30)) / (2 * R)
    errors = np.linalg.norm(result.rest_positions[:, :2] - expected, axis=1)
    assert np.all(errors <= late + 2.0 * turned * distances)
    assert np.max(errors) > EXACT_ERROR
    assert log(result)[0] == ("ball-ball", 0, 1)


@pytest.mark.parametrize("restitution", [1.0, 0.7])
@pytest.mark.parametrize("ball_restitution", [1.0, 0.5, 0.0])
def test_a_cushion_reflects_whatever_the_balls_restitution(
    restitution: float, ball_restitution: float
) -> None:
    # Bullet multiplies restitutions: a ball of 0 would take the cushion's along.
    scene = shot(
        {"position": (0.3, 0.3), "velocity": (-1, 0.2)},
        {"position": (1.8, 0.8)},
        table=TABLE,
        cushion="restitution",
        cushion_restitution=restitution,
        ball_restitution=ball_restitution,
    )
    deceleration, speed = 0.1 * G, math.hypot(1, 0.2)
    direction = np.array([-1, 0.2]) / speed
    rolled = (0.3 - R) / -direction[0]
    at_cushion = math.sqrt(speed**2 - 2 * deceleration * rolled)
    leaves = at_cushion * direction * [-restitution, 1.0]
    expected = [R, 0.3 + rolled * direction[1]] + leaves * np.linalg.norm(leaves) / (
        2 * deceleration
    )
    exact = run(scene, contact_steps="exact")
    assert exact.rest_positions[0, :2] == pytest.approx(expected, abs=EXACT_ERROR)
    assert log(exact)[0] == ("ball-cushion", 0, CUSHIONS.index("left"))
    fixed = run(scene)
    assert fixed.rest_positions[0, :2] == pytest.approx(expected, abs=2e-3)
    assert fixed.collision_counts == {"ball-ball": 0, "ball-cushion": 1}


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


def test_balls_that_stay_in_contact_collide_once() -> None:
    # e = 0, head-on: they roll on together, in contact by rounding alone, and the run must end.
    scene = shot(
        {"position": (0, 0), "velocity": (1, 0)}, {"position": (0.3, 0)}, ball_restitution=0.0
    )
    expected, _ = after_one_collision(scene)
    for settings in ({}, {"contact_steps": "exact"}):
        result = run(scene, **settings)
        assert result.collision_counts["ball-ball"] == 1
        assert result.rest_positions[:, :2] == pytest.approx(expected, abs=1.5e-3)
        assert result.work["steps"] < 1500


def test_a_ball_that_only_rolls_along_a_cushion_does_not_hit_it() -> None:
    # Bullet lists a plane this near as a contact, without a force.
    scene = shot({"position": (0.1, R + 1e-4), "velocity": (1, 0)}, table=TABLE)
    assert run(scene).collision_counts["ball-cushion"] == 0


def test_the_default_configuration_keeps_what_pybullet_does_on_its_own() -> None:
    # Its damping: v' = -mu g - k (1 + v) v with k = 0.04 1/s, so x = integral of v dv / -v'.
    scene = shot({"position": (0, 0), "velocity": (1, 0)})
    v = (np.arange(1000) + 0.5) / 1000
    expected = float(np.mean(v / (0.1 * G + 0.04 * (1 + v) * v)))
    result = run(scene, config="default")
    assert result.rest_positions[0, 0] == pytest.approx(expected, rel=1e-3)
    assert result.rest_positions[0, 0] < 0.98 / (2 * 0.1 * G)
    assert result.settings["dt"] == 1 / 240
    assert run(scene).settings["dt"] == 1e-3
    assert run(scene, contact_steps="exact").settings["dt"] == 0.02


@pytest.mark.parametrize("speed", [1.0, 1e6, 1e8])
def test_exact_steps_at_speeds_that_close_a_gap_sooner_than_bullet_steps(speed: float) -> None:
    """Fails likewise: balls that touch would stay where they are, step after step."""
    scene = shot(
        {"position": (0, 0), "velocity": (speed, 0)},
        {"position": (0.3, 0)},
        t_max=0.5 / speed,
        rolling_friction=0.0,
    )
    result = run(scene, contact_steps="exact", max_steps=100)
    assert result.status is Status.T_MAX
    assert log(result) == [("ball-ball", 0, 1), ("roll-to-rest", 0, -1)]
    resolution = PybulletEngine(PybulletSettings(contact_steps="exact")).resolution(scene)
    assert resolution == max(1e-10, speed * 2.0**-52)
    contact = 0.3 - 2.0 * R
    np.testing.assert_allclose(
        result.rest_positions[:, 0], [contact, 0.8 - contact], rtol=0, atol=4.0 * resolution
    )


@pytest.mark.parametrize("steps", ["fixed", "exact"])
def test_the_hardest_impulses_are_bullets(steps: str) -> None:
    """Fails where Bullet is given an impulse beyond its bound: they continue into each other."""
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
