"""Tables that the terminal and the page share: comparisons with the reference, and spreads."""

from __future__ import annotations

from dataclasses import replace

import pytest

from ghostball.reports import shared_tables
from ghostball.reports.shared_tables import (
    COMPARISON_HEADS,
    SPREAD_HEADS,
    comparison_cells,
    spread_remarks,
    spread_rows,
)
from ghostball.reports.shots import rest_error_text
from ghostball.validation.results.store import Results
from ghostball.validation.suite.spread import QUANTITIES, SceneSpread, Spread

ROWS = {
    ("stop", "pymunk"): ("2 mm", "cue", "0 / 0", "0 / 0", "0.002", "–"),
    ("head-on", "paper-discrete"): ("30 mm", "cue", "7 / 1 ≠", "0 / 0", "0.03", "–"),
    ("stop", "newcomer:dt=1e-3"): ("(1 mm)", "cue", "0 / 0", "0 / 0", "0.001", "–"),
    ("break-7", "ghostball"): ("the reference", "–", "2 / –", "0 / –", "–", "–"),
}
"""All cells of some stored runs, by scene and engine."""


OURS, NEAR, FAR = Spread(3.0, 0.5), Spread(3.1, 0.5, 1.0), Spread(9.0, 0.5, 12.0)


def test_each_run_has_a_cell_for_each_heading(results_folder):
    cases = Results.open(results_folder).cases
    for case in cases:
        cells = comparison_cells(case)
        if case.outcome != "ran":
            assert cells is None
            continue
        rest, _, *counts, _, _ = cells
        assert len(cells) == len(COMPARISON_HEADS)
        assert rest == ("the reference" if case.is_own_measure else rest_error_text(case))
        for kind, text in zip(("ball-ball", "ball-cushion"), counts, strict=True):
            found, true = case.collision_counts.get(kind, 0), case.truth_counts.get(kind, 0)
            assert text.startswith(f"{found} / ")
            if not case.is_own_measure:
                assert text == f"{found} / {true}" + " ≠" * (found != true)
    by_run = {(case.scene, case.label): case for case in cases}
    assert {key: comparison_cells(by_run[key]) for key in ROWS} == ROWS
    case = by_run["stop", "pymunk"]
    timed = replace(case, metrics=case.metrics | {"energy_difference_time": 1.25})
    assert comparison_cells(timed) == (*ROWS["stop", "pymunk"][:-1], "1.25 s")


def of(label, *, ended=5, broken=0, reasons=(), **found):
    spread = None if ended < 2 else 0.012
    return SceneSpread("break", label, 5, ended, broken, reasons, spread, found)


@pytest.fixture
def shown(monkeypatch):
    rest = list(QUANTITIES)[-1]
    found = [
        of("ghostball", **{rest: OURS}),
        of("near", broken=2, **{rest: NEAR}),
        of("far", **{rest: FAR}),
        of("gone", ended=1, reasons=("it hung",)),
    ]
    monkeypatch.setattr(shared_tables, "spreads_of", lambda _: iter(found))


@pytest.mark.usefixtures("shown")
def test_a_row_has_a_cell_under_each_heading_and_a_scene_is_named_once():
    rows = list(spread_rows(None))
    assert {len(row) for row in rows} == {len(SPREAD_HEADS)}
    assert [row[0] for row in rows] == ["break", "", "", ""]
    assert [row[-1] for row in rows] == ["3 ± 0.5", "3.1 ± 0.5 (+1.0)", "≠ 9 ± 0.5 (+12.0)", "–"]
    assert [row[2:4] for row in rows[::3]] == [["5 of 5", "12 mm"], ["1 of 5", "–"]]


@pytest.mark.usefixtures("shown")
def test_what_is_wrong_is_said():
    assert list(spread_remarks(None)) == [
        "break on near: 2 starts that end break a limit of every engine",
        "break on gone: 4 starts without an end: it hung",
    ]
