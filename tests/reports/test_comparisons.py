"""The three comparisons in words: one cell for each heading."""

from __future__ import annotations

from ghostball.reports.comparisons import HEADS, comparison_cells
from ghostball.reports.shots import rest_error_text
from ghostball.validation.results.store import Results


def test_each_run_has_a_cell_for_each_heading(results_folder):
    cases = Results.open(results_folder).cases
    for case in cases:
        cells = comparison_cells(case)
        if case.outcome != "ran":
            assert cells is None
            continue
        rest, _, *counts, _, _ = cells
        assert len(cells) == len(HEADS)
        assert rest in (rest_error_text(case), "the reference", "–")
        for kind, text in zip(("ball-ball", "ball-cushion"), counts, strict=True):
            found, true = case.collision_counts.get(kind, 0), case.truth_counts.get(kind, 0)
            assert text.startswith(f"{found} / ")
            if not case.is_own_measure:
                assert text == f"{found} / {true}" + " ≠" * (found != true)
