"""The gas: how it moves, what its collisions say, and the literature that it is held against."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.stress.gas import (
    begun_at_end,
    collision_rate,
    gas,
    patient,
    stray_momentum,
)


def test_momentum_that_one_collision_loses_is_found():
    result = simulate(gas(4, 0.3, 1.0), record="trajectory")
    stray = stray_momentum(result)
    assert stray is not None
    assert max(map(abs, stray)) < 1e-13
    result.trajectory.segments[3][5:, 3] += 1e-9
    stray = stray_momentum(result)
    assert stray is not None
    assert abs(stray[0]) > 1e-10


def test_a_run_cut_in_two_is_the_run():
    whole = simulate(gas(3, 0.2, 0.5))
    half = simulate(gas(3, 0.2, 0.25))
    rest = simulate(begun_at_end(half, 0.25))
    assert np.allclose(rest.rest_positions, whole.rest_positions, atol=1e-12)


@pytest.mark.slow
@pytest.mark.compiled
def test_the_rate_of_collisions_is_the_theory_s():
    result = simulate(gas(16, 0.3, 2.0))
    expected = 2.0 * collision_rate(256, 0.3)
    assert result.collision_counts["ball-ball"] == pytest.approx(expected, rel=0.15)


def test_patience_is_for_our_engine_only():
    ours, other = make_engine("ghostball"), make_engine("paper-discrete")
    assert patient(ours, 10**9).settings.max_events == 10**9
    assert patient(ours, 10) is ours
    assert patient(other, 10**9) is other
