"""Cradles: right ends are known, and others are seen."""

from __future__ import annotations

import pytest
from stress_trials import scene_trial, trials_of

from ghostball.engine import simulate
from ghostball.validation.stress.families.cradles import FAMILY, TELLING


def test_the_full_suite_is_large():
    assert len(trials_of(FAMILY, "full")) > 400


def test_rows_with_losses_are_tried():
    names = trials_of(FAMILY, "full")
    tried = [name for name in names if "-restitution-" in name and "-gap-0-" not in name]
    assert len(tried) >= 12
    assert TELLING < 2.0**-40


@pytest.mark.parametrize(
    "name",
    [
        "2-into-5-gap-0",
        "1-into-5-gap-1e-15",
        "row-of-3-heavier-gap-9e-13-restitution-0.5",
        "row-of-3-gap-0-restitution-0-simultaneous",
        "both-sides-of-5-gap-0",
        "at-cushion-3-gap-1e-15",
    ],
)
def test_our_engine_survives(name):
    trial = scene_trial(FAMILY, name)
    assert trial.judge(simulate(trial.scene, record="trajectory")).faults == ()


def test_a_row_that_sends_out_too_many_is_seen():
    trial = scene_trial(FAMILY, "1-into-5-gap-0")
    shot = trial.scene.model_dump(by_alias=True)
    shot["physics"]["ball_restitution"] = 0.99
    faults = trial.judge(simulate(type(trial.scene)(**shot), record="trajectory")).faults
    assert any("velocity" in fault for fault in faults)
