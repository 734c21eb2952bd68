"""A comparison that is kept: reads back equal, refused with a reason."""

from __future__ import annotations

import json

import gate
import pytest

from ghostball.validation.baselines.regression import (
    Regression,
    TimeChange,
    Timing,
    load_regression,
    save_regression,
)
from ghostball.validation.results.database import put_document, transaction, writing
from ghostball.validation.results.files import ResultsError
from ghostball.validation.results.frames import rows_of

SHOT = gate.cut_shot()
BASE = gate.observed(SHOT)
OTHER = gate.cut_shot(1.01)
TIMING = Timing(median=1e-5, low=0.9e-5, high=1.1e-5, samples=15)
TIMES = TimeChange(base=TIMING, head=TIMING, ratio=1.0, ratio_low=0.9, ratio_high=1.1)
CHANGE = gate.compared(BASE, gate.observed(OTHER, like=SHOT), OTHER)
REGRESSION = Regression(
    against="baselines",
    base={"date": "2026-01-02"},
    head={"git": None, "versions": {"numba": "1"}},
    outcome="failed",
    scenes=(
        CHANGE.model_copy(update={"time": TIMES}),
        gate.compared(BASE, BASE, SHOT),
    ),
    stale=("gone",),
    warnings=("one",),
)


def test_a_comparison_reads_back_equal(tmp_path):
    save_regression(REGRESSION, tmp_path)
    assert load_regression(tmp_path) == REGRESSION
    printed = json.loads(REGRESSION.model_dump_json(by_alias=True))
    assert (printed["schema"], printed["kind"]) == (5, "regression")
    assert [row["scene"] for row in rows_of(tmp_path, "changes")] == ["cut", "cut"]
    assert CHANGE.first_difference is not None


def test_a_scene_is_found_by_its_name():
    assert REGRESSION.scene("cut") == REGRESSION.scenes[0]
    assert REGRESSION.scene("none") is None


def test_no_comparison_is_none(tmp_path):
    assert load_regression(tmp_path) is None
    with writing(tmp_path):
        assert load_regression(tmp_path) is None


def test_what_somebody_edited_is_refused(tmp_path):
    with writing(tmp_path) as database, transaction(database):
        put_document(database, "regression", '{"schema": 5, "against": 3}')
    with pytest.raises(ResultsError, match="its comparison is damaged: `against` must be"):
        load_regression(tmp_path)
