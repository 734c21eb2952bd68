"""When a run and the truth are compared on the way, and what is found there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.validation.checks.energy_curve import compared_instants
from ghostball.validation.scenes.library import find_scene


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
