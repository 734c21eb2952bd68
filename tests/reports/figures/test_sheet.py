"""Fails where a sheet misses an engine, hides why one is missing, or writes over itself."""

from itertools import combinations
from xml.etree import ElementTree

import numpy as np
import pytest
from figure_texts import texts_of

from ghostball.reports import style
from ghostball.reports.accuracy import cell_text
from ghostball.reports.figures.sheet import draw_sheet
from ghostball.reports.shots import Run, Shot, load_shot


def axes_titled(figure, words):
    """Return the one panel whose title begins with words."""
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
    assert "not representable: pybullet" in text
    assert len(axes_titled(figure, "Energy").lines) == len(shot.drawn)
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
    assert panel.lines[-1].get_ydata()[0] == 2  # the truth, and no engine's
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


def test_nothing_to_draw_is_none(results):
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
