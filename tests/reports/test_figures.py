"""Fails where a figure misses an engine, hides why one is missing, or differs between two runs."""

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from ghostball.engine import Scene
from ghostball.engine.trajectory import Phase
from ghostball.reports import style
from ghostball.reports.figures import (
    SCENE_FIGURES,
    draw_accuracy,
    draw_collisions,
    draw_energy,
    draw_errors,
    draw_paths,
    draw_verdicts,
)
from ghostball.reports.figures._phases import parts_of, sliding_look
from ghostball.reports.figures._table import view_of
from ghostball.reports.figures.single import draw_single
from ghostball.reports.paper_figures import PAPER_FIGURES, overlaps
from ghostball.reports.shots import Run, Shot, load_shot
from ghostball.validation.checks.verdict import Verdict, is_own_measure, verdict_of
from ghostball.validation.results.store import Check, Results


@pytest.fixture(scope="session")
def results(results_folder: Path) -> Results:
    return Results.open(results_folder)


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


def test_a_figure_carries_what_it_was_drawn_from(results, tmp_path):
    with style.drawing():
        figure = draw_errors(load_shot(results, "head-on"))
        png, svg = style.save_figure(figure, tmp_path / "figure", "0123abc")
    assert Image.open(png).text["Description"] == "0123abc"
    assert "<dc:description>0123abc</dc:description>" in svg.read_text()


def test_the_paths_name_every_engine_and_why_one_is_missing(results):
    with style.drawing():
        text = texts_of(draw_paths(load_shot(results, "head-on")))
    assert "pymunk, default: 90 mm" in text
    assert "not representable: pybullet" in text
    assert "did not finish: newcomer, dt=1e-3" in text
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


def sliding_until(run: Run, t: float) -> Run:
    """A run whose balls all slide until t [s], and roll after."""
    phases = np.full(run.motion.positions.shape[:2], Phase.ROLLING, dtype=np.int8)
    phases[run.motion.times < t] = Phase.SLIDING
    return Run(run.label, run.case, replace(run.motion, phases=phases))


@pytest.mark.parametrize("draw", [draw_paths, draw_single])
@pytest.mark.parametrize("scene", ["wall-bounce", "head-on", "break-7"])
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


@pytest.mark.parametrize("draw", [draw_paths, draw_single])
@pytest.mark.parametrize("scene", ["head-on", "break-7"])
def test_nothing_is_said_of_sliding_where_no_ball_is_known_to_slide(results, scene, draw):
    shot = load_shot(results, scene)
    assert shot.ours.motion.phases is None  # as in a folder of an earlier version
    with style.drawing():
        for run in (shot.ours, sliding_until(shot.ours, 0.0)):
            assert "slides" not in texts_of(draw(Shot(shot.scene, (run,))))


def test_engines_that_record_frames_are_drawn_as_ever_beside_one_that_slides(results):
    shot = load_shot(results, "wall-bounce")
    runs = tuple(sliding_until(run, 1.0) if run is shot.ours else run for run in shot.runs)
    with style.drawing():
        figure = draw_paths(Shot(shot.scene, runs))
    text = texts_of(figure)
    assert text.count("ghostball, where a ball slides") == 1
    assert "pymunk, where a ball slides" not in text
    # It has no motion, and so no line.
    assert not any("pybullet" in entry.get_text() for entry in figure.legends[0].get_texts())
    assert "not representable: pybullet" in figure.legends[0].get_title().get_text()


def test_the_parts_of_a_path_meet_and_none_is_lost():
    line = np.column_stack((np.arange(7.0), np.arange(7.0) ** 2))
    slides = np.array([False, True, True, False, True, True, True])
    parts = dict(parts_of(line, slides))
    nan = np.nan
    assert parts[False][:, 0].tolist() == pytest.approx([0, 1, nan, 3, 4], nan_ok=True)
    assert parts[True][:, 0].tolist() == pytest.approx([1, 2, 3, nan, 4, 5, 6], nan_ok=True)
    for wanted in (False, True):
        ((only, part),) = parts_of(line, np.full(7, wanted))
        assert only is wanted
        assert np.array_equal(part, line)
    # A motion of one instant.
    ((_, point),) = parts_of(line[:1], slides[:1])
    assert np.array_equal(point, line[:1])


def test_a_sliding_part_is_never_more_than_opaque():
    assert sliding_look({"linewidth": 1.0, "alpha": 0.9})["alpha"] == 1.0


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


@pytest.mark.parametrize("name", ["head-on", "break-7"])
def test_a_single_run_shows_names_and_metres_and_speaks_of_no_truth(results, name):
    # Breaks where a picture of one run explains rings and errors that it doesn't have.
    shot = load_shot(results, name)
    alone = Shot(shot.scene, tuple(run for run in shot.runs if run.label == "pymunk"))
    with style.drawing():
        text = texts_of(draw_single(alone))
    for absent in ("truth", "error", "ring", "Bars"):
        assert absent not in text
    for part in ("x [m]", "y [m]", "cue", "Grey discs: start", f"{name} on pymunk"):
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
    run = Run(run.label, replace(run.case, rest_positions=scene.positions), run.motion)
    with style.drawing():
        text = texts_of(draw_single(Shot(scene, (run,))))
    assert "Numbers: order of the balls in the scene" in text
    assert "\n9\n" in text
    assert "ball-8" not in text


def test_an_error_judged_in_ulps_is_shown_with_its_limit(results):
    # Breaks where "pass" stands in a row that has no mark of a limit.
    shot = load_shot(results, "head-on")
    first, *others = shot.runs
    for value, text in ((0.42, "✓ pass: 0.42 ≤ 4 ulps"), (7.0, "✗ fail: 7 > 4 ulps")):
        check = Check("rest_error_ulps", value, "at_most", 4, "1", value <= 4, "rounding")
        run = Run(first.label, replace(first.case, checks=(check,)), first.motion)
        with style.drawing():
            assert text in texts_of(draw_errors(Shot(shot.scene, (run, *others))))


def test_nothing_is_said_to_rest_where_a_scene_ends_at_t_max(results):
    shot = load_shot(results, "head-on")
    runs = tuple(
        Run(r.label, r.case and replace(r.case, status="t-max"), r.motion) for r in shot.runs
    )
    with style.drawing():
        for draw in (draw_errors, draw_paths):
            text = texts_of(draw(Shot(shot.scene, runs)))
            assert "rest" not in text.replace("restitution", "")
            assert "end" in text


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
        Run(r.label, replace(r.case, horizon=0.5, checks=()), r.motion) for r in shot.runs
    )
    with style.drawing():
        text = texts_of(draw_paths(Shot(shot.scene, chaotic)))
        assert draw_errors(Shot(shot.scene, chaotic)) is None
        mixed = texts_of(
            draw_errors(Shot(shot.scene, (*shot.runs[:1], *chaotic[1:3], shot.runs[3])))
        )
    assert "(past horizon)" in text
    assert " mm" not in text
    assert mixed.count("(past horizon)") == 2
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
