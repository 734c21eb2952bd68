"""Fails where names cover paths or each other, or balls on one line hide each other."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from figure_texts import texts_of

from ghostball.engine import simulate
from ghostball.model import Phase, Scene
from ghostball.reports import style
from ghostball.reports.figures import draw_sheet, draw_single
from ghostball.reports.shots import Run, Shot, load_shot
from ghostball.validation.runs.sampling import motion_of
from ghostball.validation.scenes.library import find_scene


def shot_of(scene: Scene) -> Shot:
    """Our engine's run of a scene, in a shot that knows no truth."""
    motion = motion_of(simulate(scene, record="trajectory"))
    return Shot(scene, (Run("ghostball", None, motion),))


def laid_out(figure):
    """Lay out a figure, and return it with its renderer."""
    style.lay_out(figure)
    return figure, figure.canvas.get_renderer()


def test_a_name_keeps_off_the_path():
    scene = find_scene("masse")
    shot = shot_of(scene)
    with style.drawing():
        figure, renderer = laid_out(draw_sheet(shot))
    (name,) = (text for text in figure.axes[0].texts if text.get_text() == "blocker")
    path = figure.axes[0].transData.transform(shot.ours.motion.positions[:, 0, :2])
    box = name.get_window_extent(renderer)
    assert not any(box.contains(x, y) for x, y in path)


@pytest.mark.parametrize("name", ["push", "wedged", "mathavan-cut", "three-ball-symmetric"])
def test_names_of_touching_balls_do_not_cover_each_other(name):
    scene = find_scene(name)
    with style.drawing():
        figure, renderer = laid_out(draw_sheet(shot_of(scene)))
    names = {ball.id for ball in scene.balls}
    written = [text for text in figure.axes[0].texts if text.get_text() in names]
    boxes = [text.get_window_extent(renderer) for text in written]
    assert len(boxes) == len(names)
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))


def test_balls_on_one_line_are_shown_against_time_however_many():
    # In a panel each, five balls on a line are a line.
    shot = shot_of(find_scene("push-line"))
    with style.drawing():
        against_time = draw_sheet(shot).axes[1]
    x = shot.ours.motion.positions[:, :, 0]
    low, high = against_time.get_ylim()
    assert low < x.min() < x.max() < high
    assert high - low < 1.2 * (x.max() - x.min())


def test_motion_of_a_few_centimetres_fills_its_axis():
    shot = shot_of(find_scene("wedged"))
    with style.drawing():
        low, high = draw_sheet(shot).axes[1].get_ylim()
    assert high - low < 0.25


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
