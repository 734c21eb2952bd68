"""MuJoCo against closed forms: exact dampers, first order in the step, soft by default."""

import numpy as np
import pytest
from engine_facts import (
    energy_ratios,
    half_ball,
    head_on,
    needs,
    play,
    rack,
    shares,
)

from ghostball.engine import simulate
from ghostball.validation.scenes.library import find_scene

pytestmark = needs("mujoco")


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


def test_the_naive_configuration_sets_no_restitution() -> None:
    result = play("mujoco:config=naive", half_ball())
    assert np.hypot(*result.final_state.velocities[0, 1, :2]) < 0.6 * 1.5 * np.cos(np.pi / 6.0)
    assert result.collision_counts["ball-ball"] == 1
    assert energy_ratios("mujoco:config=naive", rack())[-1] < 0.05


def test_a_wrong_damper_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    # The planted error: one that only a change of the step would show.
    from ghostball.reference_adapters.mujoco.world import World

    right = World._set_dampers
    monkeypatch.setattr(World, "_set_dampers", lambda world, _: right(world, 1e-3))
    assert shares("mujoco:dt=1e-3", head_on()) == pytest.approx([0.0, 1.0], abs=1e-2)
    assert shares("mujoco:contact_steps=exact", head_on())[1] < 0.6
