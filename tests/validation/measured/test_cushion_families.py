"""Families of cushions: rebounds of two games and banks, of our engine and of others."""

from __future__ import annotations

from functools import partial

import pytest

from ghostball.reference_adapters import make_engine
from ghostball.validation.measured.cushion_families import banks, carom_rebounds, snooker_rebounds


def of(spec, families):
    engine = make_engine(spec)
    return families(engine, partial(engine.simulate, record="trajectory"))


def test_our_engine_comes_near_to_rebounds_of_carom():
    ratio, slope = of("ghostball", carom_rebounds)
    assert len(ratio.figures) == 10
    assert ratio.typical < 1.5
    assert ratio.most < 2.5
    # A law of two numbers doesn't fall quite as what was measured does.
    assert 2.0 < slope.most < 3.0


def test_one_restitution_for_all_speeds_is_far_off_and_rises():
    ratio, slope = of("pybullet", carom_rebounds)
    assert ratio.settings["cushion_restitution_loss"] == 0.0
    assert ratio.most > 10.0
    assert all(one.value < 0.0 < one.played for one in slope.figures)


def test_a_ball_that_does_not_bounce_is_said():
    ratio, slope = of("pybullet:config=naive", carom_rebounds)
    assert "bounced 0 times" in ratio.lacks
    assert slope.lacks == ratio.lacks


@pytest.mark.parametrize(("spec", "typical"), [("ghostball", 0.066), ("pybullet", 0.100)])
def test_rebounds_of_snooker_are_shown_in_metres_a_second(spec, typical):
    family = of(spec, snooker_rebounds)
    assert (family.grades, family.unit, len(family.figures)) == (False, "m/s", 8)
    assert family.typical_difference == pytest.approx(typical, abs=0.002)


@pytest.mark.parametrize("spec", ["ghostball", "pymunk", "pybullet"])
def test_banks_are_those_of_a_table(spec):
    family = of(spec, banks)
    assert family.grades
    assert len(family.figures) == 6
    assert family.most < 1.0


@pytest.mark.parametrize("families", [banks, snooker_rebounds])
def test_an_engine_that_turns_no_balls_says_so(families):
    assert of("paper-discrete", families).lacks == "it has no law of cushions that turns balls"
