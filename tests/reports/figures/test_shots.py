"""Pictures of shots show all balls and engines, without overlapping texts."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from xml.etree import ElementTree

import numpy as np
import pytest
from figure_texts import texts_of

from ghostball.engine import simulate
from ghostball.model import Phase, Scene
from ghostball.reports import style
from ghostball.reports.accuracy import cell_text
from ghostball.reports.figures import draw_sheet, draw_single
from ghostball.reports.figures.heights import flying, part_in_flight
from ghostball.reports.figures.paths import is_collinear
from ghostball.reports.shots import Run, Shot, load_shot
from ghostball.validation.results.store import Results
from ghostball.validation.runs.sampling import motion_of
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.suite import run_suite

# A sheet shows all engines, says why an engine is missing, and has no overlapping texts.


def axes_titled(figure, words):
    """Return the only panel with a title that starts with the given words."""
    (found,) = (axes for axes in figure.axes if axes.get_title("left").startswith(words))
    return found


@pytest.mark.parametrize("scene", ["head-on", "break-7"])
def test_a_sheet_is_written_as_png_and_svg(results, tmp_path, scene):
    with style.drawing():
        png, svg = style.save_figure(draw_sheet(load_shot(results, scene)), tmp_path / "sheet")
    assert png.read_bytes().startswith(b"\x89PNG")
    assert png.stat().st_size > 5_000
    assert ElementTree.parse(svg).getroot().tag.endswith("svg")


@pytest.mark.parametrize("scene", ["head-on", "break-7", "stop"])
def test_a_sheet_shows_every_engine_in_each_panel_and_says_why_one_is_missing(results, scene):
    shot = load_shot(results, scene)
    with style.drawing():
        figure = draw_sheet(shot)
    text = texts_of(figure)
    for run in shot.runs:
        assert style.engine_name(run.label) in text
    for run in shot.drawn:
        assert f"{style.engine_name(run.label)}\n{cell_text(run.case)}\n" in text
    assert "unsupported: pybullet" in text
    assert len(axes_titled(figure, "Total energy").lines) == len(shot.drawn)
    assert len(axes_titled(figure, "Largest distance").lines) == len(shot.drawn) - 1
    truth = shot.truth_counts is not None
    assert len(axes_titled(figure, "Collisions").lines) == len(shot.drawn) + truth


def test_a_sheet_counts_collisions_as_they_come_and_marks_those_that_are_not_true(results):
    shot = load_shot(results, "break-7")
    with style.drawing():
        figure = draw_sheet(shot)
    panel = axes_titled(figure, "Collisions")
    steps = panel.lines[0].get_xydata()
    assert steps.tolist() == [[0.0, 0.0], [1.0, 1.0], [1.2, 2.0], [3.0, 2.0]]
    assert panel.lines[-1].get_ydata()[0] == 2  # the reference, not an engine
    cells = [text.get_text() for text in figure.texts]
    assert cells.count("2 of 2") == len(shot.drawn) - 1
    assert cells.count("7 of 2 ≠") == 1


def test_a_sheet_shows_how_far_each_engine_is_from_ours_as_time_continues(results):
    shot = load_shot(results, "wall-bounce")
    with style.drawing():
        lines = axes_titled(draw_sheet(shot), "Largest distance").lines
    others = [run for run in shot.drawn if run is not shot.ours]
    for run, line in zip(others, lines, strict=True):
        distance = np.linalg.norm(run.motion.positions - shot.ours.motion.positions, axis=2).max(
            axis=1
        )
        assert line.get_ydata() == pytest.approx(np.maximum(distance, 1e-5), abs=1e-12)


def test_a_sheet_without_motion_is_none(results):
    shot = load_shot(results, "stop")
    still = Shot(shot.scene, tuple(Run(run.label, run.case, None) for run in shot.runs))
    assert draw_sheet(still) is None


@pytest.mark.parametrize("name", ["break-7", "head-on", "stop"])
def test_nothing_on_a_sheet_is_cut_off_or_written_over_something_else(results, name):
    with style.drawing():
        figure = draw_sheet(load_shot(results, name))
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


# A picture of one run shows all balls, and explains only what it contains.


@pytest.mark.parametrize("name", ["head-on", "break-7"])
def test_each_ball_of_a_single_run_has_a_colour_of_its_own(results, name):
    shot = load_shot(results, name)
    with style.drawing():
        axes = draw_single(Shot(shot.scene, (shot.ours,))).axes[0]
    count = len(shot.scene.balls)
    paths = shot.ours.motion.positions
    colours = [
        line.get_color()
        for ball in range(count)
        for line in axes.lines
        if np.array_equal(line.get_xydata(), paths[:, ball, :2])
    ]
    assert len(colours) == len(set(colours)) == count


@pytest.mark.parametrize("name", ["head-on", "break-7"])
def test_a_single_run_shows_names_and_metres_and_speaks_of_no_truth(results, name):
    # A picture of one run must not explain rings and errors, which it doesn't have.
    shot = load_shot(results, name)
    alone = Shot(shot.scene, tuple(run for run in shot.runs if run.label == "pymunk"))
    with style.drawing():
        text = texts_of(draw_single(alone))
    for absent in ("truth", "error", "ring", "Bars"):
        assert absent not in text
    for part in ("x [m]", "y [m]", "cue", "Open discs: start", f"{name} on pymunk"):
        assert part in text


def test_a_ball_that_ends_outside_the_picture_is_named(results):
    shot = load_shot(results, "head-on")
    run = next(run for run in shot.runs if run.label == "pymunk")
    ends = run.case.rest_positions.copy()
    ends[1, 0] = 900.0
    lost = Run(run.label, replace(run.case, rest_positions=ends), run.motion)
    with style.drawing():
        assert "Not shown: 1." in texts_of(draw_single(Shot(shot.scene, (lost,))))
        assert "Not shown" not in texts_of(draw_single(Shot(shot.scene, (run,))))


def test_many_balls_with_long_names_are_numbered(results):
    shot = load_shot(results, "break-7")
    many = shot.scene.model_dump(by_alias=True)
    many["balls"] = [
        many["balls"][0] | {"id": f"ball-{i}", "position": (0.1 + 0.1 * i, 0.2)} for i in range(9)
    ]
    scene = Scene.model_validate(many)
    run = next(run for run in shot.runs if run.label == "pymunk")
    case = replace(
        run.case,
        definition=scene.model_dump(mode="json", by_alias=True),
        rest_positions=scene.positions,
        truth_positions=None,
        ball_errors=None,
    )
    run = Run(run.label, case, run.motion)
    with style.drawing():
        text = texts_of(draw_single(Shot(scene, (run,))))
    assert "Numbers: ball order in the scene" in text
    assert "\n9\n" in text
    assert "ball-8" not in text


# Names don't cover paths or each other, and balls on one line don't hide each other.


def shot_of(scene: Scene) -> Shot:
    """Return a shot without a reference, with the run of Ghostball's engine."""
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
    # In a panel of the table, five balls on a line look like one line.
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
    """Return a run in which all balls slide until t [s], and then roll."""
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
    # The parts must not be confused, have a gap, or look alike.
    shot = load_shot(results, scene)
    run = sliding_until(shot.ours, 1.0)
    alone = Shot(shot.scene, (run,))
    with style.drawing():
        figure = draw(alone)
    assert "sliding" in texts_of(figure)
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


# The height of balls is drawn if, and only if, a ball flies.


def test_where_a_ball_flies_its_height_is_drawn(tmp_path):
    names = ("flight-jump", "wall-bounce")
    run_suite(list(map(find_scene, names)), ["ghostball"], tmp_path)
    jump, roll = (load_shot(Results.open(tmp_path), name) for name in names)
    assert flying(jump).tolist() == [True, False, False]
    assert not flying(roll).any()
    landed = simulate(find_scene("flight-jump"), record="trajectory")
    assert part_in_flight(jump) == pytest.approx(0.7, abs=0.05)
    high = landed.sample(np.linspace(part_in_flight(jump), landed.rest_time, 50)).positions
    assert np.ptp(high[:, :, 2]) < 1e-4  # an invisibly low bounce
    for draw in (draw_sheet, draw_single):
        with style.drawing():
            panels = [len(draw(shot).axes) - is_collinear(shot) for shot in (jump, roll)]
        assert panels[0] == panels[1] + 1
