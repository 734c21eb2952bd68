"""When a run and the truth are compared on the way, and what is found there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import SampledTrajectory
from ghostball.validation.checks.energy_curve import compared_instants
from ghostball.validation.checks.metrics import measure
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


def test_a_ball_beside_its_way_is_seen_though_it_ends_in_its_place() -> None:
    shot = find_scene("stop")
    run, true = simulate(shot, record="trajectory"), truth_of(shot)
    times = np.linspace(0.0, run.rest_time, 101)
    states = run.sample(times)
    positions = states.positions.copy()
    frames = SampledTrajectory(times, positions, states.velocities, states.angular_velocities)
    right = replace(run, trajectory=frames)
    assert measure(right, true).values["path_factor"] <= 4.0
    positions[50, 0, 1] += 1e-9
    # A ball on a table is rounded by some 2^-53 m.
    factor = measure(right, true).values["path_factor"]
    assert 1e-10 * 2.0**53 < factor < 1e-9 * 2.0**53
