"""Gases have the packing that is asked for."""

import math

import pytest

from ghostball.model import POOL_BALL_RADIUS as R
from ghostball.validation.scenes.gases import FRICTIONLESS, packed_gas


@pytest.mark.parametrize(("count", "packing"), [(1, 0.75), (7, 0.1), (16, 0.6)])
def test_a_packed_gas_has_its_packing(count, packing):
    scene = packed_gas(count, packing, FRICTIONLESS, t_max=1.0)
    columns = math.ceil(math.sqrt(count))
    places = columns * math.ceil(count / columns)
    covered = places * math.pi * R**2 / (scene.table.length * scene.table.width)
    assert covered == pytest.approx(packing)
    assert len(scene.balls) == count
