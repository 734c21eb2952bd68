"""Findings about single engines: thresholds, units, breaks, and unsupported scenes.

A test of a defect fails if a later version of the engine has fixed it. Each engine has a planted
error, which its closed forms must detect.
"""

from __future__ import annotations

from pkgutil import resolve_name
from typing import Any

import numpy as np
import pytest
from engine_facts import (
    FREE,
    cut_angles,
    energy_ratios,
    frozen_line,
    half_ball,
    head_on,
    needs,
    play,
    rack,
    shares,
    throw,
    to_the_wall,
)

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene, Table, UnsupportedSceneError
from ghostball.reference_adapters import EngineError, make_engine
from ghostball.validation.scenes.library import find_scene


def on(spec: str, *facts: Any) -> Any:
    """Return a test parameter that is skipped if its engine isn't installed."""
    return pytest.param(spec, *facts, marks=needs(spec.partition(":")[0]))


MIXING = 3e-5
"""Largest relative change of speeds by DART's constraint force mixing."""

box2d, box2d3, dart, mujoco, newton, physx, rapier = (
    needs(name) for name in ("box2d", "box2d3", "dart", "mujoco", "newton", "physx", "rapier")
)


@pytest.mark.parametrize(
    ("spec", "scene", "reason"),
    [
        # Otherwise 8 m/s would silently become 2 m/s.
        on("box2d:scale=100,dt=1e-2", rack(), "no speeds above 2 m/s with `scale` = 100"),
        on("box2d3", throw(), "without friction at contacts"),
        on("box2d3", to_the_wall(0.9), "the larger of the two"),
        on("dart:scale=100", head_on(1.5), "no speeds above 1 m/s with `scale` = 100"),
        on(
            "dart:cloth=own",
            find_scene("draw-shot"),
            "cloth friction implies friction between balls",
        ),
        on("rapier", throw(), "without friction at contacts"),
    ],
)
def test_what_an_engine_cannot_do_is_refused(spec: str, scene: Scene, reason: str) -> None:
    with pytest.raises(UnsupportedSceneError, match=reason):
        play(spec, scene)


@pytest.mark.parametrize(
    ("spec", "reason"),
    [
        on("box2d:config=naive,scale=100", "uses metres"),
        on("dart:cloth=own,contact_steps=exact", "`cloth` = own needs `contact_steps` = fixed"),
    ],
)
def test_settings_that_contradict_each_other_are_refused(spec: str, reason: str) -> None:
    with pytest.raises(EngineError, match=reason):
        make_engine(spec)


@pytest.mark.parametrize(
    ("engine", "threshold", "below", "above", "tuned"),
    [
        on("box2d", 1.0, 1e-5, 1e-5, 1e-5),
        on("box2d3", 1.0, 1e-5, 1e-5, 1e-5),
        on("dart", 0.1, 0.01, MIXING, MIXING),  # below, overlapping balls are pushed apart
        on("physx", 2.0, 1e-5, 1e-5, 1e-6),
    ],
)
def test_a_newcomer_has_inelastic_impacts_below_a_threshold(
    engine: str, threshold: float, below: float, above: float, tuned: float
) -> None:
    """Thresholds of the naive configuration [m/s], with tolerances; tuned engines have none."""
    naive, slower, faster = f"{engine}:config=naive", 0.9 * threshold, 1.1 * threshold
    assert shares(naive, head_on(slower)) == pytest.approx([0.5, 0.5], abs=below)
    assert shares(naive, head_on(faster)) == pytest.approx([0.0, 1.0], abs=above)
    for speed in (slower, faster):
        assert shares(engine, head_on(speed)) == pytest.approx([0.0, 1.0], abs=tuned)


@pytest.mark.parametrize(
    ("spec", "least", "most"),
    [
        on("box2d:bullet=no", 1.0 - 3e-5, 1.0 + 3e-5),
        on("box2d", 1.0 - 2e-3, 1.0 + 2e-3),
        on("dart", 0.9990, 1.0 + 1e-9),
        on("mujoco", 1.0 - 2e-4, 1.0 + 2e-4),  # the impedance
        on("newton", 1.0 - 1e-5, 1.0 + 1e-5),
        on("physx", 1.0 - 1e-5, 1.0 + 1e-5),
    ],
)
def test_a_break_keeps_its_energy(spec: str, least: float, most: float) -> None:
    ratios = energy_ratios(spec, rack())
    assert least < ratios.min() <= ratios.max() < most


@pytest.mark.parametrize(
    ("spec", "least", "most"),
    [
        on("box2d3", 0.4, 0.7),
        on("dart", 0.9990, 0.9999),
        on("mujoco:config=naive", 0.0, 0.05),
        on("newton:solver=xpbd", 5.0, 15.0),
        on("rapier", 1.2, 2.0),
    ],
)
def test_a_break_ends_with_another_energy(spec: str, least: float, most: float) -> None:
    assert least < energy_ratios(spec, rack())[-1] < most


# --- Box2D 2.3 and 3: their units


@box2d
@pytest.mark.parametrize("dt", [1e-2, 1e-3])
def test_bullets_meet_too_deep_whatever_the_step(dt: float) -> None:
    # Two slops, 1e-4 m with 100 units per metre: the error depends on the unit, not on the step.
    off = np.abs(cut_angles("box2d:scale=100", dt)).max()
    assert off == pytest.approx(0.087, abs=0.002)


@box2d
@pytest.mark.parametrize(("speed", "wanted"), [(0.009, [0.5, 0.5]), (0.011, [0.0, 1.0])])
def test_impacts_below_a_unit_per_second_are_inelastic(speed: float, wanted: list[float]) -> None:
    assert shares("box2d:scale=100", head_on(speed)) == pytest.approx(wanted, abs=1e-4)


@box2d
def test_the_scale_of_box2d_follows_the_step_and_a_newcomer_has_metres() -> None:
    assert play("box2d:dt=1e-2", half_ball()).final_state.velocities[0, 1, 0] > 1.1
    assert np.abs(cut_angles("box2d:config=naive", 1.0 / 60.0)).max() > 5.0


@box2d3
def test_slow_impacts_of_box2d_3_are_elastic() -> None:
    assert shares("box2d3", head_on(0.01))[1] == pytest.approx(1.0, abs=1e-4)


@box2d
def test_velocities_in_metres_for_a_world_in_other_units_are_seen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    world: Any = resolve_name("ghostball.reference_adapters.box2d.world:Box2dWorld")
    right = world.start
    monkeypatch.setattr(world, "start", lambda one, v, w: right(one, 0.99 * v, w))
    scene = find_scene("half-ball-cut")
    error = play("box2d:contact_steps=exact", scene).rest_positions - simulate(scene).rest_positions
    assert np.abs(error).max() > 1e-3


@box2d3
def test_a_wrong_unit_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = resolve_name("ghostball.reference_adapters.box2d3.engine:Box2d3Settings")
    monkeypatch.setattr(settings, "units", property(lambda _: 1.0))
    x, y = play("box2d3:contact_steps=exact", half_ball()).final_state.velocities[0, 1, :2]
    assert abs(np.degrees(np.arctan2(-y, x)) - 30.0) > 0.01


# --- DART


@dart
def test_what_overlaps_is_pushed_apart() -> None:
    # By at most 0.1 unit/s, 1 cm/s here, so no impact is completely inelastic.
    after = 1.5 * shares("dart", head_on(restitution=0.0))
    assert 0.0 < after[1] - after[0] <= 0.01


@dart
def test_a_newcomer_squares_the_restitution() -> None:
    after = shares("dart:config=naive", head_on(restitution=0.9))
    assert after[1] - after[0] == pytest.approx(0.81, abs=MIXING)


@dart
def test_a_tenth_of_a_percent_too_little_restitution_is_seen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    world: Any = resolve_name("ghostball.reference_adapters.dart.world:DartWorld")
    right = world._shape
    wrong = staticmethod(lambda *parts: right(*parts[:3], 0.999 * parts[3], parts[4]))
    monkeypatch.setattr(world, "_shape", wrong)
    assert shares("dart", head_on()) != pytest.approx([0.0, 1.0], abs=MIXING)


@dart
def test_a_ball_alone_has_no_friction_with_others_whatever_their_law() -> None:
    ball = Ball(id="cue", position=(0.3, 0.3), velocity=(0.5, 0.2))
    scene = Scene(name="alone", balls=[ball], physics=Physics(preset="pool"))
    rest = play("dart", scene).rest_positions
    assert rest == pytest.approx(simulate(scene).rest_positions, abs=1e-9)


# --- MuJoCo


@mujoco
@pytest.mark.parametrize(
    ("name", "least", "most"), [("throw-stick", 0.0, 1e-4), ("throw-slip", 1e-3, 8e-3)]
)
def test_friction_throws_by_the_convex_cone(name: str, least: float, most: float) -> None:
    # As the capabilities say: sticking is right, slipping friction is slightly too strong.
    scene = find_scene(name)
    ours = simulate(scene, record="trajectory")
    theirs = play("mujoco:contact_steps=exact", scene, record="trajectory")
    assert ours.events is not None
    after = [ours.events["t"][0] + 1e-5]
    error = theirs.sample(after).velocities - ours.sample(after).velocities
    assert least <= np.abs(error).max() < most


@mujoco
def test_the_naive_configuration_sets_no_restitution() -> None:
    result = play("mujoco:config=naive", half_ball())
    assert np.hypot(*result.final_state.velocities[0, 1, :2]) < 0.6 * 1.5 * np.cos(np.pi / 6.0)
    assert result.collision_counts["ball-ball"] == 1


@mujoco
def test_a_damper_of_another_step_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    # The planted error, which only a change of the step reveals.
    world: Any = resolve_name("ghostball.reference_adapters.mujoco.world:MujocoWorld")
    right = world._set_dampers
    monkeypatch.setattr(world, "_set_dampers", lambda one, _: right(one, 1e-3))
    assert shares("mujoco:dt=1e-3", head_on()) == pytest.approx([0.0, 1.0], abs=1e-2)
    assert shares("mujoco:contact_steps=exact", head_on())[1] < 0.6


# --- Newton


@newton
def test_xpbd_takes_momentum_from_a_line_of_balls() -> None:
    assert np.sum(shares("newton:solver=xpbd", frozen_line())) < 0.95
    assert np.sum(shares("newton", frozen_line())) == pytest.approx(1.0, abs=1e-6)


@newton
def test_the_default_gap_of_newton_turns_a_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    world = resolve_name("ghostball.reference_adapters.newton.world")
    monkeypatch.setattr(world, "GAP", 0.2)
    assert np.mean(cut_angles("newton", 1e-3)) < -0.2


@newton
def test_a_replayed_step_is_the_launched_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """The recording contains contact detection, the solver, and the copy of the result."""
    scene = rack(duration=0.2)
    replayed = play("newton", scene)
    world = resolve_name("ghostball.reference_adapters.newton.world:NewtonWorld")
    right = world._record
    monkeypatch.setattr(world, "_record", lambda one, dt: setattr(one, "_replays", False))
    launched = play("newton", scene)
    assert launched.events is not None
    assert len(launched.events) > 15
    assert np.array_equal(replayed.rest_positions, launched.rest_positions)
    monkeypatch.setattr(world, "_record", lambda one, dt: right(one, 2.0 * dt))
    assert not np.array_equal(play("newton", scene).rest_positions, launched.rest_positions)


# --- PhysX


@physx
def test_the_temporal_solver_changes_the_energy() -> None:
    assert np.abs(energy_ratios("physx:solver=tgs", rack()) - 1.0).max() > 5e-3
    assert 0.99 < np.sum(shares("physx:solver=tgs", head_on()) ** 2) < 0.999


@physx
def test_the_iterations_end_the_break_of_a_frozen_rack_without_a_gain_of_energy() -> None:
    scene = find_scene("frozen-break").model_copy(update={"t_max": 0.32})

    def gain(spec: str) -> float:
        frames = play(spec, scene, record="trajectory").trajectory
        assert frames is not None
        energies = 0.7 * np.sum(frames.velocities**2, axis=2) @ scene.masses
        return float(np.max(np.diff(energies))) / energies[0]

    assert gain("physx") <= 1e-6
    assert gain("physx:iterations=10") == pytest.approx(1.2e-4, rel=0.1)


@physx
def test_a_configuration_of_the_whole_process_that_is_not_set_is_seen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    world = resolve_name("ghostball.reference_adapters.physx.world:PhysxWorld")
    play("physx:config=naive", head_on(1.0))
    monkeypatch.setattr(world, "_configure", lambda one, _: setattr(one, "iterations", 10))
    assert shares("physx", head_on(1.0))[1] < 0.51


# --- Rapier


@rapier
def test_the_prediction_of_rapier_turns_a_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    assert np.abs(cut_angles("rapier:config=naive", 1e-4)).max() > 4.0
    world = resolve_name("ghostball.reference_adapters.rapier.world")
    monkeypatch.setattr(world, "PREDICTION", 0.02)
    assert np.abs(cut_angles("rapier", 1e-3)).max() > 1.5


@rapier
def test_each_bounce_off_a_cushion_is_an_event() -> None:
    # A ball and a half-space are always a pair; as a lasting contact, a ball would bounce only
    # once.
    ball = Ball(id="cue", position=(0.5, 0.3), velocity=(2.0, 0.0))
    table = Table(length=1.0, width=1.0)
    scene = Scene(name="to-and-fro", balls=[ball], table=table, physics=FREE, t_max=2.0)
    assert play("rapier", scene).collision_counts["ball-cushion"] == 4
