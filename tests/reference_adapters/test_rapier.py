"""Rapier against closed forms: collisions to single precision, and what it makes of a break."""

import numpy as np
import pytest
from engine_facts import (
    FREE,
    cut_angles,
    energy_ratios,
    needs,
    play,
    rack,
    throw,
)

from ghostball.model import Ball, Scene, Table, UnsupportedSceneError

pytestmark = needs("rapier")


def test_its_prediction_turns_a_cut_and_its_breaks_gain_energy() -> None:
    # The findings: these fail where a later Rapier has mended them.
    assert np.abs(cut_angles("rapier:config=naive", 1e-4)).max() > 4.0
    assert energy_ratios("rapier", rack())[-1] > 1.2


def test_what_is_not_driven_is_refused() -> None:
    with pytest.raises(UnsupportedSceneError, match="without friction at contacts"):
        play("rapier", throw())


def test_a_wrong_prediction_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    from ghostball.reference_adapters.rapier import world

    monkeypatch.setattr(world, "PREDICTION", 0.02)
    assert np.abs(cut_angles("rapier", 1e-3)).max() > 1.5


def test_each_bounce_off_a_cushion_is_an_event() -> None:
    # A ball and a half-space are a pair for good: taken for a lasting contact, it bounces once.
    ball = Ball(id="cue", position=(0.5, 0.3), velocity=(2.0, 0.0))
    table = Table(length=1.0, width=1.0)
    scene = Scene(name="to-and-fro", balls=[ball], table=table, physics=FREE, t_max=2.0)
    assert play("rapier", scene).collision_counts["ball-cushion"] == 4
