"""The three comparisons in words: one cell for each heading."""

from __future__ import annotations

from dataclasses import replace

from ghostball.reports.shared_tables import COMPARISON_HEADS, comparison_cells
from ghostball.reports.shots import rest_error_text
from ghostball.validation.results.store import Results

ROWS = {
    ("stop", "pymunk"): ("2 mm", "cue", "0 / 0", "0 / 0", "0.002", "–"),
    ("head-on", "paper-discrete"): ("30 mm", "cue", "7 / 1 ≠", "0 / 0", "0.03", "–"),
    ("stop", "newcomer:dt=1e-3"): ("(1 mm)", "cue", "0 / 0", "0 / 0", "0.001", "–"),
    ("break-7", "ghostball"): ("the reference", "–", "2 / –", "0 / –", "–", "–"),
}
"""All cells of some stored runs, by scene and engine."""


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
