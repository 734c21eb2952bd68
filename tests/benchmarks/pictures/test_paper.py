"""Fails where one of the paper's figures isn't drawn, or an overlap in it is another."""

import numpy as np
import pytest

from benchmarks.pictures.paper import PAPER_FIGURES, overlaps
from ghostball.reports import style
from ghostball.reports.shots import load_shot
from ghostball.validation.results.store import Results


@pytest.fixture(scope="module")
def results(results_folder) -> Results:
    return Results.open(results_folder)


def texts_of(figure) -> str:
    from matplotlib.text import Text

    return "\n".join(text.get_text() for text in figure.findobj(Text))


@pytest.mark.parametrize("name", PAPER_FIGURES)
def test_the_papers_figures(results, tmp_path, name):
    with style.drawing():
        figure = PAPER_FIGURES[name](results)
        assert all(path.stat().st_size for path in style.save_figure(figure, tmp_path / name))
    assert f"Figure {name[-1]} of the paper" in texts_of(figure)


def test_overlaps_are_found_deepest_first(results):
    shot = load_shot(results, "break-7")
    found = overlaps(shot, shot.ours.motion)
    assert [o.length for o in found] == sorted((o.length for o in found), reverse=True)
    worst = found[0]
    at = np.flatnonzero(shot.ours.motion.times == worst.t)[0]
    a, b = shot.ours.motion.positions[at, [worst.a, worst.b]]
    assert worst.length == pytest.approx(2 * 0.028575 - np.linalg.norm(a - b))
