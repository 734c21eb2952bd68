"""What stands in a cell: a class, a shade, or what an engine lacks."""

from __future__ import annotations

import dataclasses

import pytest
from likenesses import likeness

from ghostball.validation.board.board import run_board
from ghostball.validation.board.cell import cell_of, cell_of_likeness, shade
from ghostball.validation.board.column import COLUMNS, QUESTIONS


@pytest.mark.usefixtures("in_this_process")
def test_what_only_our_engine_says_is_right_has_no_class(tmp_path):
    _, outcome = run_board(["pymunk"], tmp_path, columns=[COLUMNS["two"]])
    (case,) = outcome.cases
    asked = COLUMNS["throw"]
    assert cell_of(asked, "pymunk", [case]).kind == "none"
    proved = dataclasses.replace(case, truth="certified")
    assert cell_of(asked, "pymunk", [proved]).kind == proved.accuracy.kind


def test_thresholds_shade():
    assert [shade(COLUMNS["break"], value) for value in (1e-4, 2e-4, 1e-2, 2e-2)] == [
        "good",
        "fair",
        "fair",
        "bad",
    ]
    assert shade(COLUMNS["time"], 1e9) == "fair"


def test_what_an_engine_lacks_is_beside_what_it_is_off():
    column = QUESTIONS["table"]
    part = cell_of_likeness(column, likeness("x", rebound="it has none", rolling=1.4))
    assert (part.kind, part.value) == ("partly", pytest.approx(1.4))
    assert part.note == "rolling 1.4; no rebound: it has none"
    failed = cell_of_likeness(column, likeness("x", rebound="it failed: it hung", rolling=1.4))
    assert (failed.kind, failed.value) == ("failed", None)
