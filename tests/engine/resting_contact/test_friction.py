"""Tests of friction in contact steps, against an independent integration of the motion.

The engine integrates none of these motions with high order: a contact sticks, or there are too
many.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
import pytest
from constrained_motion import Touch, constrained_motion
from islands import pushing_pair
from kernels import interpreted

from ghostball.engine import simulate
from ghostball.engine.core import state as st
from ghostball.engine.resting_contact import step
from ghostball.model import Ball, Physics, Scene, Table

R, NOSE = 0.028575, 0.0357
TURN = 0.05
"""Angle of the lines of centres, alternately to either side."""

Line = tuple[Scene, list[Touch]]
Motion = tuple[float, tuple[float, float, float] | float]


def line_of(
    motions: list[Motion],
    *,
    masses: list[float],
    cloth: list[float],
    between: float,
    spinning: float = 0.0,
    cushion: float = 0.0,
    at: Literal["right", "top"] | None = None,
) -> Scene:
    """Return balls in a zigzag line, the last at a cushion or not; all gaps are constant at first.

    Parameters
    ----------
    motions
        Velocity across the line [m/s] and spin [rad/s] of each ball; a rolling ball has spin
        about the vertical only. At the top cushion, everything is rotated.
    masses
        Masses of the balls [kg].
    cloth, between, cushion
        Coefficients of friction of the cloth under each ball, between balls, and at the cushion.
    spinning
        Deceleration of the spin about the vertical by the cloth [rad/s^2].
    """
    turn = np.array([(0, -1, 0), (1, 0, 0), (0, 0, 1)]) if at == "top" else np.eye(3)
    nose = np.array([0.5, 1.0] if at == "top" else [1.0, 0.5])
    places, velocities = [np.array([-R, 0.0])], [np.array([0.0 if at else 0.8, motions[-1][0]])]
    for k, (speed, _) in enumerate(motions[-2::-1]):
        n = np.array([np.cos(TURN), np.sin(TURN) if k % 2 else -np.sin(TURN)])
        places.append(places[-1] - 2.0 * R * n)
        velocities.append(np.array([(n @ velocities[-1] - n[1] * speed) / n[0], speed]))
    spins = [
        spin if isinstance(spin, tuple) else (-vy / R, vx / R, spin)
        for (_, spin), (vx, vy) in zip(motions, velocities[::-1], strict=True)
    ]
    balls = [
        Ball(
            id=f"b{k}",
            radius=R,
            mass=masses[k],
            position=nose + turn[:2, :2] @ places[-1 - k],
            velocity=turn[:2, :2] @ velocities[-1 - k],
            angular_velocity=turn @ spin,
            sliding_friction=cloth[k],
        )
        for k, spin in enumerate(spins)
    ]
    physics = Physics(
        motion="sliding",
        spinning_friction_rate=spinning,
        ball_friction=between,
        cushion="han2005",
        cushion_friction=cushion,
        cushion_height=NOSE,
    )
    table = Table(length=1.0, width=1.0, cushions=(at,)) if at else None
    return Scene(name="line", table=table, physics=physics, balls=balls, t_max=1e-3)


def sticks_to_cushion(mass: float = 0.2, spinning: float = 0.0) -> Line:
    """The slip between the balls is so small that its direction turns fast."""
    sine, speed, turn = (NOSE - R) / R, 0.1, 20.0
    spin = (turn, 0.0, (sine * turn - speed / R) / np.sqrt(1.0 - sine**2))
    little = (0.02 + speed / np.cos(TURN)) / R - spin[2]
    scene = line_of(
        [(0.0, (0.0, 2.0, little)), (speed, spin)],
        masses=[mass, 0.18],
        cloth=[0.2, 0.2],
        between=0.06,
        spinning=spinning,
        cushion=1.0,
        at="right",
    )
    return scene, [Touch(0, 1), Touch(1, None, sticks=True)]


def sticks_before_a_heavy_ball() -> Line:
    """The forces need so many rounds that they are extrapolated from the last rounds."""
    return sticks_to_cushion(170.0)


def sticks_while_the_cloth_slows_its_spin() -> Line:
    """The contact must return the spin that the cloth takes in the same step, or it slips."""
    return sticks_to_cushion(spinning=10.0)


def stick_to_each_other() -> Line:
    slip = -0.15 / np.cos(TURN)
    scene = line_of(
        [(0.05, (20.0, 60.0, 0.0)), (-0.1, (-20.0, -60.0, slip / R))],
        masses=[0.2, 0.18],
        cloth=[0.3, 0.1],
        between=0.9,
        cushion=0.2,
        at="top",
    )
    return scene, [Touch(0, 1, sticks=True), Touch(1, None)]


def too_many_to_integrate() -> Line:
    n = st.MOST_DIRECT + 2
    ways = 0.03 * np.sin(5.0 * np.arange(n))
    spins = [
        (7.0 * np.sin(k), 60.0 if 2 * k < n else -20.0, 20.0 * np.sin(3.0 * k + 1.0))
        for k in range(n)
    ]
    motions: list[Motion] = list(zip(ways, spins, strict=True))
    motions[n // 2] = (0.02, 5.0)
    masses = [0.17 + 0.03 * np.cos(k) for k in range(n)]
    scene = line_of(motions, masses=masses, cloth=n * [0.2], between=0.06, spinning=10.0)
    return scene, [Touch(k, k + 1) for k in range(n - 1)]


@pytest.mark.parametrize(
    ("make", "rough"),
    [
        pytest.param(sticks_to_cushion, 1.0, id="sticks_to_cushion"),
        # The forces on the light ball are 900 times the friction of the cloth under it.
        pytest.param(sticks_before_a_heavy_ball, 40.0, id="sticks_before_a_heavy_ball"),
        pytest.param(sticks_while_the_cloth_slows_its_spin, 1.0, id="sticks_while_slowed"),
        pytest.param(stick_to_each_other, 1.0, id="stick_to_each_other"),
        pytest.param(too_many_to_integrate, 1.0, id="too_many_to_integrate"),
    ],
)
def test_contacts_that_are_held_in_steps_rub_by_coulombs_law(
    make: Callable[[], Line], rough: float
) -> None:
    check_follows(*make(), rough)


def check_follows(scene: Scene, touches: list[Touch], rough: float = 1.0) -> None:
    """Check that a shot ends like the constrained motion, and uses contact steps."""
    expected = constrained_motion(scene, touches)
    result = simulate(scene, record="events")
    assert result.work["contact_steps"] >= 5
    assert result.work.get("contact_pieces", 0) == 0
    end = result.sample([scene.t_max])
    assert end.positions[0] == pytest.approx(expected[0], rel=0.0, abs=2e-10)
    assert end.velocities[0] == pytest.approx(expected[1], rel=0.0, abs=rough * 1e-7)
    # A step ends the slip with the normal at mid-step, which leaves this error at the end.
    off, radii = rough * 5e-7, scene.radii[:, np.newaxis]
    assert radii * end.angular_velocities[0] == pytest.approx(radii * expected[2], rel=0.0, abs=off)


@interpreted  # compiled kernels can't be replaced
def test_contact_steps_alone_follow_balls_of_different_radii(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Without integration: friction acts at the radius of each ball."""
    monkeypatch.setattr(step, "start_motion", lambda *_: False)
    scene = pushing_pair((0.03, 0.02), (0.2, 0.08)).model_copy(update={"t_max": 1e-3})
    check_follows(scene, [Touch(0, 1)])
