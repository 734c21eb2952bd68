"""Tests of the integration over an impact: it ends, and does nothing for a vanishing approach."""

import math
import random

import pytest
from cushion_impacts import R, cushion_of, energy, impact_of, outcome
from kernels import entry_to

from ghostball.engine.impacts.laws.cushion_mathavan2010 import mathavan2010

mathavan2010 = entry_to(mathavan2010)


@pytest.mark.compiled
def test_the_integration_ends_for_any_spin():
    chance = random.Random(5)
    for _ in range(500):
        vn, vt, wn, wt, wz = (10.0 ** chance.uniform(-5, 2) for _ in range(5))
        impact = impact_of(
            vn,
            chance.choice((-1, 1)) * vt,
            chance.choice((-1, 1)) * wn / R,
            chance.choice((-1, 1)) * wt / R,
            chance.choice((-1, 1)) * wz / R,
            cloth=chance.uniform(0.0, 2.0),
        )
        cushion = cushion_of(
            chance.random(), chance.uniform(0.0, 2.0), chance.uniform(0.02, 1.98) * R
        )
        after = mathavan2010(impact, cushion)
        assert all(map(math.isfinite, after))
        assert after.vn <= 0.0
        assert energy(after) <= energy(impact) * (1.0 + 1e-12)


@pytest.mark.parametrize("vn", [0.0, 5e-324, 1e-310, 1e-200, 1e-139, 1e-30])
@pytest.mark.parametrize("spins", [(0.0, 0.0, 0.0, 0.0), (1.0, -1 / R, 0.0, 2.0), (1.0, 0, 3, 2)])
def test_a_vanishing_approach_has_no_effect(vn, spins):
    impact = impact_of(vn, *map(float, spins))
    after = mathavan2010(impact, cushion_of())
    assert -vn <= after.vn <= 0.0
    assert outcome(after) == pytest.approx(outcome(impact), abs=10 * vn)
