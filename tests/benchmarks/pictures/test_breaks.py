"""The picture of breaks shows the measured shares, three ways of impacts, and other engines."""

from __future__ import annotations

import pytest

from benchmarks.made_balls import CountedBreaks, MadeBallsMeasurement
from benchmarks.pictures.breaks import WAYS, draw_breaks
from ghostball.validation.measured.breaks import inputs, setups
from ghostball.validation.measured.facts import facts_of

NAME = setups()[0].name


def cell(engine: str, impacts: str = "", made: int = 60, **changed: float) -> CountedBreaks:
    return CountedBreaks(
        engine=engine,
        setup=NAME,
        impacts=impacts,
        changed=changed,
        breaks=100,
        made=made,
        scratch=10,
    )


VARIED = [
    cell("ghostball", "compliant", 80 + sign * 15 * (k == 0), **{one.name: value})
    for k, one in enumerate(inputs())
    for sign, value in ((-1, one.value - one.error), (1, one.value + one.error))
]
CELLS = [*(cell("ghostball", way, 60 + 10 * k) for k, way in enumerate(WAYS)), *VARIED]
MEASURED = MadeBallsMeasurement(
    rounds=1, cells=(*CELLS, cell("pymunk", made=50), CountedBreaks(engine="box2d", setup=NAME))
)


def test_each_way_and_engine_has_a_row_beneath_the_measurement():
    left, right = draw_breaks(MEASURED).axes
    names = [label.get_text() for label in left.get_yticklabels()]
    assert names == [
        "measured: 118 breaks",
        *(f"ghostball: {one}" for one in WAYS.values()),
        "pymunk: 100 breaks",
    ]
    marks = [bars[0] for bars in left.containers if bars[0].get_marker() != "None"]
    points = {line.get_ydata()[0]: line.get_xdata()[0] for line in marks}
    row = facts_of("breaks-made").rows[0]
    assert points[0] == pytest.approx(100.0 * row.value)
    assert [points[k] for k in range(1, 5)] == [60.0, 70.0, 80.0, 50.0]
    assert len(left.containers) == len(right.containers) + 1  # inputs here change what is made only
