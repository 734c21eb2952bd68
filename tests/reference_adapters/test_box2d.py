"""Box2D against closed forms: what its unit of length does, and what bullets and exact steps do."""

import numpy as np
import pytest
from engine_facts import (
    cut_angles,
    energy_ratios,
    half_ball,
    head_on,
    needs,
    play,
    rack,
    shares,
)
from pydantic import ValidationError

from ghostball.engine import simulate
from ghostball.model import UnsupportedSceneError
from ghostball.reference_adapters.box2d.settings import Box2dSettings
from ghostball.validation.scenes.library import find_scene

pytestmark = needs("box2d")


@pytest.mark.parametrize("dt", [1e-2, 1e-3])
def test_bullets_meet_too_deep_whatever_the_step(dt: float) -> None:
    # Two slops, 1e-4 m with 100 units in a metre: the error falls with the unit, not the step.
    off = np.abs(cut_angles("box2d:scale=100", dt)).max()
    assert off == pytest.approx(0.087, abs=0.002)


@pytest.mark.parametrize(("speed", "inelastic"), [(0.9, True), (1.1, False)])
def test_impacts_below_a_unit_per_second_are_inelastic(speed: float, inelastic: bool) -> None:
    wanted = [0.5, 0.5] if inelastic else [0.0, 1.0]
    assert shares("box2d:config=naive", head_on(speed)) == pytest.approx(wanted, abs=1e-5)
    assert shares("box2d", head_on(speed)) == pytest.approx([0.0, 1.0], abs=1e-5)
    assert shares("box2d:scale=100", head_on(speed / 100.0)) == pytest.approx(wanted, abs=1e-4)


def test_a_speed_that_box2d_would_cut_is_refused() -> None:
    # Else 8 m/s would silently become 2 m/s.
    with pytest.raises(UnsupportedSceneError, match="no speeds above 2 m/s with `scale` = 100"):
        play("box2d:scale=100,dt=1e-2", rack())
    assert play("box2d:dt=1e-2", half_ball()).final_state.velocities[0, 1, 0] > 1.1


def test_a_break_keeps_its_energy() -> None:
    assert np.abs(energy_ratios("box2d:bullet=no", rack()) - 1.0).max() < 3e-5
    assert np.abs(energy_ratios("box2d", rack()) - 1.0).max() < 2e-3


def test_a_newcomer_has_metres() -> None:
    assert np.abs(cut_angles("box2d:config=naive", 1.0 / 60.0)).max() > 5.0
    with pytest.raises(ValidationError, match="in metres"):
        Box2dSettings(config="naive", scale=100.0)


def test_a_wrong_unit_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    # The planted error: velocities that are given in metres to a world in other units.
    from ghostball.reference_adapters.box2d.world import World

    right = World.start
    monkeypatch.setattr(World, "start", lambda world, v, w: right(world, 0.99 * v, w))
    scene = find_scene("half-ball-cut")
    error = play("box2d:contact_steps=exact", scene).rest_positions - simulate(scene).rest_positions
    assert np.abs(error).max() > 1e-3
