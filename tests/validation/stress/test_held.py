"""Held: a ball that leaves another way than its impacts in the limit is seen."""

from __future__ import annotations

from dataclasses import replace

import pytest
from stress_trials import trials_of

from ghostball.engine import simulate
from ghostball.validation.stress.families.held import FAMILY, AsInTheLimit


@pytest.mark.parametrize(
    "change", [{"vt": 0.3 * (1.0 + 1e-5)}, {"spin": (0.0, 80.0, 40.001)}, {"height": 0.03571}]
)
def test_a_ball_that_leaves_another_way_is_seen(change):
    trial = next(iter(trials_of(FAMILY, "quick").values()))
    assert isinstance(trial.judge, AsInTheLimit)
    result = simulate(trial.scene, record="events")
    assert not trial.judge(result).faults
    assert replace(trial.judge, **change)(result).faults
