"""Breaks where a picture of steps has a line too many, or the wrong step ringed."""

from step_points import points

from benchmarks.pictures.steps import draw_steps
from benchmarks.steps import (
    COLUMNS,
    STEPS,
    StepsMeasurement,
)
from ghostball.reports import style


def test_engines_with_the_same_errors_share_a_line_and_knees_are_ringed():
    ladder = dict(zip(STEPS, (0.1, 5e-2, 2.5e-2, 1.2e-2, 6e-3, 3e-3, 1.5e-3), strict=True))
    same = [one for row in ("pymunk", "pybullet") for one in points("cut", row, ladder)]
    other = points("cut", "mujoco", ladder | {60: None, 120: 1e-3, 240: 1e-3})
    with style.drawing():
        figure = draw_steps(StepsMeasurement(points=(*same, *other), absent={}), COLUMNS["cut"])
    (axes,) = figure.axes
    names = axes.get_legend_handles_labels()[1]
    assert names == ["pymunk, pybullet", "mujoco"]
    rings = [line for line in axes.lines if line.get_fillstyle() == "none"]
    assert [line.get_xdata()[0] for line in rings] == [3840, 3840]
    crosses = [line for line in axes.lines if line.get_marker() == "x"]
    assert [list(line.get_xdata()) for line in crosses] == [[], [60]]
