"""Records of cases: whatever is in them reads back, to the bit."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from stored_cases import SCENE, in_database, record, written

from ghostball.validation.results.store import (
    CaseRecord,
    Check,
    Results,
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


def test_what_is_not_finite_reads_back_as_nan_or_none(tmp_path: Path) -> None:
    # The record must stay JSON: NaN and Infinity are not.
    blown = record(rest_positions=np.array([[np.nan, np.inf, 1.0]]), rest_time=float("inf"))
    written(tmp_path, blown)
    json.loads(in_database(tmp_path, "SELECT record FROM records"), parse_constant=pytest.fail)
    (read,) = Results.open(tmp_path).cases
    assert read.rest_positions is not None
    assert np.array_equal(np.isnan(read.rest_positions), [[True, True, False]])
    assert read.rest_time is None
