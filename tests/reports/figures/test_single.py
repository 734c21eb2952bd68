"""Fails where a picture of one run hides a ball, or explains what it doesn't have."""

from dataclasses import replace

import numpy as np
import pytest
from figure_texts import texts_of

from ghostball.model import Scene
from ghostball.reports import style
from ghostball.reports.figures.single import draw_single
from ghostball.reports.shots import Run, Shot, load_shot


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
    # Breaks where a picture of one run explains rings and errors that it doesn't have.
    shot = load_shot(results, name)
    alone = Shot(shot.scene, tuple(run for run in shot.runs if run.label == "pymunk"))
    with style.drawing():
        text = texts_of(draw_single(alone))
    for absent in ("truth", "error", "ring", "Bars"):
        assert absent not in text
    for part in ("x [m]", "y [m]", "cue", "Empty discs: start", f"{name} on pymunk"):
        assert part in text


def test_a_ball_that_ends_outside_the_picture_is_named(results):
    shot = load_shot(results, "head-on")
    run = next(run for run in shot.runs if run.label == "pymunk")
    ends = run.case.rest_positions.copy()
    ends[1, 0] = 900.0
    lost = Run(run.label, replace(run.case, rest_positions=ends), run.motion)
    with style.drawing():
        assert "Outside: 1." in texts_of(draw_single(Shot(shot.scene, (lost,))))
        assert "Outside" not in texts_of(draw_single(Shot(shot.scene, (run,))))


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
    assert "Numbers: order of the balls in the scene" in text
    assert "\n9\n" in text
    assert "ball-8" not in text
