"""Fails where the report hides a verdict or a reason, or a bad folder gives no clear error."""

import numpy as np
import pytest
from PIL import Image

from ghostball.model import (
    EVENT_DTYPE,
    GhostballError,
    Result,
    SampledTrajectory,
    Status,
    initial_state,
)
from ghostball.reports import (
    PAGE,
    film,
    plot_result,
    write_report,
)
from ghostball.reports.shots import load_shot
from ghostball.validation.results.store import Results


@pytest.fixture(scope="module")
def results(module_folder):
    """Three scenes on seven engines."""
    return Results.open(module_folder)


def drawn(folder):
    return {path.name for path in (folder / "figures").glob("*")}


def test_pictures_are_those_that_are_asked_for_and_the_page_holds_or_names_them(small_folder):
    seen = []
    page = write_report(small_folder, progress=lambda *part: seen.append(part))
    assert seen == [(1, 1, "part of report.html on scene stop")]
    assert drawn(small_folder) == {"stop-sheet.png"}
    text = page.read_text(encoding="utf-8")
    assert '<a href="figures/stop-sheet.png">' in text
    assert text == write_report(small_folder, figures="svg").read_text(encoding="utf-8")
    assert drawn(small_folder) == {"stop-sheet.png", "stop-sheet.svg"}
    assert text == write_report(small_folder).read_text(encoding="utf-8")
    assert drawn(small_folder) == {"stop-sheet.png"}
    text = write_report(small_folder, figures="none").read_text(encoding="utf-8")
    assert drawn(small_folder) == set()
    assert "stop-sheet" not in text


def test_another_process_draws_the_same(small_folder):
    (small_folder / "figures").mkdir()
    for name in ("gone-sheet.png", "mine.png"):  # of a scene that is no more, and somebody's
        (small_folder / "figures" / name).touch()

    def contents():
        paths = [small_folder / PAGE, *(small_folder / "figures").iterdir()]
        return {path.name: path.read_bytes() for path in paths}

    seen = []
    write_report(small_folder, figures="svg")
    one = contents()
    for path in (small_folder / "figures").glob("stop-sheet.*"):
        path.unlink()  # else it would stay as it is
    write_report(small_folder, progress=lambda *part: seen.append(part), jobs=2, figures="svg")
    assert seen[-1][0] == seen[-1][1] == len(seen)
    assert contents() == one
    assert one.keys() == {PAGE, "stop-sheet.png", "stop-sheet.svg", "mine.png"}


def test_a_folder_that_holds_no_results(tmp_path):
    with pytest.raises(GhostballError, match="no such results folder"):
        write_report(tmp_path / "nowhere")
    with pytest.raises(GhostballError, match="not a results folder"):
        write_report(tmp_path)


@pytest.fixture
def result(results_folder):
    shot = load_shot(Results.open(results_folder), "head-on")
    motion, state = shot.ours.motion, initial_state(shot.scene)
    return Result(
        engine="ghostball",
        settings={},
        scene=shot.scene,
        status=Status.REST,
        final_state=state,
        rest_time=3.0,
        collision_counts={"ball-ball": 1, "ball-cushion": 0},
        work={},
        wall_time=0.0,
        events=np.array([(1.0, 0, 0, 1)], dtype=EVENT_DTYPE),
        trajectory=SampledTrajectory(
            motion.times, motion.positions, motion.velocities, motion.angular_velocities
        ),
    )


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_one_result_is_drawn(result, tmp_path, ending):
    path = plot_result(result, tmp_path / f"shot.{ending}")
    assert path.stat().st_size > 5_000


def test_a_film_shows_the_shot_to_its_end_and_no_longer_than_it_may(result, tmp_path, monkeypatch):
    monkeypatch.setattr(film, "LONGEST", 0.4)
    with Image.open(plot_result(result, tmp_path / "shot.gif")) as shot:
        assert shot.n_frames == 2 + int(0.4 * film.FRAMES_A_SECOND)
        assert shot.info["duration"] == 1000 / film.FRAMES_A_SECOND
        first = np.asarray(shot.convert("RGB"))
        shot.seek(shot.n_frames - 1)
        assert np.any(first != np.asarray(shot.convert("RGB")))


def test_a_film_as_mp4_without_ffmpeg_says_what_to_do(result, tmp_path, monkeypatch):
    monkeypatch.setattr("matplotlib.animation.FFMpegWriter.isAvailable", lambda: False)
    with pytest.raises(GhostballError, match=r"needs ffmpeg on the PATH\. Install it"):
        plot_result(result, tmp_path / "shot.mp4")
