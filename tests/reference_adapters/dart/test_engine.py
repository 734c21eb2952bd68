"""DART against closed forms: its mixing, its thresholds, its friction, its own cloth."""

import numpy as np
import pytest
from engine_facts import (
    cut_angles,
    energy_ratios,
    head_on,
    needs,
    play,
    rack,
    shares,
    slide,
    to_the_wall,
)
from pydantic import ValidationError

from ghostball.engine import simulate
from ghostball.model import Ball, EventKind, Physics, Scene, UnsupportedSceneError
from ghostball.reference_adapters.dart.engine import DartSettings
from ghostball.validation.scenes.library import find_scene

pytestmark = needs("dart")

MIXING = 3e-5  # of the speeds


@pytest.mark.parametrize("spec", ["dart", "dart:contact_steps=exact"])
@pytest.mark.parametrize("restitution", [0.5, 0.9, 1.0])
def test_a_single_collision_is_right_but_for_the_mixing(spec: str, restitution: float) -> None:
    # Breaks where the two factors don't multiply to the scene's restitution.
    wanted = np.array([1.0 - restitution, 1.0 + restitution]) / 2.0
    assert shares(spec, head_on(restitution=restitution)) == pytest.approx(wanted, abs=MIXING)
    x, y = play(spec, to_the_wall(restitution)).final_state.velocities[0, 0, :2]
    assert (x, y) == pytest.approx((-restitution, 1.0), abs=MIXING)


def test_what_overlaps_is_pushed_apart() -> None:
    # By 0.1 unit/s, 1 cm/s here, at most: so nothing is quite inelastic.
    after = 1.5 * shares("dart", head_on(restitution=0.0))
    assert 0.0 < after[1] - after[0] <= 0.01


def test_a_cut_is_late_by_a_part_of_the_step_and_in_exact_steps_it_is_not() -> None:
    assert np.abs(cut_angles("dart", 1e-3)).max() == pytest.approx(0.70, abs=0.05)
    assert np.abs(cut_angles("dart:contact_steps=exact", 0.02)).max() < 1e-6


def test_shots_in_exact_steps_are_right_but_for_the_mixing() -> None:
    for name in ("half-ball-cut", "throw-slip", "throw-stick", "draw-shot", "cradle"):
        scene = find_scene(name)
        error = (
            play("dart:contact_steps=exact", scene).rest_positions - simulate(scene).rest_positions
        )
        assert np.abs(error).max() < 2e-4, name


@pytest.mark.parametrize(("speed", "inelastic"), [(0.09, True), (0.11, False)])
def test_rebounds_below_a_tenth_of_a_unit_are_left_out(speed: float, inelastic: bool) -> None:
    default = shares("dart:config=default", head_on(speed))
    assert (default[1] < 0.51) == inelastic
    assert shares("dart", head_on(speed))[1] == pytest.approx(1.0, abs=MIXING)


def test_a_newcomer_squares_the_restitution() -> None:
    after = shares("dart:config=default", head_on(restitution=0.9))
    assert after[1] - after[0] == pytest.approx(0.81, abs=MIXING)


def test_a_break_makes_no_energy() -> None:
    ratios = energy_ratios("dart", rack())
    assert ratios.max() <= 1.0 + 1e-9
    assert 0.9990 < ratios[-1] < 0.9999


def test_its_own_cloth_is_of_first_order() -> None:
    scene = slide()
    end = simulate(scene).final_state
    errors = []
    for dt in (1e-2, 1e-3, 1e-4):
        state = play(f"dart:cloth=own,dt={dt}", scene).final_state
        errors.append(abs(state.positions[0, 0, 0] - end.positions[0, 0, 0]))
        assert state.velocities[0, 0, 0] == pytest.approx(end.velocities[0, 0, 0], rel=1e-4)
    assert errors == pytest.approx([2.85e-3, 2.87e-4, 2.87e-5], rel=0.02)
    scene = find_scene("sliding-stun")
    rest = play("dart:cloth=own", scene).rest_positions
    assert np.abs(rest - simulate(scene).rest_positions).max() < 0.05


def test_what_it_cannot_do_is_refused() -> None:
    with pytest.raises(UnsupportedSceneError, match="no speeds above 1 m/s with `scale` = 100"):
        play("dart:scale=100", head_on(1.5))
    with pytest.raises(UnsupportedSceneError, match="balls that rub on the cloth rub on each"):
        play("dart:cloth=own", find_scene("draw-shot"))
    with pytest.raises(ValidationError, match="`cloth` = own needs `contact_steps` = fixed"):
        DartSettings(cloth="own", contact_steps="exact")


def test_a_wrong_factor_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    # The planted error: 0.1 % too little of what a collision gives back.
    from ghostball.reference_adapters.dart.world import World

    right = World._shape
    wrong = staticmethod(lambda *parts: right(*parts[:3], 0.999 * parts[3], parts[4]))
    monkeypatch.setattr(World, "_shape", wrong)
    assert shares("dart", head_on()) != pytest.approx([0.0, 1.0], abs=MIXING)


def test_a_ball_flies_over_its_own_cloth() -> None:
    scene = find_scene("flight-throw")
    result = play("dart:cloth=own", scene, record="events")
    off = result.rest_positions - simulate(scene).rest_positions
    assert np.abs(off).max() < 0.1
    assert (result.events["kind"] == EventKind.BALL_CLOTH).sum() >= 4


def test_flight_over_cushions_or_a_cloth_between_the_steps_is_refused() -> None:
    leaves = find_scene("flight-leaves")
    scene = Scene(**{**dict(leaves), "balls": leaves.balls[:1]})
    with pytest.raises(UnsupportedSceneError, match="no cushions where balls may fly"):
        play("dart:cloth=own", scene)
    with pytest.raises(UnsupportedSceneError, match="no balls that leave the cloth"):
        play("dart", find_scene("flight-throw"))


def test_a_ball_alone_has_no_friction_with_others_whatever_their_law() -> None:
    ball = Ball(id="cue", position=(0.3, 0.3), velocity=(0.5, 0.2))
    scene = Scene(name="alone", balls=[ball], physics=Physics(preset="pool"))
    rest = play("dart", scene).rest_positions
    assert rest == pytest.approx(simulate(scene).rest_positions, abs=1e-9)
