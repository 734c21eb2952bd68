"""What is shown of unchanged results is made once, and again where anything of it differs."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from stored_results import change_motion, in_database
from written_results import LABELS, write_results

from ghostball.reports import PAGE, report, reuse, write_report
from ghostball.reports.page import part_on, parts_on, scene_part
from ghostball.reports.shots import load_shot
from ghostball.validation.results.motions import stored_hashes
from ghostball.validation.results.store import Results


@pytest.fixture
def made(monkeypatch):
    """What is drawn and made anew, in this order."""
    names = []

    def watch(name):
        real = getattr(report, name)

        def watched(shot, *rest):
            names.append(f"{name} {shot.scene.name}")
            return real(shot, *rest)

        monkeypatch.setattr(report, name, watched)

    watch("draw_sheet")
    watch("scene_part")
    return names


BOTH = ["draw_sheet stop", "scene_part stop"]


def test_it_is_drawn_once_and_again_only_where_it_is_gone_damaged_or_of_other_code(
    small_folder, monkeypatch, made
):
    write_report(small_folder, figures="svg")
    png, svg = (small_folder / "figures" / f"stop-sheet.{ending}" for ending in ("png", "svg"))
    before = png.read_bytes(), svg.read_bytes()
    page = (small_folder / PAGE).read_bytes()
    write_report(small_folder, figures="svg")
    assert made == BOTH
    assert (small_folder / PAGE).read_bytes() == page

    png.unlink()
    write_report(small_folder, figures="svg")
    svg.write_bytes(b"")
    write_report(small_folder, figures="svg")
    assert made == 3 * BOTH
    assert (png.read_bytes(), svg.read_bytes()) == before

    monkeypatch.setattr(reuse, "_code", lambda: "another")
    write_report(small_folder, figures="svg")
    assert made == 4 * BOTH
    monkeypatch.setattr(reuse, "_code", lambda: "")  # nobody knows which
    write_report(small_folder, figures="svg")
    write_report(small_folder, figures="svg")
    assert made == 6 * BOTH


def test_what_an_earlier_run_measured_stays_as_it_is(small_folder, made):
    write_report(small_folder)
    in_database(small_folder, "UPDATE records SET reused = 1")
    assert all(case.reused for case in Results.open(small_folder).cases)
    write_report(small_folder)
    assert made == BOTH


def test_of_two_scenes_only_the_one_that_changed_is_made_again(tmp_path, made):
    folder = write_results(tmp_path / "two", ["stop", "head-on"], LABELS[:3])
    write_report(folder)
    made.clear()
    change_motion(folder, "stop", "pymunk", energy_height=lambda values: values + 1.0)
    seen = []
    write_report(folder, progress=lambda *part: seen.append(part))
    assert made == BOTH
    assert seen == [(1, 1, "part of report.html on scene stop")]


def test_a_part_is_made_again_where_it_names_another_picture_or_comparison(
    small_folder, monkeypatch, made
):
    write_report(small_folder)
    write_report(small_folder, figures="none")
    assert made == [*BOTH, "scene_part stop"]

    def compared(said):
        change = type("Change", (), {"change": "identical", "summary": said})()
        return type("Regression", (), {"scene": lambda *_: change})()

    of = [report._Sources.of("abc", "png", each, "stop") for each in (None, compared("1"))]
    of.append(report._Sources.of("abc", "png", compared("2"), "stop"))
    assert len({one.part for one in of}) == 3
    assert {one.sheet for one in of} == {"abc"}


@pytest.mark.parametrize("whose", ["changed", "of another", "forgotten"])
def test_nothing_is_taken_from_a_page_that_was_not_written_here(small_folder, made, pages, whose):
    write_report(small_folder)
    whole = (small_folder / PAGE).read_text("utf-8")
    if whose == "changed":
        bad = whole.replace("What was measured", "<script>bad()</script>")
        assert bad != whole
        (small_folder / PAGE).write_text(bad, encoding="utf-8")
    for path in pages.iterdir() if whose == "of another" else ():
        path.unlink()
    if whose == "forgotten":
        (page,) = pages.iterdir()
        os.utime(page, (0, 0))  # clocks may be too coarse to tell which was written first
        for number in range(reuse.KEPT):
            reuse.remember_page(f"another {number}".encode())
    write_report(small_folder)
    assert made == [*BOTH, "scene_part stop"]
    assert (small_folder / PAGE).read_text("utf-8") == whole


def test_where_pages_cannot_be_remembered_that_is_said_and_all_is_made(
    small_folder, made, pages, caplog
):
    pages.write_text("no folder")
    for _ in range(2):
        write_report(small_folder)
    assert made == [*BOTH, "scene_part stop"]
    assert caplog.text.count("can't be written") == 2


@pytest.mark.parametrize("label", ["ghostball", "pymunk"])
def test_a_part_reads_back_as_it_was(small_folder, label):
    def blown_up(values):
        return np.full_like(values, np.nan)

    change_motion(small_folder, "stop", label, energy_height=blown_up, positions=blown_up)
    shot = load_shot(Results.open(small_folder), "stop")
    part = scene_part(shot, None, None, "abc")
    page = parts_on(f"<p>{part.on_page}\n{replace(part, source='def').on_page}<!--part cut")
    assert set(page) == {"abc", "def"}
    assert repr(part_on(page, "abc")) == repr(part)  # nan is not equal to itself
    assert part_on(page, "other") is None
    assert replace(part, source="").on_page == part.html
    assert part_on({"": ""}, "") is None


def hash_of(folder):
    return reuse.drawn_from(Results.open(folder), stored_hashes(folder))["stop"]


def test_whatever_is_shown_changes_the_hash(small_folder):
    def moved(values):
        values = values.copy()
        values[-1, 0, 0] = np.nextafter(values[-1, 0, 0], 1.0)
        return values

    def changed(path):
        return f"UPDATE records SET record = json_set(record, '$.{path}', 1.5)"

    hashes = [hash_of(small_folder)]
    assert hash_of(small_folder) == hashes[0]
    change_motion(small_folder, "stop", "pymunk", positions=moved)
    hashes.append(hash_of(small_folder))
    for change in (
        changed("wall_time"),
        changed("metrics.rest_error_max"),
        changed("definition.balls[0].position[0]"),
        "UPDATE documents SET content = json_set(content, '$.engines', json_array('pymunk'))",
        "INSERT INTO events SELECT id, 1.0, 'ball-ball', 0, 1 FROM motions",
        "UPDATE events SET t = 1.0000000000000002",
        "DELETE FROM motions",
        "DELETE FROM records WHERE name LIKE '%exact%'",
    ):
        in_database(small_folder, change)
        hashes.append(hash_of(small_folder))
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
