"""Fails where the picture shows another distribution than was measured, or marks it wrongly."""

import pytest

from benchmarks.pictures.racks import draw_racks
from benchmarks.racks import RacksMeasurement, RackTimes
from ghostball.reports import style

MEASURED = RacksMeasurement(
    engines=(
        RackTimes(engine="ghostball", seconds=(4e-5, 1e-5, 3e-5, 4e-3)),
        RackTimes(engine="pooltool", seconds=(0.2, 0.1)),
        RackTimes(engine="billiards", detail="no cloth"),
    ),
)


@pytest.fixture
def axes():
    with style.drawing():
        (axes,) = draw_racks(MEASURED).axes
    return axes


def test_each_engine_that_played_is_a_line_of_its_times_in_order(axes):
    lines = {line.get_label(): line for line in axes.lines}
    assert [name for name in lines if "racks" in name] == [
        "ghostball, 4 racks",
        "pooltool, 2 racks",
    ]
    ours = lines["ghostball, 4 racks"]
    assert list(ours.get_xdata()) == [1e-5, 3e-5, 4e-5, 4e-3]
    assert list(ours.get_ydata()) == [0.25, 0.5, 0.75, 1.0]
    assert axes.get_xscale() == "log"


def test_median_mean_99th_percentile_and_slowest_are_marked(axes):
    marks = {
        line.get_marker(): (line.get_xdata()[0], line.get_ydata()[0])
        for line in axes.lines
        if line.get_color() == style.BLACK and len(line.get_xdata()) == 1
    }
    assert marks["o"] == (pytest.approx(3.5e-5), 0.5)
    assert marks["D"] == (pytest.approx(1.02e-3), 0.75)
    assert marks["^"] == marks["s"] == (4e-3, 1.0)
    written = [text.get_text() for text in axes.texts]
    assert written == ["35 µs", "1.02 ms", "4 ms", "4 ms", "150 ms", "150 ms", "200 ms", "200 ms"]
