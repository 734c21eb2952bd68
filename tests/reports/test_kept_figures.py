"""Figures of the run are kept only where nothing that they show has changed."""

import json
from dataclasses import replace

import pytest
from regressions import identical, regression

from reports import kept_figures, report, style, write_report
from validation.regression import save_regression


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
}
OTHER = {
    "a number": lambda f: edit(f / "results.jsonl", "0.002", "0.0021"),
    "engines": lambda f: environment(f, engines=["pymunk", "ghostball", "pymunk:mode=landed"]),
    "a motion": lambda f: append(next((f / "motion").iterdir())),
    "a measurement": lambda f: (f / "new.json").write_text("{}"),
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
