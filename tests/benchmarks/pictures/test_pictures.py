import numpy as np
import pytest

from benchmarks.pictures import gallery
from benchmarks.pictures.chaos import SPEED_CHANGES, neighbours_of
from benchmarks.pictures.gallery import write_gallery
from benchmarks.pictures.paper import PAPER_FIGURES, overlaps
from benchmarks.pictures.racks import draw_racks
from benchmarks.pictures.shots import our_shot
from benchmarks.racks import RacksMeasurement, RackTimes
from ghostball.model import GhostballError
from ghostball.reports import style
from ghostball.reports.shots import load_shot
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import find_scene

# Neighbouring shots: the tangent map predicts their distance while it is small


def test_neighbouring_shots_part_as_the_tangent_map_says_while_they_are_near():
    known = neighbours_of(find_scene("chaos-a"))
    noise = 32.0 * 2.0**-53 * known.growth
    for distance, predicted in zip(known.distance, known.predicted, strict=True):
        clear = (predicted < 1e-4) & (predicted > 30.0 * noise) & (predicted > 0.0)
        ratio = distance[clear] / predicted[clear]
        assert np.all((ratio > 0.8) & (ratio < 1.25))
        assert distance[0] == 0.0
    # The paper's 1e-4 changes everything.
    assert SPEED_CHANGES[0] == 1e-4
    assert known.distance[0, -1] > 1.0


# The pictures of the README, made by `python -m benchmarks gallery`


def test_the_gallery_is_complete(results_folder, tmp_path, monkeypatch):
    # How a figure is written is tested with figures; drawing all of these takes seconds.
    monkeypatch.setattr(style, "lay_out", lambda _: None)
    monkeypatch.setattr(style, "save_one", lambda figure, path, _: path.write_text(str(figure)))
    # The results have no scene with the tag "chaos".
    figures = {name: draw for name, draw in gallery.GALLERY.items() if name != "chaos"}
    monkeypatch.setattr(gallery, "GALLERY", figures)
    folder = tmp_path / "new" / "gallery"
    written = write_gallery(results_folder, folder)
    assert sorted(written) == sorted(folder.iterdir())
    names = {path.stem for path in written}
    assert {path.suffix for path in written} == {".png"}
    assert all(path.read_text().startswith("Figure(") for path in written)
    assert {"hero", "paper-figure-2"} <= names
    assert {"physics-deflection", "physics-throw", "precision", "racks", "steps"} <= names


def test_a_gallery_without_its_scenes_is_an_error(small_folder, tmp_path):
    with pytest.raises(GhostballError, match='scene "pocket-break-9"'):
        write_gallery(small_folder, tmp_path / "gallery")
    assert not (tmp_path / "gallery").exists()


# Each figure of the paper is drawn, with the right overlaps


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


# The picture shows the measured distribution with the right marks


MEASURED = RacksMeasurement(
    engines=(
        RackTimes(engine="ghostball", seconds=(4e-5, 1e-5, 3e-5, 4e-3)),
        RackTimes(engine="pooltool", seconds=(0.2, 0.1)),
        RackTimes(engine="billiards", detail="no cloth"),
    ),
)


@pytest.fixture
def axes():
    with style.drawing():
        (axes,) = draw_racks(MEASURED).axes
    return axes


def test_each_engine_that_played_is_a_line_of_its_times_in_order(axes):
    lines = {line.get_label(): line for line in axes.lines}
    assert [name for name in lines if "racks" in name] == [
        "ghostball, 4 racks",
        "pooltool, 2 racks",
    ]
    ours = lines["ghostball, 4 racks"]
    assert list(ours.get_xdata()) == [1e-5, 3e-5, 4e-5, 4e-3]
    assert list(ours.get_ydata()) == [0.25, 0.5, 0.75, 1.0]
    assert axes.get_xscale() == "log"


def test_median_mean_99th_percentile_and_slowest_are_marked(axes):
    marks = {
        line.get_marker(): (line.get_xdata()[0], line.get_ydata()[0])
        for line in axes.lines
        if line.get_color() == style.BLACK and len(line.get_xdata()) == 1
    }
    assert marks["o"] == (pytest.approx(3.5e-5), 0.5)
    assert marks["D"] == (pytest.approx(1.02e-3), 0.75)
    assert marks["^"] == marks["s"] == (4e-3, 1.0)
    written = [text.get_text() for text in axes.texts]
    assert written == ["35 µs", "1.02 ms", "4 ms", "4 ms", "150 ms", "150 ms", "200 ms", "200 ms"]


# A picture of a shot needs the motion of Ghostball's engine; without it the error says so


def test_our_run_is_found_and_its_lack_is_named(small_folder):
    results = Results.open(small_folder)
    shot, run = our_shot(results, "stop")
    assert run is shot.ours
    assert run.motion is not None
    others = Results(
        results.path,
        [one for one in results.cases if one.label != "ghostball"],
        results.environment,
    )
    for lacking, name in ((results, "break-7"), (others, "stop")):
        with pytest.raises(GhostballError, match=f'the motion of scene "{name}" on Ghostball'):
            our_shot(lacking, name)
