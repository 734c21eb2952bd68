"""`regression.json`: written whole, read back equal, refused with a reason."""

from __future__ import annotations

import json
import re

import gate
import pytest

from validation.baselines.regression import (
    REGRESSION_FILE,
    Regression,
    TimeChange,
    Timing,
    load_regression,
    save_regression,
)
from validation.results.files import ResultsError

SHOT = gate.cut_shot()
BASE = gate.observed(SHOT)
OTHER = gate.cut_shot(1.01)
TIMING = Timing(median=1e-5, low=0.9e-5, high=1.1e-5, samples=15)
CHANGE = gate.compared(BASE, gate.observed(OTHER, like=SHOT), OTHER)
REGRESSION = Regression(
    against="baselines",
    base={"date": "2026-01-02"},
    head={"git": None, "versions": {"numba": "1"}},
    outcome="failed",
    scenes=(
        CHANGE.model_copy(update={"time": TimeChange(base=None, head=TIMING, words="no ratio")}),
        gate.compared(BASE, BASE, SHOT),
    ),
    stale=("gone",),
    warnings=("one",),
)


def test_a_comparison_reads_back_equal(tmp_path):
    save_regression(REGRESSION, tmp_path)
    assert load_regression(tmp_path) == REGRESSION
    assert [path.name for path in tmp_path.iterdir()] == [REGRESSION_FILE]
    written = json.loads((tmp_path / REGRESSION_FILE).read_text(encoding="utf-8"))
    assert (written["schema"], written["kind"]) == (2, "regression")
    assert CHANGE.first_difference is not None


def test_a_scene_is_found_by_its_name():
    assert REGRESSION.scene("cut") == REGRESSION.scenes[0]
    assert REGRESSION.scene("none") is None


def test_no_comparison_is_none(tmp_path):
    assert load_regression(tmp_path) is None


@pytest.mark.parametrize("part", [0.0, 0.5, 0.99])
def test_a_file_that_was_cut_short_is_refused(tmp_path, part):
    save_regression(REGRESSION, tmp_path)
    path = tmp_path / REGRESSION_FILE
    content = path.read_bytes()
    path.write_bytes(content[: int(part * len(content))])
    with pytest.raises(ResultsError, match=r"cut short.*Run `ghostball regress` again") as raised:
        load_regression(tmp_path)
    assert str(path) in str(raised.value)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("[]", "no comparison of ours"),
        ('{"schema": 1}', "`schema` must be 2, got 1"),
        ("{}", "`schema` must be 2, got None"),
        ('{"schema": 2}', "`against`"),
        ('{"schema": 2, "against": 3}', "`against`"),
    ],
)
def test_what_is_no_comparison_is_refused(tmp_path, content, said):
    (tmp_path / REGRESSION_FILE).write_text(content, encoding="utf-8")
    with pytest.raises(ResultsError, match=re.escape(said) + ".*again"):
        load_regression(tmp_path)


def test_what_is_no_text_is_refused(tmp_path):
    (tmp_path / REGRESSION_FILE).write_bytes(b"\xff")
    with pytest.raises(ResultsError, match="can't be read"):
        load_regression(tmp_path)


def test_what_cannot_be_written_leaves_the_earlier_one(tmp_path):
    save_regression(REGRESSION, tmp_path)
    (tmp_path / f"{REGRESSION_FILE}.part").mkdir()
    before = (tmp_path / REGRESSION_FILE).read_bytes()
    with pytest.raises(ResultsError, match="Choose another `--out`"):
        save_regression(REGRESSION, tmp_path)
    assert (tmp_path / REGRESSION_FILE).read_bytes() == before
