"""Fails where a figure writes over itself, cuts something off or leaves out what it is about."""

from itertools import combinations

import numpy as np
import pytest

from ghostball.engine import Ball, Scene, simulate
from ghostball.reports import style
from ghostball.reports.figures import (
    draw_collisions,
    draw_energy,
    draw_errors,
    draw_paths,
    draw_verdicts,
)
from ghostball.reports.figures.paths import label_balls, scale_of
from ghostball.reports.physics_figures import draw_deflection
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


@pytest.mark.parametrize("proportion", [0.3, 0.5, 0.58, 0.6, 0.62, 1.0])
def test_no_axis_label_is_written_over_by_the_legend(proportion):
    # Breaks where room that proportions leave is beneath: at 0.58 and 0.6 the label then sinks.
    scene = Scene(
        name="box",
        balls=[
            Ball(id="a", position=(0.0, 0.0)),
            Ball(id="b", position=(1.7, 1.7 * proportion)),
            Ball(id="c", position=(0.5, 0.2), velocity=(0.1, 0.0)),
        ],
    )
    with style.drawing():
        figure, renderer = laid_out(draw_paths(shot_of(scene)))
    top = figure.legends[0].get_window_extent(renderer).y1
    assert figure.axes[0].xaxis.label.get_window_extent(renderer).y0 > top


def test_a_name_keeps_off_the_path():
    scene = find_scene("masse")
    shot = shot_of(scene)
    with style.drawing():
        figure, renderer = laid_out(draw_paths(shot))
    (name,) = (text for text in figure.axes[0].texts if text.get_text() == "blocker")
    path = figure.axes[0].transData.transform(shot.ours.motion.positions[:, 0, :2])
    box = name.get_window_extent(renderer)
    assert not any(box.contains(x, y) for x, y in path)


@pytest.mark.parametrize("name", ["push", "wedged", "mathavan-cut", "three-ball-symmetric"])
def test_names_of_touching_balls_do_not_cover_each_other(name):
    scene = find_scene(name)
    with style.drawing():
        figure, renderer = laid_out(draw_paths(shot_of(scene)))
    names = {ball.id for ball in scene.balls}
    written = [text for text in figure.axes[0].texts if text.get_text() in names]
    boxes = [text.get_window_extent(renderer) for text in written]
    assert len(boxes) == len(names)
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))


def test_a_name_has_a_place_also_where_all_are_taken():
    with style.drawing():
        figure = style.new_figure(4.0, 4.0)
        axes = figure.subplots()
        middle = np.zeros(2)
        crowd = [(f"ball {i}", middle, 0.03) for i in range(6)]
        label_balls(axes, crowd, scale_of((-1.0, 1.0, -1.0, 1.0), 4.0), np.zeros((1, 3)))
    assert [text.get_text() for text in axes.texts] == [name for name, _, _ in crowd]


def test_balls_on_one_line_are_shown_against_time_however_many():
    # In a panel each, five balls on a line are a line.
    shot = shot_of(find_scene("push-line"))
    with style.drawing():
        _, against_time = draw_paths(shot).axes
    x = shot.ours.motion.positions[:, :, 0]
    low, high = against_time.get_ylim()
    assert low < x.min() < x.max() < high
    assert high - low < 1.2 * (x.max() - x.min())


def test_motion_of_a_few_centimetres_fills_its_axis():
    shot = shot_of(find_scene("wedged"))
    with style.drawing():
        low, high = draw_paths(shot).axes[1].get_ylim()
    assert high - low < 0.25


def test_where_balls_end_without_a_table_is_in_the_picture(results_folder):
    shot = load_shot(Results.open(results_folder), "break-7")
    unbounded = Shot(shot.scene.model_copy(update={"table": None}), shot.runs)
    with style.drawing():
        for axes in draw_paths(unbounded).axes[: len(shot.drawn)]:
            (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
            x, y = shot.truth_positions[:, :2].T
            assert np.all((left < x) & (x < right) & (bottom < y) & (y < top))


def test_one_engine_alone_is_no_comparison(results_folder):
    # Breaks where a figure shows one bar, and says of all other engines that they have none.
    shot = load_shot(Results.open(results_folder), "head-on")
    unable = next(run for run in shot.runs if run.case.outcome == "not-representable")
    alone, asked_alone = Shot(shot.scene, (shot.ours, unable)), Shot(shot.scene, (shot.ours,))
    with style.drawing():
        for draw in (draw_collisions, draw_errors):
            assert draw(alone) is None
            assert draw(asked_alone) is not None  # against the closed form


def test_energies_have_a_unit_that_suits_them():
    # Breaks where an axis of the heaviest balls reads "1e7".
    for name, unit, start in (("galperin-0", "J", "0.7 J"), ("galperin-4", "MJ", "70 MJ")):
        shot = shot_of(find_scene(name))
        other = Run("pymunk", None, shot.ours.motion)
        with style.drawing():
            total, difference = draw_energy(Shot(shot.scene, (shot.ours, other))).axes
        assert total.get_ylabel() == f"energy [{unit}]"
        assert difference.get_title(loc="left").endswith(f"E₀ = {start}")
        assert total.lines[0].get_ydata()[0] == pytest.approx(float(start.split()[0]), rel=1e-12)


def test_the_key_of_the_verdicts_is_within_the_picture(results_folder):
    with style.drawing():
        figure, renderer = laid_out(draw_verdicts(Results.open(results_folder)))
    key = figure.legends[0].get_window_extent(renderer)
    assert 0.0 <= key.x0 < key.x1 <= figure.bbox.x1
    assert key.y0 >= 0.0


def test_every_deflection_is_within_the_axes(results_folder):
    with style.drawing():
        above = draw_deflection(Results.open(results_folder)).axes[0]
    low, high = above.get_ylim()
    for line in above.lines:
        y = np.asarray(line.get_ydata(), dtype=float)
        assert np.all((low <= y) & (y <= high))
