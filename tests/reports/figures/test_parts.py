"""Drawings of tables, fits, single results and first wrong collisions."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

import ghostball
from ghostball.engine import simulate
from ghostball.model import Ball, GhostballError, Scene, Table
from ghostball.reference_adapters import make_engine
from ghostball.reports import plot, plot_explanation, plot_result, style
from ghostball.reports.figures._table import aspect_of, draw_discs, draw_table, view_of
from ghostball.reports.figures.fitted import draw_fit
from ghostball.reports.parting_figure import draw_explanation
from ghostball.reports.plot import film
from ghostball.validation import find_scene
from ghostball.validation.diagnose.explanation import explain

# A table is drawn to scale, and a ball lost far away doesn't shrink the table.


TABLE = Table(length=2.0, width=1.0, cushions=("left", "right", "bottom"))
CUE = Ball(id="cue", position=(0.5, 0.5), velocity=(1.0, 0.0))
SCENE = Scene(name="one", table=TABLE, balls=[CUE])


def holds(view, x, y):
    left, right, bottom, top = view
    return left <= x <= right and bottom <= y <= top


def test_the_whole_table_is_seen_and_what_is_lost_far_away_is_not():
    alone = view_of(SCENE)
    assert holds(alone, 0.0, 0.0)
    assert holds(alone, 2.0, 1.0)
    lost = np.array([[[1000.0, 0.5, 0.0]], [[np.nan, 0.5, 0.0]]])
    view = view_of(SCENE, lost)
    assert not holds(view, 1000.0, 0.5)
    assert view[1] <= 1.25 * TABLE.length
    assert holds(view_of(SCENE, lost, needed=lost[0]), 1000.0, 0.5)


def test_a_straight_shot_without_a_table_is_no_line():
    scene = Scene(name="far", balls=[CUE])
    view = view_of(scene, np.array([[[9.0, 0.5, 0.0]]]))
    assert aspect_of(view) == pytest.approx(0.3, abs=0.05)


def test_cushions_are_bars_a_side_without_one_is_dotted_and_discs_have_their_radius():
    with style.drawing():
        axes = style.new_figure(4.0, 3.0).subplots()
        view = view_of(SCENE)
        draw_table(axes, SCENE, view, ticks=False)
        discs = draw_discs(axes, SCENE.positions, SCENE.radii)
    assert len(axes.patches) == 1 + 3  # cloth and cushions
    assert [line.get_linestyle() for line in axes.lines] == [":"]
    assert axes.get_aspect() == 1.0
    assert (*axes.get_xlim(), *axes.get_ylim()) == view
    assert discs.get_widths() == pytest.approx(2.0 * SCENE.radii)


# The picture of a fit shows all events.


LEFT = {"rolling": np.linspace(-9.0, 9.0, 30)[:, None], "hit": np.zeros((9, 8))}
FITTED = SimpleNamespace(
    families={
        name: [SimpleNamespace(speed=0.1 + k) for k in range(len(left))]
        for name, left in LEFT.items()
    },
    solutions={name: SimpleNamespace(residuals=left) for name, left in LEFT.items()},
)


@pytest.fixture
def figure(monkeypatch, tmp_path) -> Figure:
    drawn = []
    save = style.save_one
    monkeypatch.setattr(style, "save_one", lambda *given: (drawn.append(given[0]), save(*given)))
    draw_fit(FITTED, tmp_path / "left.png")
    with Image.open(tmp_path / "left.png") as image:
        assert image.width > 400
    return drawn[0]


def test_each_family_has_a_panel_with_all_its_numbers(figure):
    rolling, hits = figure.axes
    assert rolling.get_title(loc="left") == "Rolling balls: deceleration (30)"
    assert "(9)" in hits.get_title(loc="left")
    assert len(rolling.lines[1].get_xdata()) == 30
    assert len(hits.lines[1].get_xdata()) == 72


def test_what_is_far_off_is_drawn_at_the_edge(figure):
    low, high = figure.axes[0].get_ylim()
    y = figure.axes[0].lines[1].get_ydata()
    assert low < min(y) < -5.0
    assert 5.0 < max(y) < high


# A single result is drawn or filmed without a results folder.


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_one_result_is_drawn(result, tmp_path, ending):
    path = plot_result(result, tmp_path / f"shot.{ending}")
    assert path.stat().st_size > 5_000


def test_a_film_shows_the_shot_to_its_end_and_no_longer_than_it_may(result, tmp_path, monkeypatch):
    monkeypatch.setattr(plot, "LONGEST", 0.4)
    with Image.open(plot_result(result, tmp_path / "shot.gif")) as shot:
        assert shot.n_frames == 2 + int(0.4 * plot.FRAMES_A_SECOND)
        assert shot.info["duration"] == 1000 / plot.FRAMES_A_SECOND
        first = np.asarray(shot.convert("RGB"))
        shot.seek(shot.n_frames - 1)
        assert np.any(first != np.asarray(shot.convert("RGB")))


def frames_of(path):
    """Return each frame of a film, (height, width, 3)."""
    with Image.open(path) as shot:
        for k in range(shot.n_frames):
            shot.seek(k)
            yield np.asarray(shot.convert("RGB")).astype(int)


def test_the_clock_of_a_film_hides_nothing_of_the_table(tmp_path, monkeypatch):
    # The clock must not cover a pocket: only balls may change on the table.
    monkeypatch.setattr(plot, "LONGEST", 0.4)
    shot = simulate(find_scene("pocket-break-9"), record="trajectory")
    frames = np.array(list(frames_of(film(shot, tmp_path / "shot.gif"))))
    strip = round(100 * plot.STRIP)
    assert (np.ptp(frames, axis=0)[:strip] > 60).any()
    pockets = [(frame.max(axis=2) < 60)[strip:] for frame in frames[:2]]
    assert pockets[0][:strip].any()  # the pockets at the upper cushion, once covered by the clock
    # Each frame of a GIF has its own palette, so edges may differ.
    assert (pockets[0] & pockets[1]).sum() > 0.97 * pockets[0].sum()


def test_a_picture_is_no_film_and_the_error_names_the_other_function(result, tmp_path):
    assert film(result, tmp_path / "shot.gif").stat().st_size > 5_000
    with pytest.raises(GhostballError, match=r"must end in \.gif, \.mp4.*Call `plot`"):
        film(result, tmp_path / "shot.png")
    with pytest.raises(GhostballError, match=r"must end in \.png.*Call `film`"):
        plot.plot(result, tmp_path / "shot.gif")


@pytest.mark.parametrize("draw", [film, plot.plot])
def test_a_result_without_a_motion_is_refused_with_what_to_call(draw, tmp_path):
    still = simulate(find_scene("stop"), record="rest")
    with pytest.raises(GhostballError, match=r'Call simulate\(scene, record="trajectory"\)'):
        draw(still, tmp_path / "shot")


def test_plot_and_film_are_names_of_the_package():
    assert ghostball.plot is plot.plot
    assert ghostball.film is plot.film


def test_a_film_as_mp4_without_ffmpeg_says_what_to_do(result, tmp_path, monkeypatch):
    monkeypatch.setattr("matplotlib.animation.FFMpegWriter.isAvailable", lambda: False)
    with pytest.raises(GhostballError, match=r"needs ffmpeg on the PATH\. Install it"):
        plot_result(result, tmp_path / "shot.mp4")


# The picture of the first wrong collision.


@pytest.fixture(scope="module")
def parted():
    return explain(find_scene("break-7"), make_engine("pymunk"), label="pymunk", attributed=False)


def test_both_collisions_are_marked_and_all_balls_drawn(parted):
    with style.drawing():
        figure = draw_explanation(parted)
    table, close = figure.axes
    for axes in (table, close):
        markers = [line.get_marker() for line in axes.lines if line.get_marker() in ("+", "x")]
        assert markers == ["+", "x"]
    # For each ball there is a ring, a disc and the disc's edge.
    circles = [patch for patch in table.patches if type(patch).__name__ == "Circle"]
    assert len(circles) == 3 * 7
    assert '"1" hits "3"' in figure.get_suptitle()
    left, right = close.get_xlim()
    bottom, top = close.get_ylim()
    mark = next(line for line in close.lines if line.get_marker() == "+")
    (x,), (y,) = mark.get_data()
    assert (left + right) / 2 == pytest.approx(x)
    assert (bottom + top) / 2 == pytest.approx(y)


def test_the_balls_of_both_collisions_are_whole_in_the_close_up(parted):
    with style.drawing():
        figure = draw_explanation(parted)
    (left, right), (bottom, top) = figure.axes[1].get_xlim(), figure.axes[1].get_ylim()
    for run in (parted.known.result, parted.result):
        centres = run.sample([parted.parting.t]).positions[0, :, :2]
        for one in (parted.parting.true, parted.parting.other):
            for ball in one.balls:
                (x, y), r = centres[ball], parted.scene.radii[ball]
                assert left < x - r < x + r < right
                assert bottom < y - r < y + r < top


def test_the_legend_says_which_balls_are_whose(parted):
    with style.drawing():
        (legend,) = draw_explanation(parted).legends
    texts = [text.get_text() for text in legend.get_texts()]
    assert {"ball in the reference", "ball in pymunk"} < set(texts)


def test_balls_that_are_apart_are_named_in_both_shots():
    found = explain(find_scene("half-ball-cut"), make_engine("paper-discrete"), attributed=False)
    with style.drawing():
        close = draw_explanation(found).axes[1]
    assert [text.get_text() for text in close.texts].count("object") == 2


def test_where_nothing_parts_the_ends_are_drawn(tmp_path):
    found = explain(find_scene("half-ball-cut"), make_engine("paper-discrete"), attributed=False)
    with style.drawing():
        figure = draw_explanation(found)
    assert "the same collisions" in figure.get_suptitle()
    for ending in ("png", "svg"):
        target = tmp_path / f"cut.{ending}"
        assert plot_explanation(found, target) == target
        assert target.stat().st_size > 1000


def test_another_ending_or_an_unwritable_file_is_refused(parted, tmp_path):
    with pytest.raises(GhostballError, match="must end in"):
        plot_explanation(parted, tmp_path / "shot.bmp")
    with pytest.raises(GhostballError, match="can't write"):
        plot_explanation(parted, tmp_path / "nowhere" / "shot.png")
