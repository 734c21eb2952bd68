"""Tests of the coefficient of friction between balls: constant, or Alciatore's curve."""

from __future__ import annotations

import math
import random
from itertools import pairwise

import mpmath
import pytest
from kernels import entry_to
from shots import ball, scene_of

from ghostball.engine.core.state import Laws
from ghostball.engine.impacts.laws.friction_curve import alciatore_friction, friction_coefficient
from ghostball.engine.running.from_scene import laws_of

alciatore_friction, friction_coefficient = map(entry_to, (alciatore_friction, friction_coefficient))


def laws(friction: float | str) -> Laws:
    return laws_of(scene_of(ball((0.0, 0.0)), motion="sliding", ball_friction=friction))


def exact(slip_speed: float) -> float:
    with mpmath.workdps(40):
        factor = mpmath.exp(-mpmath.mpf("1.088") * slip_speed)
        return float(mpmath.mpf("9.951e-3") + mpmath.mpf("0.108") * factor)


def test_the_curve_is_the_published_one_to_two_ulps():
    """Fails if a term of the series, a constant or the range reduction is wrong."""
    chance = random.Random(1)
    speeds = [0.0, 5e-324, 1e-9, 0.45, 0.46, 0.919, 1.0, 36.7, 36.8, 1e3]
    speeds += [10.0 ** chance.uniform(-6.0, 3.0) for _ in range(2000)]
    speeds += [chance.uniform(0.0, 8.0) for _ in range(2000)]
    for speed in speeds:
        truth = exact(speed)
        assert abs(alciatore_friction(speed) - truth) <= 2.0 * math.ulp(truth), speed


def test_the_curve_starts_and_ends_where_it_should():
    assert alciatore_friction(0.0) == pytest.approx(0.117951, rel=1e-15)
    assert alciatore_friction(1e300) == 9.951e-3
    assert alciatore_friction(math.inf) == 9.951e-3


def test_the_curve_never_rises_beyond_its_rounding():
    """Fails if the pieces of the range reduction don't join."""
    values = [alciatore_friction(k * 1e-3) for k in range(50_000)]
    assert all(later <= earlier * (1.0 + 2.0**-51) for earlier, later in pairwise(values))


def test_a_constant_stays_constant_and_the_name_chooses_the_curve():
    assert friction_coefficient(laws(0.05), 3.0) == 0.05
    assert friction_coefficient(laws("alciatore"), 3.0) == alciatore_friction(3.0)
