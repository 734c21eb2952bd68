"""Neighbouring shots: they part as the tangent map says, while they are near."""

import numpy as np

from benchmarks.pictures.neighbours import neighbours_of
from ghostball.validation.scenes.library import find_scene


def test_neighbouring_shots_part_as_the_tangent_map_says_while_they_are_near():
    known = neighbours_of(find_scene("chaos-a"))
    for separation in known.separations:
        noise = 32.0 * 2.0**-53 * known.growth
        clear = (
            (separation.predicted < 1e-4)
            & (separation.predicted > 30.0 * noise)
            & (separation.predicted > 0.0)
        )
        ratio = separation.apart[clear] / separation.predicted[clear]
        assert np.all((ratio > 0.8) & (ratio < 1.25))
        assert separation.apart[0] == 0.0
    # The paper's 1e-4 changes everything.
    assert known.separations[0].size == 1e-4
    assert known.separations[0].apart[-1] > 1.0
