"""The results folder: written case by case, read back to the bit, refused with a reason."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from stored_cases import SCENE, in_database, motion, record, taking_over, written

from ghostball.model import EVENT_DTYPE
from ghostball.validation.results.database import writing
from ghostball.validation.results.store import (
    CaseRecord,
    Check,
    Motion,
    Results,
    ResultsError,
    ResultsWriter,
    has_results,
)


def test_a_case_reads_back_to_the_bit(tmp_path: Path) -> None:
    full = record(
        settings={"dt": 1e-4, "contact_steps": "exact", "limit": None},
        status="t-max",
        reason="line\u2028separator, \x1b and \n",  # what an exception may say
        approximations=("rolling: by a joint",),
        truth="closed form",
        truth_positions=np.array([[0.1 + 0.2, 1 / 3, 5e-324]]),
        truth_rest_time=1 / 7,
        truth_counts={"ball-ball": 3},
        rest_positions=np.array([[np.nextafter(0.3, 1), -0.0, 1e300]]),
        ball_errors=np.array([2.0**-53]),
        rest_time=0.1,
        collision_counts={"ball-ball": 3, "ball-cushion": 0},
        energy_initial=0.1,
        energy_final=0.0,
        work={"steps": 10**12},
        wall_time=1e-5,
        metrics={"collision_count": 3, "rest_error_max": 2.0**-53, "energy_drift": None},
        notes={"energy_drift": "energy is lost"},
        checks=(Check("collision_count", 3, "equals", 3, "1", True, "by hand"),),
        left_out=("energy_rise",),
        measured="2026-01-02T03:04:05+00:00",
    )
    written(tmp_path, full)
    (read,) = Results.open(tmp_path).cases
    for part in fields(CaseRecord):
        before, after = getattr(full, part.name), getattr(read, part.name)
        if isinstance(before, np.ndarray):
            assert before.tobytes() == after.tobytes(), part.name
        else:
            assert before == after, part.name
    assert isinstance(read.metrics["collision_count"], int)
    assert read.load_scene() == SCENE


def test_a_motion_reads_back_to_the_bit(tmp_path: Path) -> None:
    written(tmp_path, record())
    folder = Results.open(tmp_path)
    read = folder.motion(folder.cases[0])
    assert read is not None
    for part in fields(Motion):
        assert getattr(read, part.name).tobytes() == getattr(motion(), part.name).tobytes()
    assert read.events.dtype == EVENT_DTYPE
    parts = (read.energy_translation, read.energy_rotation, read.energy_height)
    assert np.array_equal(read.energy, sum(parts))


def test_what_is_not_finite_reads_back_as_nan_or_none(tmp_path: Path) -> None:
    # The record must stay JSON: NaN and Infinity are not.
    blown = record(rest_positions=np.array([[np.nan, np.inf, 1.0]]), rest_time=float("inf"))
    written(tmp_path, blown)
    json.loads(in_database(tmp_path, "SELECT record FROM records"), parse_constant=pytest.fail)
    (read,) = Results.open(tmp_path).cases
    assert read.rest_positions is not None
    assert np.array_equal(np.isnan(read.rest_positions), [[True, True, False]])
    assert read.rest_time is None


def test_a_run_that_was_killed_reads_back(tmp_path: Path) -> None:
    # No finish(): what `write` returned from must be on disk already.
    writer = written(tmp_path, record(), finish=False)
    folder = Results.open(tmp_path)
    assert len(folder.cases) == 1
    assert folder.motion(folder.cases[0]) is not None
    assert folder.state == "running"
    writer.finish("interrupted")
    assert Results.open(tmp_path).state == "interrupted"


def test_a_folder_without_results_of_the_suite_says_so(tmp_path: Path) -> None:
    with writing(tmp_path), pytest.raises(ResultsError, match="holds no results of the suite"):
        Results.open(tmp_path)
    assert not has_results(tmp_path)
    assert ResultsWriter(tmp_path, "code").known() == (0, {})
    assert ResultsWriter(tmp_path / "missing", "code").known() == (0, {})


def test_a_damaged_motion_is_named(tmp_path: Path) -> None:
    written(tmp_path, record())
    folder = Results.open(tmp_path)
    in_database(tmp_path, "UPDATE motions SET content = substr(content, 1, 100)")
    with pytest.raises(ResultsError, match=r'the motion of `pymunk` in scene "roll" is damaged'):
        folder.motion(folder.cases[0])


def test_cases_that_are_reused_keep_their_motion(tmp_path: Path) -> None:
    writer = taking_over(tmp_path, "other code")
    writer.write((record("pymunk"), motion(7)))
    writer.finish("complete")
    folder = Results.open(tmp_path)
    assert [(case.label, case.reused) for case in folder.cases] == [
        ("ghostball", True),
        ("pymunk", False),
    ]
    kept, new = (folder.motion(case) for case in folder.cases)
    assert kept is not None
    assert new is not None
    assert np.array_equal(kept.positions, motion().positions)
    assert np.array_equal(new.positions, motion(7).positions)
    # Of the others nothing is left, not even in a table that no case points to.
    assert in_database(tmp_path, "SELECT count(*) FROM motions") == 2
    assert in_database(tmp_path, "SELECT count(*) FROM events") == 4
