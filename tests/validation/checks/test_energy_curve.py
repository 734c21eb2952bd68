"""When a run and the truth are compared on the way, and what is found there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import Energy, Result
from ghostball.model.arrays import FloatArray
from ghostball.validation.checks.energy_curve import compared_instants
from ghostball.validation.checks.metrics import measure
from ghostball.validation.runs.sampling import energy_at
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.scene_truth import truth_of


@pytest.mark.parametrize("late", [0.05, -0.05])
def test_nothing_is_compared_between_the_two_instants_of_an_event(late: float) -> None:
    true = simulate(find_scene("half-ball-cut"), record="trajectory")
    assert true.events is not None
    events = true.events.copy()
    events["t"][0] += late
    between = sorted((float(true.events["t"][0]), float(events["t"][0])))
    times = compared_instants(replace(true, events=events), true)
    assert not np.any((times > between[0]) & (times < between[1]))
    assert (times.min(), times.max()) == (0.0, true.rest_time)
    assert compared_instants(true, true, until=0.3).max() <= 0.3


def test_a_run_is_compared_with_the_truth_once_for_all_metrics(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene, calls = find_scene("half-ball-cut"), list[int]()
    run, truth = simulate(scene, record="trajectory"), truth_of(scene)

    def counted(result: Result, times: FloatArray) -> Energy:
        calls.append(len(times))
        return energy_at(result, times)

    monkeypatch.setattr("ghostball.validation.checks.energy_curve.energy_at", counted)
    found = measure(run, truth).values
    assert found["energy_difference_max"] is not None
    assert found["energy_difference_factor"] is not None
    assert len(calls) == 1
