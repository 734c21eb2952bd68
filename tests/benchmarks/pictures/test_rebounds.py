"""The picture of rebounds shows the measured rebounds and the best fit of each engine."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.pictures.rebounds import best_of_each, draw_rebounds
from benchmarks.rebounds import BestRebounds, ReboundsMeasurement
from ghostball.reports import style
from ghostball.validation.measured.facts import facts_of


def best(engine: str, off: float, *, falls: bool) -> BestRebounds:
    return BestRebounds(
        engine=engine, law="frictional", falls=falls, coefficients={}, errors_off=[[off] * 5] * 2
    )


MEASURED = ReboundsMeasurement(
    best=[
        best("ghostball", 3.0, falls=False),
        best("ghostball", -1.0, falls=True),
        best("pybullet", 2.0, falls=False),
    ]
)


def test_the_best_fit_of_each_engine_is_drawn():
    assert [(one.engine, one.falls) for one in best_of_each(MEASURED)] == [
        ("ghostball", True),
        ("pybullet", False),
    ]


def test_each_curve_has_the_fitted_coefficients():
    with style.drawing():
        (axes,) = draw_rebounds(MEASURED).axes
    rows = facts_of("cushion-carom").rows
    lines = {line.get_label(): line.get_ydata() for line in axes.lines}
    ours = lines["ghostball: restitution falls with speed"]
    assert ours == pytest.approx([row.value - row.error for row in rows])
    other = lines["pybullet: restitution is constant"]
    assert np.all(other > ours)
