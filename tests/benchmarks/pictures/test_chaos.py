"""Neighbouring shots: they part as the tangent map says, while they are near."""

import numpy as np

from benchmarks.pictures.chaos import SIZES, neighbours_of
from ghostball.validation.scenes.library import find_scene


def test_neighbouring_shots_part_as_the_tangent_map_says_while_they_are_near():
    known = neighbours_of(find_scene("chaos-a"))
    noise = 32.0 * 2.0**-53 * known.growth
    for distance, predicted in zip(known.distance, known.predicted, strict=True):
        clear = (predicted < 1e-4) & (predicted > 30.0 * noise) & (predicted > 0.0)
        ratio = distance[clear] / predicted[clear]
        assert np.all((ratio > 0.8) & (ratio < 1.25))
        assert distance[0] == 0.0
    # The paper's 1e-4 changes everything.
    assert SIZES[0] == 1e-4
    assert known.distance[0, -1] > 1.0
