"""The picture of where two shots part."""

import pytest

from ghostball.model import GhostballError
from ghostball.reference_adapters import make_engine
from ghostball.reports import plot_explanation, style
from ghostball.reports.parting_figure import draw_explanation
from ghostball.validation import find_scene
from ghostball.validation.diagnose.explanation import explain


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
    # Of each ball a ring, a disc and its edge.
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
    assert {"a ball in truth", "a ball in pymunk"} < set(texts)


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
