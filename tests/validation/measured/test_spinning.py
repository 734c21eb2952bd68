"""The operator of a golf ball that spins and rolls finds the decelerations of the physics."""

from __future__ import annotations

from functools import partial

import pytest

from ghostball.engine import simulate
from ghostball.model import Physics
from ghostball.reference_adapters import make_engine
from ghostball.validation.measured.simulated_ball import OperatorError
from ghostball.validation.measured.spinning import decelerations
from ghostball.validation.measured.table_agreement import MeasuredEngine, families_of

PLAY = partial(simulate, record="trajectory")
CARPET = {"motion": "sliding", "rolling_friction": 0.05, "spinning_friction_rate": 50.0}


@pytest.mark.parametrize(("spins", "rolls"), [(True, True), (True, False), (False, True)])
def test_both_decelerations_are_those_of_the_physics(spins, rolls):
    found = decelerations(PLAY, Physics(**CARPET), spins=spins, rolls=rolls)
    assert found == pytest.approx((0.05 * 9.81 * rolls, 50.0 * spins), abs=1e-9)


@pytest.mark.parametrize("changes", [{"rolling_friction": 0.2}, {"spinning_friction_rate": 500.0}])
def test_a_motion_that_ends_early_is_said(changes):
    with pytest.raises(OperatorError, match=r"stops rolling or spinning within 0\.45 s"):
        decelerations(PLAY, Physics(**CARPET | changes), spins=True, rolls=True)


@pytest.mark.parametrize("name", ["spin-golf", "rolling-golf"])
def test_one_number_for_a_ball_with_and_without_the_other_motion_is_too_few(name):
    (family,) = families_of(name, MeasuredEngine(make_engine("ghostball"), PLAY))
    assert family.is_within_known is False
    assert not family.grades
    first, second = family.figures
    assert first.difference > 0.0 > second.difference
