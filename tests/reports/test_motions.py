"""Fails where the distance of two motions is that of their pictures, not of the motions."""

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.reports.shots import distance_from
from ghostball.validation.results.store import Motion
from ghostball.validation.runs.sampling import motion_of
from ghostball.validation.scenes.library import find_scene


def sampled(result, times):
    times = np.asarray(times, dtype=np.float64)
    zeros = np.zeros(len(times))
    return Motion(result.events, times, *result.sample(times), zeros, zeros, zeros)


@pytest.mark.parametrize("name", ["half-ball-cut", "draw-shot", "around-the-table", "break-7"])
def test_a_motion_is_at_no_distance_from_itself_between_its_samples(name):
    result = simulate(find_scene(name), record="trajectory")
    reference = motion_of(result)
    between = np.linspace(0.0, result.rest_time, 3001)
    assert np.max(distance_from(reference, sampled(result, between))) < 1e-12


def test_a_shift_is_its_distance_and_past_the_end_the_balls_stay():
    result = simulate(find_scene("stop"), record="trajectory")
    reference = motion_of(result)
    other = sampled(result, [0.0, 1.0, result.rest_time, result.rest_time + 5.0])
    other.positions[:, 0, 1] += 0.25
    assert distance_from(reference, other) == pytest.approx(0.25)


def test_height_is_left_out():
    result = simulate(find_scene("stop"), record="trajectory")
    other = sampled(result, [0.0, 1.0])
    other.positions[:, 0, 2] += 1.0
    assert np.max(distance_from(motion_of(result), other)) < 1e-12
