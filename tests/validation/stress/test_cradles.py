"""Cradles: right ends are known, and others are seen."""

from __future__ import annotations

from stress_trials import scene_trial

from ghostball.engine import simulate
from ghostball.validation.stress.families.cradles import FAMILY


def test_a_row_that_sends_out_too_many_is_seen():
    trial = scene_trial(FAMILY, "1-into-5-gap-0")
    shot = trial.scene.model_dump(by_alias=True)
    shot["physics"]["ball_restitution"] = 0.99
    faults = trial.judge(simulate(type(trial.scene)(**shot), record="trajectory")).faults
    assert any("velocity" in fault for fault in faults)
