"""Figures of laws show the numbers of the formulas, of the runs and of publications."""

from functools import cache

import numpy as np
import pytest
from figure_texts import texts_of

from benchmarks.pictures.physics import (
    DEFLECTION,
    PHYSICS_FIGURES,
    PUBLISHED_DEFLECTIONS,
    THROW_BY_ANGLE,
    THROW_BY_SPIN,
    cuts_of,
    draw_deflection,
    natural_deflection,
    throw_angle,
)
from ghostball.engine import simulate
from ghostball.model import Scene
from ghostball.reports import style
from ghostball.validation.results.store import Motion, Results
from ghostball.validation.runs.sampling import motion_of
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.closed_forms import closed_form


@cache
def run(name: str) -> tuple[Scene, Motion]:
    scene = find_scene(name)
    return scene, motion_of(simulate(scene, record="trajectory"))


@pytest.mark.parametrize(("cut", "deflection"), PUBLISHED_DEFLECTIONS)
def test_the_curve_goes_through_the_published_points(cut, deflection):
    angle = np.degrees(natural_deflection(np.radians(np.array([cut]))))
    assert angle[0] == pytest.approx(deflection, abs=1e-3)


def test_the_largest_deflection_is_the_published_one():
    cuts = np.linspace(0.0, 90.0, 90_001)
    angles = np.degrees(natural_deflection(np.radians(cuts)))
    assert cuts[np.argmax(angles)] == pytest.approx(28.126, abs=1e-3)
    assert angles.max() == pytest.approx(33.749, abs=1e-3)


@pytest.mark.parametrize("name", [THROW_BY_ANGLE, THROW_BY_SPIN])
def test_the_throw_curves_are_those_of_the_closed_forms(name):
    # The closed form of the scene is independent of Alciatore's formula. Only every fourth shot is
    # checked, because a closed form takes long.
    sweep = find_scene(name)
    balls = [ball for k in range(0, len(sweep.balls), 8) for ball in sweep.balls[k : k + 2]]
    scene = sweep.model_copy(update={"balls": tuple(balls)})
    form = closed_form(scene)
    cuts = cuts_of(scene, motion_of(simulate(scene, record="trajectory")))
    assert form is not None
    assert len(cuts) == len(balls) // 2 > 5
    cut, speed, spin = np.array([[c.cut, c.speed, c.spin] for c in cuts]).T
    expected = np.degrees(throw_angle(scene, np.radians(cut), speed, spin))
    ends = np.array([[float(x) for x in v] for v in form.final_velocities[1::2]])
    throw = cut - np.degrees(np.arctan2(ends[:, 1], ends[:, 0]))
    np.testing.assert_allclose(throw, expected, rtol=0, atol=1e-10)


def test_whole_shots_keep_the_30_degree_rule():
    cuts = cuts_of(*run(DEFLECTION))
    cut, deflection = np.array([[c.cut, c.cue] for c in cuts]).T
    assert len(cuts) == 12
    np.testing.assert_allclose(
        deflection, np.degrees(natural_deflection(np.radians(cut))), rtol=0, atol=1e-9
    )
    # Elastic, without friction: the object ball leaves along the line of centres.
    np.testing.assert_allclose([c.throw for c in cuts], 0.0, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", PHYSICS_FIGURES)
def test_a_figure_is_written_with_every_engine_that_ran(results_folder, tmp_path, name):
    results = Results.open(results_folder)
    with style.drawing():
        figure = PHYSICS_FIGURES[name](results)
        assert all(path.stat().st_size for path in style.save_figure(figure, tmp_path / name))
    text = texts_of(figure)
    for part in ("closed form", "ghostball", "pymunk, exact steps", "paper-discrete", "[deg]"):
        assert part in text
    assert "pybullet" not in text  # pybullet ran none of the shots


def test_every_deflection_is_within_the_axes(results_folder):
    with style.drawing():
        above = draw_deflection(Results.open(results_folder)).axes[0]
    low, high = above.get_ylim()
    for line in above.lines:
        y = np.asarray(line.get_ydata(), dtype=float)
        assert np.all((low <= y) & (y <= high))
