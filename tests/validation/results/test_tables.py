"""Tables for other programs: JSON lines, CSV and data frames have equal values, to the bit."""

from __future__ import annotations

import csv
import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from stored_records import record

from ghostball.model import EVENT_DTYPE, Ball, GhostballError, Scene
from ghostball.validation.results.comparisons import Comparisons, comparison_row, comparisons_of
from ghostball.validation.results.database import transaction, writing
from ghostball.validation.results.files import ResultsError
from ghostball.validation.results.records import CERTIFIED, OUR_ENGINE
from ghostball.validation.results.store import Check, Motion, Results, ResultsWriter
from ghostball.validation.results.tables import TABLES, export, rows_of
from ghostball.validation.scenes.library import find_scene

# Rest positions, collisions and energy of a case compared with the reference, for all outputs.


HEAD_ON = find_scene("head-on")
CASE = record(
    "mine:Engine",
    HEAD_ON,
    truth=CERTIFIED,
    truth_counts={"ball-ball": 1, "ball-cushion": 0},
    collision_counts={"ball-ball": 1, "ball-cushion": 2},
    ball_errors=np.array([0.001, 0.003]),
    metrics={"rest_error_max": 0.003, "energy_difference_max": 0.25, "energy_difference_time": 1.5},
)


def test_the_three_comparisons_name_the_ball_the_counts_and_the_moment() -> None:
    assert comparisons_of(CASE) == Comparisons(
        rest_error=0.003,
        rest_ball="object",
        counts={"ball-ball": (1, 1), "ball-cushion": (2, 0)},
        energy_difference=0.25,
        energy_time=1.5,
    )


def test_a_row_holds_plain_values_by_column() -> None:
    assert comparison_row(CASE) == {
        "scene": "head-on",
        "label": "mine:Engine",
        "rest_error": 0.003,
        "rest_ball": "object",
        "ball_ball_count": 1,
        "ball_ball_count_true": 1,
        "ball_cushion_count": 2,
        "ball_cushion_count_true": 0,
        "energy_difference": 0.25,
        "energy_difference_time": 1.5,
    }


def test_a_case_that_did_not_run_has_none() -> None:
    lacking = replace(CASE, outcome="not-representable")
    assert comparisons_of(lacking) is None
    assert comparison_row(lacking) == {}


def test_our_engine_is_not_compared_with_itself() -> None:
    ours = replace(CASE, engine="ghostball", truth=OUR_ENGINE)
    nothing = {"ball-ball": (1, None), "ball-cushion": (2, None)}
    assert comparisons_of(ours) == Comparisons(None, None, nothing, None, None)


def test_what_was_not_measured_has_no_value() -> None:
    past = replace(CASE, metrics={"rest_error_max": None}, ball_errors=None, truth_counts=None)
    nothing = {"ball-ball": (1, None), "ball-cushion": (2, None)}
    assert comparisons_of(past) == Comparisons(None, None, nothing, None, None)


# The tables of a folder as JSON lines, CSV and data frames.


SCENE = Scene(name="roll", title="größer, |", balls=[Ball(id="cue", position=(0.1, 0.2))])
PASSED = Check("rest_error_max", 2.0**-53, "at_most", 1e-13, "m", True, "by hand")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    writer = ResultsWriter(tmp_path / "out")
    writer.begin({"scenes": ["roll"], "engines": ["ghostball", "pymunk"]})
    events = np.array([(0.1 + 0.2, 0, 0, 1), (1.0, 3, 1, -1)], dtype=EVENT_DTYPE)
    still = np.zeros((1, 1, 3))
    motion = Motion(events, np.zeros(1), still, still, still, *np.zeros((3, 1)))
    failed = replace(PASSED, value=None, passed=None)
    writer.write((record("ghostball", SCENE, checks=(PASSED, failed), rest_time=0.1 + 0.2), motion))
    writer.write((record("pymunk", SCENE, outcome="failed", metrics={"overlap_max": None}), None))
    writer.finish("complete")
    return writer.path


def test_rows_are_what_was_found(folder: Path) -> None:
    ghostball, pymunk = rows_of(folder, "cases")
    assert (ghostball["scene"], ghostball["label"], pymunk["outcome"]) == (
        "roll",
        "ghostball",
        "failed",
    )
    assert ghostball["rest_time"] == 0.1 + 0.2
    assert ghostball["definition"]["name"] == "roll"
    first, second = rows_of(folder, "checks")
    assert (first["label"], first["value"], first["passed"]) == ("ghostball", 2.0**-53, True)
    assert (second["value"], second["passed"]) == (None, None)
    assert rows_of(folder, "metrics") == [
        {"scene": "roll", "label": "pymunk", "name": "overlap_max", "value": None}
    ]
    shared = {"scene": "roll", "label": "ghostball"}
    assert rows_of(folder, "events") == [
        {**shared, "t": 0.1 + 0.2, "kind": "ball-ball", "a": 0, "b": 1},
        {**shared, "t": 1.0, "kind": "roll-to-rest", "a": 1, "b": -1},
    ]


def test_cases_that_are_only_kept_for_a_next_run_are_in_no_table(folder: Path) -> None:
    writer = ResultsWriter(folder)
    writer.begin({}, [("roll", "pymunk")])
    writer.finish("complete")
    assert [row["label"] for row in rows_of(folder, "cases")] == ["pymunk"]
    assert rows_of(folder, "cases")[0]["reused"] == 1
    assert rows_of(folder, "checks") == rows_of(folder, "events") == []
    assert [row["label"] for row in rows_of(folder, "metrics")] == ["pymunk"]


def test_files_hold_every_row(folder: Path, tmp_path: Path) -> None:
    target = tmp_path / "below" / "files"
    written = export(folder, target)
    assert sorted(path.name for path in written) == sorted(
        f"{table}.{ending}"
        for table in ("cases", "checks", "comparisons", "metrics", "events")
        for ending in ("csv", "jsonl")
    )
    for table in ("cases", "checks", "comparisons", "metrics", "events"):
        lines = (target / f"{table}.jsonl").read_text(encoding="utf-8").splitlines()
        assert [json.loads(line) for line in lines] == rows_of(folder, table)
        with (target / f"{table}.csv").open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        assert len(rows) == len(lines)
        assert rows[0]["scene"] == "roll"
    assert float(rows[0]["t"]) == 0.1 + 0.2


def test_what_cannot_be_exported_is_said(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(GhostballError, match=r"no table `motion`\. The tables are: cases, metrics"):
        rows_of(folder, "motion")
    with pytest.raises(ResultsError, match="no such results folder"):
        export(tmp_path / "none", tmp_path / "files")
    with writing(tmp_path) as database, transaction(database):
        pass
    with pytest.raises(ResultsError, match="contains nothing to export"):
        export(tmp_path, tmp_path / "files")
    (tmp_path / "files").write_text("in the way")
    with pytest.raises(ResultsError, match=r"files: can't be written: File exists\. Choose"):
        export(folder, tmp_path / "files")


def test_a_frame_has_a_column_for_each_value(folder: Path) -> None:
    polars = pytest.importorskip("polars")
    results = Results.open(folder)
    assert list(TABLES)[:4] == ["cases", "metrics", "checks", "events"]
    for table in ("cases", "metrics", "checks", "events"):
        frame = results.to_frame(table)
        assert isinstance(frame, polars.DataFrame)
        assert frame.height == len(rows_of(folder, table))
    assert results.to_frame("events")["t"].to_list() == [0.1 + 0.2, 1.0]
    cases = results.to_frame()
    assert cases["rest_time"].to_list() == [0.1 + 0.2, None]
    assert json.loads(cases["definition"][0])["name"] == "roll"  # a cell holds one value


def test_without_polars_it_is_said_how_to_install_it(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "polars", None)
    wanted = r"needs polars.*pip install '\.\[frames\]'.*`ghostball report DIR --export"
    with pytest.raises(GhostballError, match=wanted):
        Results.open(folder).to_frame()
