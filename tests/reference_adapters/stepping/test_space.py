"""Engines on their own cloth: slides with errors of first order in the step, and flight."""

from __future__ import annotations

import numpy as np
import pytest
from engine_facts import needs, play, slide
from shots import ball, scene_of

from ghostball.engine import simulate
from ghostball.model import EventKind, Scene, Table, UnsupportedSceneError
from ghostball.validation.scenes.library import find_scene

NAMES = [pytest.param(name, marks=needs(name)) for name in ("dart", "mujoco", "physx")]
SLIDING = [
    *NAMES,
    *(pytest.param(name, marks=needs(name)) for name in ("newton", "rapier")),
]
SHORT = {
    "dart": (2.85e-3, 2.87e-4, 2.87e-5),
    "mujoco": (3.66e-3, 4.55e-4, 4.31e-5),
    "newton": (2.85e-3, 2.76e-4),
    "physx": (2.84e-3, 2.7e-4),
    "pybullet": (2.85e-3, 2.86e-4, 2.86e-5),
    "rapier": (2.77e-3, 2.7e-4),
}
"""Missing length of a slide with steps of 10 ms, 1 ms ... [m]."""
SHOTS = {
    "dart": {"sliding-stun": 0.05},
    "mujoco": {"sliding-stun": 0.05, "draw-shot": 0.2},
    "newton": {"sliding-stun": 1e-3, "draw-shot": 0.01, "side-spin": 1e-3},
    "physx": {"sliding-stun": 0.1, "draw-shot": 0.1},
    # Bullet's rolling friction also slows balls that slide.
    "pybullet": {"sliding-stun": 0.2, "draw-shot": 0.2, "side-spin": 1e-3},
    "rapier": {"sliding-stun": 0.02, "draw-shot": 0.02, "side-spin": 1e-3},
}
IN_FLIGHT = {
    "dart:cloth=own": 0.1,
    "mujoco:cloth=own": 0.5,  # MuJoCo's rolling friction acts at bounces, too
    "physx:cloth=own": 0.02,
    "pybullet": 0.01,
}
"""Limits on rest position errors [m]."""


@pytest.mark.parametrize("name", [*SLIDING, pytest.param("pybullet", marks=needs("pybullet"))])
def test_a_cloth_of_its_own_is_of_first_order(name: str) -> None:
    scene = slide()
    end = simulate(scene).final_state
    for dt, short in zip((1e-2, 1e-3, 1e-4), SHORT[name], strict=False):
        state = play(f"{name}:cloth=own,dt={dt}", scene).final_state
        off = end.positions[0, 0, 0] - state.positions[0, 0, 0]
        assert abs(off) == pytest.approx(short, rel=0.05 if name == "physx" else 0.02)
        if name == "dart":
            assert state.velocities[0, 0, 0] == pytest.approx(end.velocities[0, 0, 0], rel=1e-4)
    for shot, limit in SHOTS[name].items():
        rest = play(f"{name}:cloth=own", find_scene(shot)).rest_positions
        assert np.abs(rest - simulate(find_scene(shot)).rest_positions).max() < limit, shot


@pytest.mark.parametrize(
    "spec", [pytest.param(spec, marks=needs(spec.partition(":")[0])) for spec in IN_FLIGHT]
)
def test_a_ball_flies_over_the_cloth_and_rolls_on(spec: str) -> None:
    """Rolling friction must not act at bounces; it would shorten the path by 0.2 m, at any step."""
    scene = find_scene("flight-throw")
    result = play(spec, scene, record="events")
    assert np.abs(result.rest_positions - simulate(scene).rest_positions).max() < IN_FLIGHT[spec]
    assert (result.events["kind"] == EventKind.BALL_CLOTH).sum() >= 4


@needs("mujoco")
def test_spin_about_the_vertical_takes_rolling_friction_from_mujoco() -> None:
    """MuJoCo's torsional and rolling friction share one cone, so a spinning ball rolls farther.

    The largest dissipation within the cone (torque_z / mu_z)^2 + (torque_x / mu_x)^2 <= N^2 gives
    the faster rotation most of the friction: the ball keeps rolling until its spin has ended.
    """
    scene = find_scene("side-spin")
    farther = play("mujoco:cloth=own", scene).rest_positions - simulate(scene).rest_positions
    assert np.abs(farther).max() == pytest.approx(0.365, rel=0.01)


@needs("pybullet")
def test_a_ball_that_slides_also_takes_rolling_friction_from_bullet() -> None:
    """Fails if the adapter slows the ball, or if both do: alone, Bullet stops it 0.41 m early."""
    scene = find_scene("slide-to-rest")
    off = play("pybullet:cloth=own", scene).rest_positions - simulate(scene).rest_positions
    assert off[0] == pytest.approx((-0.413, 0.0, 0.0), rel=0.01, abs=1e-4)


@needs("pybullet")
def test_a_roll_ends_as_the_ball_stops_though_the_ball_spins_on() -> None:
    scene = find_scene("side-spin")
    ends = [
        run.events["t"][run.events["kind"] == EventKind.ROLL_TO_REST]
        for run in (play("pybullet", scene, record="events"), simulate(scene, record="events"))
    ]
    assert ends[0] == pytest.approx(ends[1], abs=2e-3)


@pytest.mark.parametrize("name", NAMES)
def test_flight_over_cushions_or_a_cloth_between_the_steps_is_refused(name: str) -> None:
    leaves = find_scene("flight-leaves")
    scene = Scene(**{**dict(leaves), "balls": leaves.balls[:1]})
    with pytest.raises(UnsupportedSceneError, match="no cushions in scenes with airborne balls"):
        play(f"{name}:cloth=own", scene)
    with pytest.raises(UnsupportedSceneError, match="no airborne balls"):
        play(name, find_scene("flight-throw"))


@pytest.mark.parametrize("name", SLIDING)
def test_cushions_take_a_part_of_the_speed_along_them_on_an_own_cloth_too(name: str) -> None:
    """Fails, by 3 cm, if the factor applies only to engines with the cloth between steps."""
    table = Table(length=1.0, width=1.0)
    scene = scene_of(
        ball((0.9, 0.5), (1.0, 0.5), angular_velocity=(0, 0, 0)),
        **{"table": table, "t_max": 0.3, "motion": "sliding"},
        **{"cushion": "restitution", "cushion_tangential_restitution": 0.5},
    )
    places = play(f"{name}:cloth=own", scene).rest_positions
    assert np.abs(places - simulate(scene).rest_positions).max() < 7e-3


@pytest.mark.parametrize("spec", ["pybullet", pytest.param("dart:cloth=own", marks=needs("dart"))])
def test_the_end_of_a_slide_inside_a_step_costs_no_rolling_friction(spec: str) -> None:
    """The rest error is that of the engine's slide, mu g dt / 2 for 0.29 s, at any phase."""
    ball_ = ball((0.0, 0.0), (2.0, 0.0), angular_velocity=(0.0, 0.0, 0.0))
    scene = scene_of(ball_, motion="sliding", rolling_friction=0.2, sliding_friction=0.2)
    end = simulate(scene).rest_positions[0, 0]
    for part in (0.0, 0.4, 0.8):
        # The slide lasts for 291.25 steps of 1 ms.
        dt = 1e-3 * (1.0 - part / 291.0)
        off = end - play(f"{spec}:dt={dt}".replace("own:", "own,"), scene).rest_positions[0, 0]
        assert off == pytest.approx(0.286e-3, rel=0.03)
