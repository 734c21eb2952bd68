"""DART against closed forms: its mixing, its thresholds, its friction, its own cloth."""

import pytest
from engine_facts import (
    energy_ratios,
    head_on,
    needs,
    play,
    rack,
    shares,
)
from pydantic import ValidationError

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene, UnsupportedSceneError
from ghostball.reference_adapters.dart.settings import DartSettings
from ghostball.validation.scenes.library import find_scene

pytestmark = needs("dart")

MIXING = 3e-5  # of the speeds


def test_what_overlaps_is_pushed_apart() -> None:
    # By 0.1 unit/s, 1 cm/s here, at most: so nothing is quite inelastic.
    after = 1.5 * shares("dart", head_on(restitution=0.0))
    assert 0.0 < after[1] - after[0] <= 0.01


@pytest.mark.parametrize(("speed", "inelastic"), [(0.09, True), (0.11, False)])
def test_rebounds_below_a_tenth_of_a_unit_are_left_out(speed: float, inelastic: bool) -> None:
    default = shares("dart:config=naive", head_on(speed))
    assert (default[1] < 0.51) == inelastic
    assert shares("dart", head_on(speed))[1] == pytest.approx(1.0, abs=MIXING)


def test_a_newcomer_squares_the_restitution() -> None:
    after = shares("dart:config=naive", head_on(restitution=0.9))
    assert after[1] - after[0] == pytest.approx(0.81, abs=MIXING)


def test_a_break_makes_no_energy() -> None:
    ratios = energy_ratios("dart", rack())
    assert ratios.max() <= 1.0 + 1e-9
    assert 0.9990 < ratios[-1] < 0.9999


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


def test_a_ball_alone_has_no_friction_with_others_whatever_their_law() -> None:
    ball = Ball(id="cue", position=(0.3, 0.3), velocity=(0.5, 0.2))
    scene = Scene(name="alone", balls=[ball], physics=Physics(preset="pool"))
    rest = play("dart", scene).rest_positions
    assert rest == pytest.approx(simulate(scene).rest_positions, abs=1e-9)
