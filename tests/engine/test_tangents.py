"""Tests of the growth of small changes: of given changes, and of rounding."""

from __future__ import annotations

import numpy as np
from changes import directions_of, recorded

from ghostball.engine.sensitivity import rounding_of, tangent_of
from ghostball.engine.tangents import tangents_of
from ghostball.validation.scenes.library import find_scene


def test_without_directions_the_result_is_the_effect_of_rounding():
    result = recorded(find_scene("throw-slip"))
    shot = (result.scene, result.trajectory, result.events)
    times, given = np.linspace(0.0, result.rest_time, 5), directions_of(result.scene, 2)
    rounding, changed = tangents_of(*shot, None), tangents_of(*shot, given)
    assert np.array_equal(rounding.growth(times), rounding_of(*shot).growth(times))
    assert np.array_equal(changed.sample(times), tangent_of(*shot, given).sample(times))
    at_start = changed.sample([0.0])[0, ..., :4]  # a ball that rests has no spin to change
    np.testing.assert_allclose(at_start, given[..., :4], rtol=1e-14)
