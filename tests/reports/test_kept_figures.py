"""Figures of the run are kept only where nothing that they show has changed."""

import io
import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from regressions import identical, regression

from reports import kept_figures, report, style, write_report
from validation.bench.measurements import STORE
from validation.regression import save_regression
from validation.store import ResultsFolder


@pytest.fixture
def drawings(monkeypatch):
    """Draw one simple figure in place of all, and one that has nothing to show; note each time."""
    noted = []

    def draw(results):
        noted.append(results)
        figure = style.new_figure(1.0, 1.0)
        figure.text(0.5, 0.5, str(len(results.cases)))
        return figure

    monkeypatch.setattr(report, "WHOLE_FIGURES", {"verdicts": draw, "accuracy": lambda _: None})
    return noted


def edit(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def turn_round(path):
    path.write_text("".join(reversed(path.read_text().splitlines(keepends=True))))


def append(path):
    path.write_bytes(path.read_bytes() + b"0")  # after the end of an archive: it still reads


def add(path):
    path.parent.mkdir(exist_ok=True)
    path.write_text("")


def environment(folder, **entries):
    path = folder / "env.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | entries))


def test_nothing_is_drawn_again_where_nothing_changed(small_folder, drawings):
    first = write_report(small_folder).read_text()
    picture = small_folder / "figures" / "verdicts.png"
    before = picture.stat().st_mtime_ns
    assert write_report(small_folder).read_text() == first
    assert len(drawings) == 1
    assert picture.stat().st_mtime_ns == before
    assert "figures/verdicts.svg" in first


# What another run of the same writes anew.
SAME = {
    "the order": lambda f: turn_round(f / "results.jsonl"),
    "taken over": lambda f: edit(f / "results.jsonl", '"taken_over":false', '"taken_over":true'),
    "the date": lambda f: environment(
        f, date="2099-01-01", command=["another"], taken_over={"cases": 3}
    ),
    "a comparison": lambda f: save_regression(regression(identical(), outcome="passed"), f),
    "another run below": lambda f: add(f / "wheel" / "results.jsonl"),
    "verdicts for a CI": lambda f: add(f / "junit.xml"),
}
OTHER = {
    "a number": lambda f: edit(f / "results.jsonl", "0.002", "0.0021"),
    "engines": lambda f: environment(f, engines=["pymunk", "ghostball", "pymunk:mode=landed"]),
    "a motion": lambda f: append(next((f / "motion").iterdir())),
    "a new motion": lambda f: add(f / "motion" / "new.npz"),
    "predictability": lambda f: add(f / "predictability.jsonl"),
    "attributions": lambda f: add(f / "attributions.jsonl"),
    "a figure": lambda f: (f / "figures" / "verdicts.svg").write_text("edited"),
    "a figure that is gone": lambda f: (f / "figures" / "verdicts.png").unlink(),
    "the note": lambda f: (f / "figures" / kept_figures.NOTE).write_text("{"),
    "the note that is gone": lambda f: (f / "figures" / kept_figures.NOTE).unlink(),
}


@pytest.mark.parametrize("what", [*SAME, *OTHER])
def test_what_no_figure_shows_may_change_and_nothing_else(small_folder, drawings, what):
    write_report(small_folder)
    (SAME | OTHER)[what](small_folder)
    write_report(small_folder)
    assert len(drawings) == (1 if what in SAME else 2)
    assert "edited" not in (small_folder / "figures" / "verdicts.svg").read_text()


def test_other_code_draws_again(small_folder, drawings, monkeypatch):
    write_report(small_folder)
    monkeypatch.setattr(kept_figures, "hash_sources", lambda _: "edited")
    write_report(small_folder)
    write_report(small_folder)
    assert len(drawings) == 2
    # Edited after it was loaded: nobody knows what is drawn by which code.
    monkeypatch.setattr(kept_figures, "_IMPORTED_NS", 0)
    write_report(small_folder)
    write_report(small_folder)
    assert len(drawings) == 4
    monkeypatch.undo()


def test_code_that_cannot_be_told_draws_again(small_folder, drawings, monkeypatch):
    now = kept_figures.Code.now()
    monkeypatch.setattr(kept_figures.Code, "now", lambda: replace(now, hash=""))
    write_report(small_folder)
    write_report(small_folder)
    assert len(drawings) == 2


@pytest.mark.parametrize("name", kept_figures.DRAW)
def test_another_version_of_what_draws_draws_again(small_folder, drawings, monkeypatch, name):
    write_report(small_folder)
    real = kept_figures.version
    monkeypatch.setattr(kept_figures, "version", lambda of: "0" if of == name else real(of))
    write_report(small_folder)
    assert len(drawings) == 2


def test_a_note_that_does_not_say_what_was_drawn_from_keeps_nothing(
    small_folder, drawings, monkeypatch
):
    write_report(small_folder)
    note = small_folder / "figures" / kept_figures.NOTE
    for inputs in ({}, {"inputs": None}, {"inputs": ""}):
        said = {
            key: value for key, value in json.loads(note.read_text()).items() if key != "inputs"
        }
        with monkeypatch.context() as patch:
            # Else the note would be written anew.
            patch.setattr(kept_figures, "inputs_hash", lambda *_: "")
            patch.setattr(report, "inputs_hash", lambda *_: "")
            note.write_text(json.dumps(said | inputs))
            drawings.clear()
            write_report(small_folder)
        assert len(drawings) == 1


def test_figures_of_results_that_changed_meanwhile_are_not_kept(
    small_folder, drawings, monkeypatch
):
    draw = report.WHOLE_FIGURES["verdicts"]

    def change_and_draw(results):
        edit(small_folder / "results.jsonl", "0.002", "0.0021")
        return draw(results)

    with monkeypatch.context() as patch:
        patch.setitem(report.WHOLE_FIGURES, "verdicts", change_and_draw)
        write_report(small_folder)
    assert not (small_folder / "figures" / kept_figures.NOTE).exists()
    write_report(small_folder)
    assert len(drawings) == 2


@pytest.mark.checkout
def test_every_file_that_a_figure_reads_is_hashed(results_folder, tmp_path, monkeypatch):
    # Breaks where a new figure reads a file that nobody added to those that are hashed.
    folder = shutil.copytree(results_folder, tmp_path / "results")
    for kind in ("scaling.json", "precision.json"):
        shutil.copy(next(STORE.glob(f"*/{kind}")), folder / kind)
    for name in ("predictability.jsonl", "attributions.jsonl"):
        add(folder / name)
    real, read = io.open, set()

    def noted(file, *args, **kwargs):
        if isinstance(file, (str, Path)) and folder in Path(file).parents:
            read.add(Path(file))
        return real(file, *args, **kwargs)

    monkeypatch.setattr(io, "open", noted)
    results = ResultsFolder.load(folder)
    with style.drawing():
        for draw in report.WHOLE_FIGURES.values():
            draw(results)
    monkeypatch.undo()
    # Of these only a part is hashed, as is tested above.
    ours = {folder / name for name in ("results.jsonl", "env.json", "regression.json")}
    assert {folder / name for name in kept_figures.READ} < read
    assert any(path.suffix == ".npz" for path in read)
    for path in read - ours:
        before = kept_figures.inputs_hash(folder, report.WHOLE_FIGURES)
        append(path)
        assert "" != kept_figures.inputs_hash(folder, report.WHOLE_FIGURES) != before
