"""One result is drawn, or filmed, without a folder of results."""

import numpy as np
import pytest
from PIL import Image

from ghostball.model import GhostballError
from ghostball.reports import plot, plot_result


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


def test_a_film_as_mp4_without_ffmpeg_says_what_to_do(result, tmp_path, monkeypatch):
    monkeypatch.setattr("matplotlib.animation.FFMpegWriter.isAvailable", lambda: False)
    with pytest.raises(GhostballError, match=r"needs ffmpeg on the PATH\. Install it"):
        plot_result(result, tmp_path / "shot.mp4")
