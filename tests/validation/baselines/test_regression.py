"""A stored comparison reads back equal, and a damaged one is refused with a reason."""

from __future__ import annotations

import json

import gate
import pytest

from ghostball.validation.baselines.regression import (
    Regression,
    load_regression,
    load_regressions,
    save_regressions,
)
from ghostball.validation.results.database import put_document, transaction, writing
from ghostball.validation.results.files import ResultsError
from ghostball.validation.results.tables import rows_of

SHOT = gate.cut_shot()
BASE = gate.played(SHOT)
OTHER = gate.cut_shot(1.01)
CHANGE = gate.compared(BASE, gate.played(OTHER, like=SHOT), OTHER)
REGRESSION = Regression(
    head={"git": None, "versions": {"numba": "1"}},
    outcome="failed",
    scenes=(CHANGE, gate.compared(BASE, BASE, SHOT)),
    warnings=("one",),
)


def test_a_comparison_reads_back_equal(tmp_path):
    save_regressions([REGRESSION], tmp_path)
    assert load_regression(tmp_path) == REGRESSION
    printed = json.loads(REGRESSION.model_dump_json(by_alias=True))
    assert (printed["schema"], printed["kind"]) == (12, "regression")
    assert [row["scene"] for row in rows_of(tmp_path, "changes")] == ["cut", "cut"]
    assert CHANGE.first_difference is not None


def test_each_engine_has_its_own(tmp_path):
    mine = REGRESSION.model_copy(update={"engine": "mine", "outcome": "passed"})
    save_regressions([mine, REGRESSION], tmp_path)
    assert load_regressions(tmp_path) == [mine, REGRESSION]
    assert load_regression(tmp_path) == REGRESSION, "what fails is shown first"
    assert load_regression(tmp_path, "mine") == mine
    assert load_regression(tmp_path, "none") is None


def test_a_scene_is_found_by_its_name():
    assert REGRESSION.scene("cut") == REGRESSION.scenes[0]
    assert REGRESSION.scene("none") is None


def test_no_comparison_is_none(tmp_path):
    assert load_regression(tmp_path) is None
    with writing(tmp_path):
        assert load_regression(tmp_path) is None


def test_what_somebody_edited_is_refused(tmp_path):
    with writing(tmp_path) as database, transaction(database):
        put_document(database, "regression", '[{"schema": 12, "outcome": 3}]')
    with pytest.raises(ResultsError, match=r"its comparison is damaged: `\[0\]\.head` is missing"):
        load_regression(tmp_path)
