"""Cradles: right ends are known, and others are seen."""

from __future__ import annotations

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


def test_a_row_that_sends_out_too_many_is_seen():
    trial = scene_trial(FAMILY, "1-into-5-gap-0")
    shot = trial.scene.model_dump(by_alias=True)
    shot["physics"]["ball_restitution"] = 0.99
    faults = trial.judge(simulate(type(trial.scene)(**shot), record="trajectory")).faults
    assert any("velocity" in fault for fault in faults)
