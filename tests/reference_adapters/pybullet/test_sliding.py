"""Bullet in 3D, compared with closed forms and Ghostball's engine: slides, spin, and friction.

Our engine is the reference where the capabilities say how far Bullet is from the scene's law. On a
Python without pybullet these tests are skipped with the adapter's own reason.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.model import CUSHIONS, EventKind, Record, Result, Scene, Status, Table
from ghostball.reference_adapters.pybullet.engine import PybulletEngine, PybulletSettings

G = 9.81
TABLE = Table(length=2.0, width=1.0)

SLIDING = {"motion": "sliding", "rolling_friction": 0.05, "sliding_friction": 0.2}

TINY = 1e-6
"""Step in which an impact is detected [s], half a step late; it is too short for other effects."""

LATE = 2e-4
"""Effect of the late detection and of the cloth in a few steps, relative to the speed, or in rad.

Up to v TINY tan(60) / 4R = 3e-5 at 2 m/s, and 20 steps of 2 m/s^2 = 4e-5 m/s, for each ball.
"""


def run(scene: Scene, record: Record = "events", **settings: Any) -> Result:
    reason = PybulletEngine.unavailable()
    if reason is not None:
        pytest.skip(reason)
    return PybulletEngine(PybulletSettings(**settings)).simulate(scene, record=record)


def log(result: Result) -> list[tuple[str, int, int]]:
    assert result.events is not None
    return [(EventKind(e["kind"]).label, int(e["a"]), int(e["b"])) for e in result.events]


def cut_shot(
    cut: float,
    speed: float,
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    of: dict[str, Any] | None = None,
    **physics: Any,
) -> Scene:
    """Return a collision at an angle `cut` [rad] after half of `TINY`, and a few more steps."""
    of = of or {}
    reach = 2 * of.get("radius", R) * (1 + 1e-12)
    return scene_of(
        ball((-0.5 * speed * TINY, 0), (speed, 0), angular_velocity=spin, **of),
        ball((reach * math.cos(cut), reach * math.sin(cut)), **of),
        **{**SLIDING, "rolling_friction": 0.02, **physics},
        t_max=20 * TINY,
    )


def rolling_velocities(result: Result) -> NDArray[np.float64]:
    """Return the velocities once the balls roll, (n, 2) [m/s]: v - 2/7 u, on any cloth."""
    radii = result.scene.radii
    v, w = result.final_state.velocities[0], result.final_state.angular_velocities[0]
    slip = np.column_stack([v[:, 0] - radii * w[:, 1], v[:, 1] + radii * w[:, 0]])
    velocities: NDArray[np.float64] = v[:, :2] - 2 / 7 * slip
    return velocities


# --- motion -----------------------------------------------------------------------------------


def test_a_stun_shot_slides_then_rolls() -> None:
    scene = scene_of(ball((0, 0), (1, 0), angular_velocity=(0, 0, 0)), **SLIDING)
    dt = 1e-3
    result = run(scene, record="trajectory", dt=dt)
    slide, roll = result.events
    assert log(result) == [("slide-to-roll", 0, -1), ("roll-to-rest", 0, -1)]
    # Events are detected at the end of a step, positions are short by up to v dt / 2, and in the
    # rest of the step that ends the slide, the ball has rolling friction.
    end = 2 / (7 * 0.2 * G)
    assert end <= float(slide["t"]) <= end + dt
    state = result.sample([slide["t"]])
    rolls_with = 5 / 7 - 0.05 * G * (float(slide["t"]) - end)
    assert state.velocities[0, 0] == pytest.approx([rolls_with, 0, 0], abs=1e-9)
    assert R * state.angular_velocities[0, 0, 1] == pytest.approx(rolls_with, abs=1e-6)
    assert state.positions[0, 0, 0] == pytest.approx(12 / (49 * 0.2 * G), abs=dt)
    distance = 12 / (49 * 0.2 * G) + (5 / 7) ** 2 / (2 * 0.05 * G)
    assert result.rest_positions[0] == pytest.approx([distance, 0, R], abs=dt / 2)
    assert float(roll["t"]) == pytest.approx(2 / (7 * 0.2 * G) + 5 / 7 / (0.05 * G), abs=5 * dt)
    assert result.status is Status.REST


# --- impacts with friction --------------------------------------------------------------------


def test_ball_friction_throws_by_its_coefficient() -> None:
    # A stun shot with slipping surfaces has a throw of atan(mu) [Alciatore A.14].
    mu, cut = 0.05, math.radians(30)
    result = run(cut_shot(cut, 1.0, ball_friction=mu), dt=TINY)
    direction = result.final_state.velocities[0, 1]
    thrown = cut - math.atan2(direction[1], direction[0])
    assert thrown == pytest.approx(math.atan(mu), abs=3 * LATE)


def test_a_ball_that_friction_lifts_bounces() -> None:
    # A rolling cue ball in a full hit leaves the cloth with mu (1 + e) v / 2 [B.5].
    scene = cut_shot(0.0, 1.0, (0, 1 / R, 0), ball_friction=0.05, ball_restitution=0.9)
    lifted = run(scene, dt=TINY).final_state.velocities[0, :, 2]
    fallen = G * scene.t_max
    assert lifted == pytest.approx([0.05 * 1.9 / 2, 0.0], abs=2 * fallen)


@pytest.mark.parametrize(
    ("turns", "mu", "change"),
    [(0, 0.05, LATE), (0, 0.2, LATE), (1, 0.05, 5e-3), (-1, 0.05, 5e-3), (1, 0.2, 5e-2)],
)
def test_ball_friction_differs_from_the_law_as_the_capabilities_say(
    turns: int, mu: float, change: float
) -> None:
    """Ghostball's engine, whose law ignores the cloth, compared with Bullet; -1 is backspin.

    The velocities are compared once all balls roll. They are equal if friction has no vertical
    component. The test also fails if the difference is smaller than the capabilities say.
    """
    worst = 0.0
    for cut in np.radians([10, 30, 60]):
        for speed in (0.5, 2.0):
            spin = (0.0, turns * speed / R, 0.0)
            scene = cut_shot(cut, speed, spin, ball_friction=mu)
            difference = rolling_velocities(run(scene, dt=TINY)) - rolling_velocities(
                simulate(scene)
            )
            worst = max(worst, float(np.max(np.hypot(*difference.T))) / speed)
    assert worst <= change
    assert turns == 0 or worst > change / 3


# --- cushions ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("turns", "mu", "change"),
    [(0, 0.2, LATE), (1, 0.2, LATE), (-1, 0.2, 4e-2), (-1, 0.4, 9e-2)],
)
def test_a_cushion_with_friction_differs_from_the_law_as_the_capabilities_say(
    turns: int, mu: float, change: float
) -> None:
    """Ghostball's engine compared with Bullet, as for balls, with side spin."""
    worst = 0.0
    for angle in np.radians([0, 40, 75]):
        for speed in (0.5, 2.5):
            direction = np.array([math.cos(angle), math.sin(angle)])
            start = (TABLE.length - R - speed * direction[0] * TINY / 2, 0.5)
            roll = turns * speed / R * direction
            scene = scene_of(
                ball(start, speed * direction, angular_velocity=(-roll[1], roll[0], 20.0)),
                table=TABLE,
                **SLIDING,
                cushion="frictional",
                cushion_restitution=0.85,
                cushion_friction=mu,
                t_max=20 * TINY,
            )
            result = run(scene, dt=TINY)
            assert log(result) == [("ball-cushion", 0, CUSHIONS.index("right"))]
            difference = rolling_velocities(result) - rolling_velocities(simulate(scene))
            worst = max(worst, float(np.max(np.hypot(*difference.T))) / speed)
    assert worst <= change
    assert turns >= 0 or worst > change / 3
