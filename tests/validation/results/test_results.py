from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from pydantic import ConfigDict, TypeAdapter, ValidationError
from stored_records import SCENE, damage_motions, in_database, motion, record, taking_over, written

from ghostball.model import EVENT_DTYPE
from ghostball.reference_adapters.javascript import packages as javascript
from ghostball.reference_adapters.workers.process import DISTRIBUTIONS
from ghostball.validation.parallel.sources import PACKAGES
from ghostball.validation.results.database import writing
from ghostball.validation.results.environment import describe_environment, git_state
from ghostball.validation.results.fields import (
    Definition,
    EnvironmentValues,
    StoredArray,
    check_shape,
)
from ghostball.validation.results.measurement import Measurement, MeasurementError, make_folder
from ghostball.validation.results.store import (
    CaseRecord,
    Check,
    Motion,
    Results,
    ResultsError,
    ResultsWriter,
    has_results,
)

# The description of machine and revision


def test_the_description_is_plain_and_complete() -> None:
    described = json.loads(json.dumps(describe_environment()))
    assert set(described) == {
        *("date", "command", "cpu", "cores", "os", "python", "versions", "git")
    }
    assert list(described["versions"]) == [
        *PACKAGES,
        *DISTRIBUTIONS,
        javascript.NODE,
        *javascript.PACKAGES,
    ]
    assert described["versions"]["numpy"]
    assert described["cpu"]


def test_a_folder_inside_a_repository_is_not_that_repository(tmp_path: Path) -> None:
    # Otherwise a package in a virtual environment would report the revision of the project around
    # it.
    git(tmp_path, "init", "--quiet")
    inside = tmp_path / "site-packages"
    inside.mkdir()
    assert git_state(inside) is None
    assert git_state(tmp_path) is None  # no commit yet


def test_changes_make_a_checkout_dirty(tmp_path: Path) -> None:
    git(tmp_path, "init", "--quiet")
    git(tmp_path, "-c", "user.name=a", "-c", "user.email=a@b", "commit", "--allow-empty", "-mx")
    clean = git_state(tmp_path)
    assert clean is not None
    assert len(clean["revision"]) == 40
    assert clean["dirty"] is False
    (tmp_path / "new").write_text("")
    assert git_state(tmp_path) == {"revision": clean["revision"], "dirty": True}


def git(folder: Path, *arguments: str) -> None:
    subprocess.run(["git", "-C", str(folder), *arguments], check=True, capture_output=True)


# Stored fields: floats read back to the bit, and damaged fields are refused


@dataclass
class Held:
    places: StoredArray
    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)


HELD = TypeAdapter(Held)


def test_an_array_reads_back_to_the_bit_and_null_is_not_finite():
    places = np.array([[0.1 + 0.2, -0.0], [5e-324, np.inf]])
    found = HELD.validate_json(HELD.dump_json(Held(places))).places
    assert np.isnan(found[1, 1])
    found[1, 1] = np.inf
    assert found.tobytes() == places.tobytes()


@pytest.mark.parametrize("damaged", ["[[1, 2], [3]]", '["x"]', "{}"])
def test_what_is_no_array_is_refused(damaged):
    with pytest.raises(ValidationError, match="must be numbers in rows of one length"):
        HELD.validate_json(f'{{"places": {damaged}}}')


def test_another_shape_is_refused_by_name():
    check_shape("rests", None, (2, 3))
    with pytest.raises(ValueError, match=r"`rests` must have the shape \(2, 3\), got \(3, 2\)"):
        check_shape("rests", np.zeros((3, 2)), (2, 3))


def test_a_definition_must_be_a_scene():
    plain = SCENE.model_dump(mode="json", by_alias=True)
    assert TypeAdapter(Definition).validate_python(plain) == plain
    with pytest.raises(ValidationError, match=r"must be a scene: .*`t_max`"):
        TypeAdapter(Definition).validate_python(plain | {"t_max": -1.0})


def test_an_environment_may_say_more_but_nothing_else():
    adapter = TypeAdapter(EnvironmentValues)
    assert adapter.validate_python({"cpu": "any", "more": 1}) == {"cpu": "any", "more": 1}
    with pytest.raises(ValidationError, match=r"git\.revision"):
        adapter.validate_python({"git": {"dirty": False}})


# Measurements read back, are written completely, and other files are refused


class Counted(Measurement):
    kind: Literal["counted"] = "counted"
    rows: tuple[float, ...]
    names: tuple[str, ...] = ()


class Timed(Measurement):
    kind: Literal["timed"] = "timed"


MEASURED = Counted(rows=(1e-5, 2e-5))


def test_a_measurement_reads_back_and_has_a_row_per_line(tmp_path):
    path = MEASURED.save(tmp_path / "made")
    assert Counted.load(path) == MEASURED
    assert path.name == "counted.json"
    assert '"rows": [\n    1e-05,\n    2e-05\n  ],\n  "names": []' in path.read_text()


def test_another_kind_or_damage_is_refused_by_name(tmp_path):
    path = MEASURED.save(tmp_path)
    with pytest.raises(MeasurementError, match=r"counted.json: `kind`"):
        Timed.load(path)
    path.write_text(path.read_text()[:-20])
    with pytest.raises(MeasurementError, match="Invalid JSON"):
        Counted.load(path)
    with pytest.raises(MeasurementError, match="can't read"):
        Counted.load(tmp_path / "nowhere.json")


def test_a_folder_that_cannot_be_written_is_an_error(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(ResultsError, match="can't be written"):
        MEASURED.save(tmp_path / "file")
    with pytest.raises(MeasurementError, match="can't create the folder"):
        make_folder(tmp_path / "file")


# Motions of cases read back to the bit; a damaged motion is named


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


def test_a_damaged_motion_is_named(tmp_path: Path) -> None:
    written(tmp_path, record())
    folder = Results.open(tmp_path)
    damage_motions(tmp_path)
    with pytest.raises(ResultsError, match=r'the motion of `pymunk` in scene "roll" is damaged'):
        folder.motion(folder.cases[0])


def test_a_case_reads_back_to_the_bit(tmp_path: Path) -> None:
    full = record(
        settings={"dt": 1e-4, "contact_steps": "exact", "limit": None},
        status="t-max",
        reason="line\u2028separator, \x1b and \n",  # an exception may contain these characters
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
    # The record must be valid JSON, which has no NaN or Infinity.
    blown = record(rest_positions=np.array([[np.nan, np.inf, 1.0]]), rest_time=float("inf"))
    written(tmp_path, blown)
    json.loads(in_database(tmp_path, "SELECT record FROM records"), parse_constant=pytest.fail)
    (read,) = Results.open(tmp_path).cases
    assert read.rest_positions is not None
    assert np.array_equal(np.isnan(read.rest_positions), [[True, True, False]])
    assert read.rest_time is None


# The results folder is written case by case and reads back to the bit


def test_a_run_that_was_killed_reads_back(tmp_path: Path) -> None:
    # Without `finish`: after `write` returns, the case must be on the disk.
    writer = written(tmp_path, record(), finish=False)
    folder = Results.open(tmp_path)
    assert len(folder.cases) == 1
    assert folder.motion(folder.cases[0]) is not None
    assert folder.state == "running"
    writer.finish("interrupted")
    assert Results.open(tmp_path).state == "interrupted"


def test_a_folder_without_results_of_the_suite_says_so(tmp_path: Path) -> None:
    with writing(tmp_path), pytest.raises(ResultsError, match="contains no results"):
        Results.open(tmp_path)
    assert not has_results(tmp_path)
    assert ResultsWriter(tmp_path, "code").known() == (0, {})
    assert ResultsWriter(tmp_path / "missing", "code").known() == (0, {})


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
    # Nothing else is left, not even in tables without a reference to a case.
    assert in_database(tmp_path, "SELECT count(*) FROM motions") == 2
    assert in_database(tmp_path, "SELECT count(*) FROM events") == 4
