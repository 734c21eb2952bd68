"""MuJoCo against closed forms: exact dampers, first order in the step, soft by default."""

import numpy as np
import pytest
from engine_facts import (
    cut_angles,
    energy_ratios,
    frozen_line,
    half_ball,
    head_on,
    needs,
    play,
    rack,
    shares,
    to_the_wall,
)

from ghostball.engine import simulate
from ghostball.model import Status
from ghostball.validation.scenes.library import find_scene

pytestmark = needs("mujoco")


@pytest.mark.parametrize("spec", ["mujoco", "mujoco:contact_steps=exact"])
@pytest.mark.parametrize("restitution", [0.0, 0.5, 0.9, 1.0])
def test_a_single_collision_is_exact_at_any_restitution(spec: str, restitution: float) -> None:
    # Breaks where the damper isn't (1 + e) / dt, or isn't set anew with the step.
    wanted = np.array([1.0 - restitution, 1.0 + restitution]) / 2.0
    assert shares(spec, head_on(restitution=restitution)) == pytest.approx(wanted, abs=2e-9)
    x, y = play(spec, to_the_wall(restitution)).final_state.velocities[0, 0, :2]
    assert (x, y) == pytest.approx((-restitution, 1.0), abs=1e-12)


def test_a_cut_is_late_by_a_part_of_the_step() -> None:
    # Geometry, the same in every engine that sees overlap at the end of a step.
    coarse, fine = cut_angles("mujoco", 1e-3), cut_angles("mujoco", 1e-4)
    assert np.max(coarse) == pytest.approx(0.70, abs=0.05)
    assert np.mean(coarse) / np.mean(fine) == pytest.approx(10.0, rel=0.25)


def test_a_cut_in_exact_steps_is_the_closed_form() -> None:
    assert np.abs(cut_angles("mujoco:contact_steps=exact", 0.02)).max() < 1e-6
    for name in ("half-ball-cut", "restitution-bounce", "draw-shot"):
        scene = find_scene(name)
        result = play("mujoco:contact_steps=exact", scene)
        assert result.status is Status.REST
        truth = simulate(scene).rest_positions
        np.testing.assert_allclose(result.rest_positions, truth, rtol=0.0, atol=1e-6)


def test_a_frozen_line_collides_at_once() -> None:
    # Moreau's law; with a margin of 0 the balls would be hit one after another, (0, 0, 1).
    wanted = [-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0]
    for spec in ("mujoco", "mujoco:contact_steps=exact"):
        assert shares(spec, frozen_line()) == pytest.approx(wanted, abs=2.5e-4)


def test_a_break_keeps_its_energy_but_for_the_impedance() -> None:
    ratios = energy_ratios("mujoco", rack())
    assert np.max(np.abs(ratios - 1.0)) < 2e-4


def test_friction_throws_by_the_convex_cone() -> None:
    # What the capabilities say: sticking is right, slipping is a little too strong.
    for name, least, most in (("throw-stick", 0.0, 1e-4), ("throw-slip", 1e-3, 8e-3)):
        scene = find_scene(name)
        ours = simulate(scene, record="trajectory")
        theirs = play("mujoco:contact_steps=exact", scene, record="trajectory")
        assert ours.events is not None
        after = [ours.events["t"][0] + 1e-5]
        error = theirs.sample(after).velocities - ours.sample(after).velocities
        assert least <= np.abs(error).max() < most


def test_nobody_sets_a_restitution_by_default() -> None:
    result = play("mujoco:config=default", half_ball())
    assert np.hypot(*result.final_state.velocities[0, 1, :2]) < 0.6 * 1.5 * np.cos(np.pi / 6.0)
    assert result.collision_counts["ball-ball"] == 1
    assert energy_ratios("mujoco:config=default", rack())[-1] < 0.05


def test_a_wrong_damper_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    # The planted error: one that only a change of the step would show.
    from ghostball.reference_adapters.mujoco.world import World

    right = World._set_dampers
    monkeypatch.setattr(World, "_set_dampers", lambda world, _: right(world, 1e-3))
    assert shares("mujoco:dt=1e-3", head_on()) == pytest.approx([0.0, 1.0], abs=1e-2)
    assert shares("mujoco:contact_steps=exact", head_on())[1] < 0.6


def test_radii_and_masses_of_any_kind() -> None:
    for name in ("unequal-balls", "corner-exact", "unbounded-cut"):
        scene = find_scene(name)
        error = (
            play("mujoco:contact_steps=exact", scene).rest_positions
            - simulate(scene).rest_positions
        )
        assert np.abs(error).max() < 1e-5, name
