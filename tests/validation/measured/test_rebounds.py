"""The preset `carom` against the measured rebounds, and what one restitution can't do."""

from __future__ import annotations

from functools import partial

import pytest

from ghostball.engine import simulate
from ghostball.model import Physics
from ghostball.validation.measured.rebounds import rebounds

PLAY = partial(simulate, record="trajectory")


@pytest.mark.parametrize("degrees", [5.0, 45.0])
def test_the_preset_carom_keeps_the_measured_ratios(degrees):
    off = [one.errors_off for one in rebounds(PLAY, Physics(preset="carom"), degrees)]
    assert len(off) == 5
    assert max(map(abs, off)) < 2.0


def test_a_restitution_that_is_one_number_rises_where_cushions_fall():
    physics = Physics(preset="carom", cushion_restitution=0.87, cushion_restitution_loss=0.0)
    _, slow, *_, fast = rebounds(PLAY, physics, 5.0)
    assert fast.ratio > slow.ratio
    assert fast.row.value < slow.row.value
