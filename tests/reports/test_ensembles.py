"""The report's section on ensembles, and its figure: from what is stored alone."""

import re
import shutil
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from stored_results import edit_document, in_database

import ghostball.validation.ensembles.run as run_module
from ghostball.engine import Ball, Scene
from ghostball.reports import style, write_report
from ghostball.reports.figures import draw_ensemble
from ghostball.reports.page.ensembles import ensembles_html, without_end_text
from ghostball.validation.ensembles import EnsembleRecord, Ensembles, Size, run_ensembles
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.suite import run_suite

LABELS = ["ghostball", "paper-discrete", "paper-continuous"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two scenes, one of which only our engine can represent; nobody writes into it."""
    out = tmp_path_factory.mktemp("ensembles") / "out"
    scenes = [find_scene("break-7"), find_scene("sliding-stun")]
    run_suite(scenes, LABELS, out)
    run_ensembles(scenes, LABELS, out, 12)
    return out


def section(folder: Path) -> str:
    return ensembles_html(Results.open(folder), {})


def loaded(folder: Path) -> Ensembles:
    ensembles = Ensembles.load(folder)
    assert ensembles is not None
    return ensembles


def test_the_section_says_what_was_perturbed_compared_and_found(folder: Path):
    text = section(folder)
    for part in (
        "perturbed 12 times",
        "0.001 rad",
        "100 µm",
        "comparison of codes",
        "touching balls are perturbed by opening gaps alone",
        "<strong>Null test of <code>ghostball</code></strong>",
        "<h4>Ensemble of break-7</h4>",
        "<code>ghostball</code>, other members (null test)<td>12 of 12",
        "<code>paper-continuous</code><td>12 of 12",
        "<code>paper-discrete</code>: not representable: no sliding",
    ):
        assert part in text
    # Balls of paper-discrete are seen 20 ms late: it misses collisions, or has them again.
    (row,) = re.findall(r"<code>paper-discrete</code>(<td>.*)", text.split("<h4>")[1])
    assert row.count("<td>") == 7
    assert re.search(r"\d\.\d\d \(\d\.\d\d\), p ", row)


def test_a_comparison_with_proved_shots_is_said_to_be_one(folder: Path, tmp_path: Path):
    scene, labels = find_scene("stop"), ["ghostball", "certified"]
    run_suite([scene], labels, tmp_path)
    run_ensembles([scene], labels, tmp_path, 3)
    assert "<code>certified</code> proves each of its shots" in section(tmp_path)
    assert "not judged: too few members" in section(tmp_path)
    assert "<code>certified</code> proves" not in section(folder)


def test_a_folder_without_ensembles_has_no_section(small_folder: Path):
    assert ensembles_html(Results.open(small_folder), {}) == ""


@pytest.mark.slow
def test_other_processes_draw_the_figures_of_the_run_and_of_ensembles_alike(
    folder: Path, tmp_path: Path
):
    drawn = []
    for jobs in (1, 2):
        copy = shutil.copytree(folder, tmp_path / str(jobs))
        write_report(copy, jobs=jobs)
        drawn.append({path.name: path.read_bytes() for path in (copy / "figures").glob("*")})
    assert {"break-7-sheet.png", "break-7-ensemble.png"} <= drawn[0].keys()
    assert drawn[0] == drawn[1]


@pytest.mark.usefixtures("without_run_figures")
def test_the_report_holds_figure_and_section_and_nothing_stale(tmp_path: Path):
    scene = find_scene("stop")
    run_suite([scene], LABELS[:2], tmp_path)
    run_ensembles([scene], LABELS[:2], tmp_path, 4)
    text = write_report(tmp_path).read_text()
    ensembles = text[text.index('id="ensembles"') : text.index('id="energy"')]
    assert 'alt="How perturbed shots of stop end" src="data:image/png;base64,' in ensembles
    assert "perturbed 4 times" in ensembles
    assert (tmp_path / "figures" / "stop-ensemble.png").exists()
    in_database(tmp_path, "DELETE FROM documents WHERE name = 'ensembles'")
    assert 'id="ensembles"' not in write_report(tmp_path).read_text()
    assert not (tmp_path / "figures" / "stop-ensemble.png").exists()


@pytest.mark.usefixtures("without_run_figures")
def test_an_interrupted_run_and_another_state_of_the_code_are_said(tmp_path: Path, monkeypatch):
    scene = find_scene("stop")
    run_suite([scene], LABELS[:2], tmp_path)
    done = 0

    def interrupt(*_):
        nonlocal done
        done += 1
        if done == 5:
            raise KeyboardInterrupt

    run_ensembles([scene], LABELS[:2], tmp_path, 4, progress=interrupt)
    edit_document(tmp_path, "suite", git={"revision": "another", "dirty": False})
    text = section(tmp_path)
    assert "<strong>These ensembles are not complete</strong>: the run was interrupted" in text
    assert "another state of the code than the cases above" in text
    assert write_report(tmp_path).exists()


def test_members_without_an_end_are_counted_with_reasons():
    record = EnsembleRecord("a", {}, "fake", "fake", "shots", Size())
    assert without_end_text(record) == ""
    many = EnsembleRecord(
        *("a", {}, "fake", "fake", "shots", Size()),
        failed={str(k): f"reason {k % 5}" for k in range(10)},
        stopped={"11": "step-limit"},
    )
    assert without_end_text(many) == (
        "10 members failed: reason 0; reason 1; reason 2; 2 more. "
        "1 member stopped early: step-limit"
    )


@pytest.mark.parametrize("scene", ["break-7", "sliding-stun"])
def test_the_figure_cuts_nothing_off_and_writes_nothing_twice(folder: Path, scene: str):
    with style.drawing():
        figure = draw_ensemble(loaded(folder), scene)
        assert figure is not None
        style.lay_out(figure)
        renderer = figure.canvas.get_renderer()
        texts = [
            text
            for axes in figure.axes
            for text in (axes.title, axes._left_title, axes._right_title, axes.xaxis.label)
            if text.get_text()
        ]
        texts += [text for part in figure.subfigs for text in part.texts]
        boxes = [text.get_window_extent(renderer) for text in texts]
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    for box in boxes:
        assert box.x0 >= 0.0
        assert box.x1 <= figure.bbox.width
        assert box.y0 >= 0.0
        assert box.y1 <= figure.bbox.height


def test_the_figure_shows_every_member_and_the_reference_beneath(folder: Path):
    with style.drawing():
        figure = draw_ensemble(loaded(folder), "break-7")
    assert figure is not None
    clouds = [axes for axes in figure.axes if axes.collections and axes.get_aspect() == 1.0]
    assert [len(axes.collections) for axes in clouds] == [1, 2, 2]
    ends = np.concatenate([cloud.get_offsets() for cloud in clouds[0].collections])
    record = loaded(folder).of("break-7")["ghostball"]
    expected = loaded(folder).members(record).rest_positions.reshape(-1, 2)
    assert np.array_equal(np.asarray(ends), expected)


def test_a_scene_without_any_end_has_no_figure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    scene = Scene(name="roll", balls=[Ball(id="a", position=(0, 0), velocity=(1.0, 0.0))])
    run_suite([scene], LABELS[:2], tmp_path)
    monkeypatch.setattr(run_module, "run_member", lambda task: run_module.unended(task, "bad luck"))
    run_ensembles([scene], LABELS[:2], tmp_path, 2)
    assert draw_ensemble(loaded(tmp_path), "roll") is None
    text = write_report(tmp_path).read_text()
    assert "<code>paper-discrete</code>: 2 members failed: bad luck" in text
    assert "Null test of <code>ghostball</code></strong> not made" in text
