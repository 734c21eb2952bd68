"""What `benchmarks.speed` samples of calls; that every sample has its targets is tested there."""

import numpy as np

from benchmarks.calls import prepare_air, prepare_processes
from ghostball.validation.scenes.library import find_scene


def test_slides_are_played_with_air_and_without():
    sample = prepare_air(True)()
    assert sample.keys() == {"slide", "over_no_air"}
    assert all(value > 0.0 for value in sample.values())


def test_two_processes_sweep_all_shots():
    two = prepare_processes(find_scene("half-ball-cut"), np.full(7, 1.0), np.linspace(0.0, 0.1, 7))
    assert two() > 0.0
