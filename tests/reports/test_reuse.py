"""Fails where a picture is drawn again for nothing, or stays though what it shows has changed."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ghostball.model import Ball
from ghostball.reports import report, reuse, write_report
from ghostball.reports.shots import load_shot
from ghostball.validation.results.store import Results


@pytest.fixture
def shot(small_folder):
    return load_shot(Results.open(small_folder), "stop")


def test_it_is_drawn_once_and_again_only_where_it_is_gone_damaged_or_of_other_code(
    small_folder, monkeypatch
):
    drawn = []

    def draw(shot):
        drawn.append(shot.scene.name)
        return draw_sheet(shot)

    draw_sheet = report.draw_sheet
    monkeypatch.setattr(report, "draw_sheet", draw)
    write_report(small_folder, figures="svg")
    png, svg = (small_folder / "figures" / f"stop-sheet.{ending}" for ending in ("png", "svg"))
    before = png.read_bytes(), svg.read_bytes()
    write_report(small_folder, figures="svg")
    assert drawn == ["stop"]

    png.unlink()
    write_report(small_folder, figures="svg")
    svg.write_bytes(b"")
    write_report(small_folder, figures="svg")
    assert drawn == 3 * ["stop"]
    assert (png.read_bytes(), svg.read_bytes()) == before

    monkeypatch.setattr(reuse, "_code", lambda: "another")
    write_report(small_folder, figures="svg")
    assert drawn == 4 * ["stop"]
    monkeypatch.setattr(reuse, "_code", lambda: "")  # nobody knows which
    write_report(small_folder, figures="svg")
    write_report(small_folder, figures="svg")
    assert drawn == 6 * ["stop"]


def test_the_hash_is_the_same_wherever_it_is_read(small_folder, shot):
    again = load_shot(Results.open(small_folder), "stop")
    assert reuse.drawn_from(again) == reuse.drawn_from(shot)
    assert again.runs[0].style  # what is found later isn't part of it
    assert reuse.drawn_from(again) == reuse.drawn_from(shot)


def changed(shot, **fields):
    first = shot.runs[0]
    return replace(shot, runs=(replace(first, **fields), *shot.runs[1:]))


def test_whatever_is_shown_changes_the_hash(shot):
    case, motion = shot.runs[0].case, shot.runs[0].motion
    balls = (Ball(id="other", position=(0.5, 0.5)), *shot.scene.balls[1:])
    moved = motion.positions.copy()
    moved[-1, 0, 0] = np.nextafter(moved[-1, 0, 0], 1.0)
    others = [
        replace(shot, scene=shot.scene.model_copy(update={"balls": balls})),
        replace(shot, runs=shot.runs[::-1]),
        changed(shot, label="pymunk:dt=1e-5"),
        changed(shot, case=replace(case, wall_time=1e-9)),
        changed(shot, case=replace(case, metrics={**case.metrics, "rest_error_max": 1.0})),
        changed(shot, motion=replace(motion, positions=moved)),
        changed(shot, motion=None),
    ]
    hashes = [reuse.drawn_from(each) for each in (shot, *others)]
    assert len(set(hashes)) == len(hashes)


def test_what_is_cut_off_while_it_is_written_leaves_no_picture(small_folder, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("ghostball.validation.results.files.Path.replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_report(small_folder)
    assert not list((small_folder / "figures").iterdir())


def test_a_picture_that_says_nothing_is_no_picture_of_it(tmp_path):
    (tmp_path / "sheet.png").write_bytes(b"anything")
    assert not reuse.is_drawn(tmp_path / "sheet", ["png"], "")
    assert not reuse.is_drawn(Path(tmp_path, "none"), ["png"], "abc")
