"""Rebounds: the preset `carom` against the measured ones, and how a square one is read."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import EventKind, Physics
from ghostball.validation.measured.play import OperatorError
from ghostball.validation.measured.rebounds import rebounds, square_rebound

PLAY = partial(simulate, record="trajectory")


@pytest.mark.parametrize("degrees", [5.0, 45.0])
def test_the_preset_carom_keeps_the_measured_ratios(degrees):
    off = [one.errors_off for one in rebounds(PLAY, Physics(preset="carom"), degrees)]
    assert len(off) == 5
    assert max(map(abs, off)) < 2.0


def test_a_restitution_that_is_one_number_rises_where_cushions_fall():
    physics = Physics(preset="carom", cushion_restitution=0.87, cushion_restitution_loss=0.0)
    _, slow, *_, fast = rebounds(PLAY, physics, 5.0)
    assert fast.ratio > slow.ratio
    assert fast.row.value < slow.row.value


SLIDES = {"motion": "sliding", "rolling_friction": 0.0128, "sliding_friction": 0.21}


@pytest.mark.parametrize("speed", [0.28, 1.0, 3.5])
def test_a_square_rebound_has_the_speeds_right_before_and_after_the_contact(speed):
    # Once it rolls again, a ball that kept its spin would have (5 e - 2) / 7 of its speed, 0.29.
    physics = Physics(**SLIDES, cushion="restitution", cushion_restitution=0.8)
    contact = square_rebound(PLAY, physics, speed)
    assert contact.speed_before == pytest.approx(speed, rel=1e-4)
    assert contact.normal_ratio == pytest.approx(0.8, rel=1e-3)


@pytest.mark.parametrize("law", ["frictional", "han2005", "mathavan2010"])
def test_a_square_rebound_is_the_law_s_own(law):
    seen = []

    def play(scene):
        seen.append(PLAY(scene))
        return seen[-1]

    contact = square_rebound(play, Physics(**SLIDES, cushion=law, cushion_restitution=0.9), 1.5)
    (event,) = (one for one in seen[0].events if one["kind"] == EventKind.BALL_CUSHION)
    instants = np.array([event["t"] - 1e-9, event["t"] + 1e-9])
    before, after = seen[0].sample(instants).velocities[:, 0, 0]
    assert contact.speed_before == pytest.approx(before, rel=1e-3)
    assert contact.speed_after == pytest.approx(-after, rel=2e-3)


def test_a_ball_that_stays_at_the_cushion_is_said():
    physics = Physics(**SLIDES, cushion="restitution", cushion_restitution=0.0)
    with pytest.raises(OperatorError, match="came square to a cushion at 1 m/s left it at"):
        square_rebound(PLAY, physics, 1.0)
