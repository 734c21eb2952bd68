"""Fails where a figure misses an engine, hides why one is missing, or differs between two runs."""

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from reports import style
from reports.figures import (
    SCENE_FIGURES,
    draw_accuracy,
    draw_collisions,
    draw_energy,
    draw_errors,
    draw_paths,
    draw_verdicts,
)
from reports.figures._table import view_of
from reports.paper_figures import PAPER_FIGURES, overlaps
from reports.shots import Run, Shot, load_shot
from validation.store import ResultsFolder
from validation.verdict import Verdict, is_own_measure, verdict_of


@pytest.fixture(scope="session")
def results(results_folder: Path) -> ResultsFolder:
    return ResultsFolder.load(results_folder)


def texts_of(figure) -> str:
    from matplotlib.text import Text

    return "\n".join(text.get_text() for text in figure.findobj(Text))


@pytest.mark.parametrize("kind", SCENE_FIGURES)
@pytest.mark.parametrize("scene", ["head-on", "break-7"])
def test_a_figure_is_written_as_png_and_svg(results, tmp_path, kind, scene):
    with style.drawing():
        figure = SCENE_FIGURES[kind](load_shot(results, scene))
        png, svg = style.save_figure(figure, tmp_path / "figure")
    assert png.read_bytes().startswith(b"\x89PNG")
    assert png.stat().st_size > 5_000
    assert ElementTree.parse(svg).getroot().tag.endswith("svg")


def test_the_same_figure_gives_the_same_bytes(results, tmp_path):
    for name in ("first", "second"):
        with style.drawing():
            style.save_figure(draw_errors(load_shot(results, "head-on")), tmp_path / name)
    for ending in style.FORMATS:
        first, second = (tmp_path / f"{name}.{ending}" for name in ("first", "second"))
        assert first.read_bytes() == second.read_bytes()
    assert "dc:date" not in first.read_text()


def test_the_paths_name_every_engine_and_why_one_is_missing(results):
    with style.drawing():
        text = texts_of(draw_paths(load_shot(results, "head-on")))
    assert "pymunk, default: 90 mm" in text
    assert "pybullet: not representable" in text
    assert "newcomer, dt=1e-3: did not finish" in text
    assert "x [m]" in text
    assert "time [s]" in text


def test_a_path_is_drawn_where_the_engine_had_it(results):
    shot = load_shot(results, "wall-bounce")
    with style.drawing():
        axes = draw_paths(shot).axes[0]
    drawn = [line.get_xydata() for line in axes.lines]
    for run in shot.drawn:
        path = run.motion.positions[:, 0, :2]
        assert any(np.array_equal(path, xy) for xy in drawn), run.label


def test_many_balls_get_a_panel_for_each_engine_that_has_a_motion(results):
    shot = load_shot(results, "break-7")
    with style.drawing():
        figure = draw_paths(shot)
    shown = [axes.get_title() or axes.get_title("left") for axes in figure.axes if axes.axison]
    assert shown == [style.engine_name(run.label) for run in shot.drawn]


def test_a_lost_ball_does_not_shrink_the_table(results):
    scene = load_shot(results, "break-7").scene
    lost = np.array([[1e3, -1e9, 0.0], [np.nan, np.inf, 0.0]])
    left, right, bottom, top = view_of(scene, lost)
    assert right - left < 2 * scene.table.length
    assert top - bottom < 2 * scene.table.width


def test_the_counts_are_written_beside_the_bars(results):
    with style.drawing():
        figure = draw_collisions(load_shot(results, "break-7"))
    assert [axes.get_xlabel() for axes in figure.axes] == ["ball-ball collisions [1]"]
    assert "not representable" in texts_of(figure)
    assert "\n2\n" in texts_of(figure)


def test_the_dashed_line_is_the_truth_and_not_our_engine(results):
    shot = load_shot(results, "head-on")
    runs = tuple(
        Run(r.label, replace(r.case, truth_counts={"ball-ball": 5, "ball-cushion": 0}), r.motion)
        for r in shot.runs
    )
    with style.drawing():
        figure = draw_collisions(Shot(shot.scene, runs))
    assert [line.get_xdata()[0] for line in figure.axes[0].lines] == [5]
    assert "dashed: truth, closed form" in texts_of(figure)


def test_errors_show_value_verdict_and_limit(results):
    with style.drawing():
        figure = draw_errors(load_shot(results, "head-on"))
    text = texts_of(figure)
    assert "90 mm  ✗ fail" in text
    assert "0, exactly  ✓ pass" in text
    assert "truth: closed form" in text
    limits = [line.get_xdata()[0] for line in figure.axes[0].lines if len(line.get_xdata()) == 2]
    assert set(limits) == {5e-3}


def test_our_engine_is_not_said_to_be_exact_against_itself(results):
    with style.drawing():
        text = texts_of(draw_errors(load_shot(results, "break-7")))
    assert "compared with itself" in text
    assert "(1 mm)  not judged" in text  # the newcomer, whom no check covers
    assert "0, exactly" not in text


def test_nothing_to_draw_is_none(results):
    shot = load_shot(results, "stop")
    assert draw_collisions(shot) is None
    still = Shot(shot.scene, tuple(Run(run.label, run.case, None) for run in shot.runs))
    assert draw_paths(still) is None
    assert draw_energy(still) is None
    unable = Shot(shot.scene, tuple(r for r in shot.runs if r.verdict is Verdict.NOT_REPRESENTABLE))
    assert unable.runs
    assert draw_errors(unable) is None


def test_verdicts(results):
    def verdict(scene, label):
        return verdict_of(results.case(scene, label))

    assert verdict("stop", "ghostball") is Verdict.PASS
    assert verdict("stop", "paper-discrete") is Verdict.FAIL
    assert verdict("break-7", "ghostball") is Verdict.REFERENCE
    assert verdict("stop", "newcomer:dt=1e-3") is Verdict.SHOWN
    assert verdict("stop", "pybullet") is Verdict.NOT_REPRESENTABLE
    assert verdict("head-on", "newcomer:dt=1e-3") is Verdict.CRASHED
    assert verdict_of(None) is Verdict.MISSING
    assert is_own_measure(results.case("break-7", "ghostball"))
    assert not is_own_measure(results.case("stop", "ghostball"))


def test_the_summary_names_every_scene(results):
    with style.drawing():
        text = texts_of(draw_verdicts(results))
    assert all(scene in text for scene in results.scene_names)
    assert "✗ 90 mm" in text
    assert "○ (1 mm)" in text  # the newcomer, whom no check covers
    assert "in brackets: not judged" in text


def test_a_chaotic_error_is_no_number(results):
    # Breaks where metres past what can be predicted are drawn or written like an error.
    shot = load_shot(results, "break-7")
    chaotic = tuple(
        Run(r.label, replace(r.case, tags=("chaos",), checks=()), r.motion) for r in shot.runs
    )
    with style.drawing():
        text = texts_of(draw_paths(Shot(shot.scene, chaotic)))
        assert draw_errors(Shot(shot.scene, chaotic)) is None
        mixed = texts_of(
            draw_errors(Shot(shot.scene, (*shot.runs[:1], *chaotic[1:3], shot.runs[3])))
        )
    assert "(chaotic)" in text
    assert " mm" not in text
    assert mixed.count("(chaotic)") == 2
    assert "90 mm  ✗ fail" in mixed


def test_accuracy_counts_closed_form_scenes_alone(results):
    with style.drawing():
        text = texts_of(draw_accuracy(results))
    assert "5 closed-form scenes" in text
    assert "pybullet" not in text  # it ran none


@pytest.mark.parametrize("name", PAPER_FIGURES)
def test_the_papers_figures(results, tmp_path, name):
    with style.drawing():
        figure = PAPER_FIGURES[name](results)
        assert all(path.stat().st_size for path in style.save_figure(figure, tmp_path / name))
    assert f"Figure {name[-1]} of the paper" in texts_of(figure)


def test_overlaps_are_found_deepest_first(results):
    shot = load_shot(results, "break-7")
    found = overlaps(shot, shot.ours.motion)
    assert [o.depth for o in found] == sorted((o.depth for o in found), reverse=True)
    worst = found[0]
    at = np.flatnonzero(shot.ours.motion.times == worst.t)[0]
    a, b = shot.ours.motion.positions[at, [worst.a, worst.b]]
    assert worst.depth == pytest.approx(2 * 0.028575 - np.linalg.norm(a - b))
