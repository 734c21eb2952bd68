"""Fails where a path doesn't show where its ball slides and where it rolls."""

from dataclasses import replace

import numpy as np
import pytest
from figure_texts import texts_of

from ghostball.model import Phase
from ghostball.reports import style
from ghostball.reports.figures import draw_sheet, draw_single
from ghostball.reports.shots import Run, Shot, load_shot


def sliding_until(run: Run, t: float) -> Run:
    """A run whose balls all slide until t [s], and roll after."""
    phases = np.full(run.motion.positions.shape[:2], Phase.ROLLING, dtype=np.int8)
    phases[run.motion.times < t] = Phase.SLIDING
    return Run(run.label, run.case, replace(run.motion, phases=phases))


@pytest.mark.parametrize(
    ("scene", "draw"),
    [
        ("wall-bounce", draw_sheet),
        ("head-on", draw_sheet),
        ("wall-bounce", draw_single),
        ("head-on", draw_single),
        ("break-7", draw_single),
    ],
)
def test_where_a_ball_slides_its_path_is_wider_and_darker_and_the_figure_says_so(
    results, scene, draw
):
    # Breaks where the parts are mixed up, leave a gap, or are drawn alike.
    shot = load_shot(results, scene)
    run = sliding_until(shot.ours, 1.0)
    alone = Shot(shot.scene, (run,))
    with style.drawing():
        figure = draw(alone)
    assert "where a ball slides" in texts_of(figure)
    motion = run.motion
    for ball in range(motion.positions.shape[1]):
        path = motion.positions[:, ball, :2]
        turn = int(np.flatnonzero(motion.times >= 1.0)[0])
        drawn = [(line, line.get_xydata()) for line in figure.axes[0].lines]
        (slides,) = (line for line, xy in drawn if np.array_equal(xy, path[: turn + 1]))
        (rolls,) = (line for line, xy in drawn if np.array_equal(xy, path[turn:]))
        assert slides.get_linewidth() > rolls.get_linewidth()
        assert slides.get_alpha() > rolls.get_alpha()
        assert slides.get_color() == rolls.get_color()
