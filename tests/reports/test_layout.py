"""Fails where a figure writes over itself, cuts something off or leaves out what it is about."""

from itertools import combinations

import numpy as np
import pytest

from benchmarks.pictures.physics import draw_deflection
from ghostball.engine import simulate
from ghostball.model import Scene
from ghostball.reports import style
from ghostball.reports.figures import (
    draw_sheet,
)
from ghostball.reports.shots import Run, Shot, load_shot
from ghostball.validation.results.store import Results
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


@pytest.mark.parametrize("name", ["break-7", "head-on", "stop"])
def test_nothing_on_a_sheet_is_cut_off_or_written_over_something_else(results_folder, name):
    with style.drawing():
        figure = draw_sheet(load_shot(Results.open(results_folder), name))
        figure.draw_without_rendering()
        renderer = figure.canvas.get_renderer()
    texts = [*figure.texts, *(axes._left_title for axes in figure.axes)]
    boxes = [text.get_window_extent(renderer) for text in texts]
    boxes += [
        box
        for axes in figure.axes
        for axis in (axes.xaxis, axes.yaxis)
        if axes.axison and (box := axis.get_tightbbox(renderer)) is not None
    ]
    for box in boxes:
        assert 0.0 <= box.x0 < box.x1 <= figure.bbox.width
        assert 0.0 <= box.y0 < box.y1 <= figure.bbox.height
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))


def test_every_deflection_is_within_the_axes(results_folder):
    with style.drawing():
        above = draw_deflection(Results.open(results_folder)).axes[0]
    low, high = above.get_ylim()
    for line in above.lines:
        y = np.asarray(line.get_ydata(), dtype=float)
        assert np.all((low <= y) & (y <= high))
