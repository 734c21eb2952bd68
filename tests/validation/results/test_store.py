"""The results folder: written case by case, read back to the bit, refused with a reason."""

from __future__ import annotations

import json
import re
import sqlite3
from dataclasses import fields, replace
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest

from ghostball.model import EVENT_DTYPE, Ball, Scene
from ghostball.validation.results.database import DATABASE, LOCK, writing
from ghostball.validation.results.store import (
    CaseRecord,
    Check,
    Motion,
    Results,
    ResultsError,
    ResultsWriter,
    has_results,
)

SCENE = Scene(name="roll", tags=("smoke",), balls=[Ball(id="cue", position=(0.1, 0.2))])
ENVIRONMENT = {"scenes": ["roll", "other"], "engines": ["pymunk", "ghostball"]}


def record(label: str = "pymunk", scene: str = "roll", **changes: Any) -> CaseRecord:
    blank = CaseRecord(
        scene=scene,
        title="One ball",
        tags=("smoke",),
        definition=SCENE.model_dump(mode="json", by_alias=True) | {"name": scene},
        label=label,
        engine=label.partition(":")[0],
        outcome="ran",
    )
    return replace(blank, **changes)


def motion(seed: int = 0) -> Motion:
    rng = np.random.default_rng(seed)
    events = np.array([(0.1 + 0.2, 0, 0, 1), (1.0, 3, 1, -1)], dtype=EVENT_DTYPE)
    states = [rng.normal(size=(4, 2, 3)) for _ in range(3)]
    energies = [rng.normal(size=4) for _ in range(3)]
    phases = rng.integers(0, 3, size=(4, 2), dtype=np.int8)
    return Motion(events, np.linspace(0, 1, 4), *states, *energies, phases)


def written(path: Path, *records: CaseRecord, finish: bool = True) -> ResultsWriter:
    writer = ResultsWriter(path)
    writer.begin(ENVIRONMENT)
    for item in records:
        writer.write((item, motion()))
    if finish:
        writer.finish("complete")
    return writer


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def in_database(folder: Path, query: str) -> Any:
    """Return what a query gives first, of the tables as anyone sees them."""
    database = sqlite3.connect(folder / DATABASE, isolation_level=None)
    try:
        return (database.execute(query).fetchone() or (None,))[0]
    finally:
        database.close()


# --- round trip


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


# --- interrupted, killed, damaged


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


# --- taking over a folder


def labels(cases: list[CaseRecord]) -> list[str]:
    return [case.label for case in cases]


def left(path: Path, code: str = "code") -> list[str]:
    """Return the labels of the cases that a next run may reuse."""
    return sorted(labels(list(ResultsWriter(path, code).known()[1].values())))


def taking_over(path: Path, code: str = "code") -> ResultsWriter:
    """Make a folder of three cases, and begin a run that reuses the second of them."""
    first = ResultsWriter(path, "code")
    first.begin(ENVIRONMENT)
    for label in ("pymunk", "ghostball", "pybullet"):
        first.write((record(label, status="rest"), motion()), f"inputs of {label}")
    first.finish("complete")
    writer = ResultsWriter(path, code)
    writer.begin(ENVIRONMENT, [("roll", "ghostball")])
    return writer


def test_earlier_results_stay_until_the_run_begins(tmp_path: Path) -> None:
    written(tmp_path, record(), record("ghostball"))
    (tmp_path / "report.html").write_text("drawn from them")
    before = contents(tmp_path)
    writer = ResultsWriter(tmp_path)
    assert contents(tmp_path) == before
    writer.begin(ENVIRONMENT)
    writer.write((record("pybullet"), motion()))
    writer.finish("complete")
    assert labels(Results.open(tmp_path).cases) == ["pybullet"]
    assert (tmp_path / "report.html").exists()  # not the store's to delete


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


def test_what_is_not_replaced_yet_is_kept_for_a_next_run(tmp_path: Path) -> None:
    writer = taking_over(tmp_path)
    assert left(tmp_path) == ["ghostball", "pybullet", "pymunk"]
    writer.write((record("pymunk"), motion(7)))
    writer.finish("interrupted")
    assert left(tmp_path) == ["ghostball", "pybullet"]
    assert labels(Results.open(tmp_path).cases) == ["ghostball", "pymunk"]


def test_a_whole_run_drops_what_its_code_could_never_take_over(tmp_path: Path) -> None:
    taking_over(tmp_path).finish("complete")
    assert left(tmp_path) == ["ghostball", "pybullet", "pymunk"]
    writer = ResultsWriter(tmp_path, "edited")
    writer.begin(ENVIRONMENT)
    writer.finish("complete")
    assert left(tmp_path) == []
    assert writer.known() == (0, {})


def test_what_would_not_come_again_is_kept_for_nobody(tmp_path: Path) -> None:
    writer = ResultsWriter(tmp_path, "code")
    writer.begin(ENVIRONMENT)
    writer.write((record("pymunk", outcome="failed"), None), "inputs")
    writer.write((record("pybullet", status="rest"), None))  # an engine whose code nobody knows
    writer.finish("complete")
    assert writer.known() == (0, {})


def test_a_full_disk_loses_nothing_that_was_there(tmp_path: Path) -> None:
    writer = taking_over(tmp_path)
    writer.write((record("pymunk"), motion(7)))
    assert writer._database is not None
    pages = in_database(tmp_path, "PRAGMA page_count")
    writer._database.execute(f"PRAGMA max_page_count = {pages}")
    with pytest.raises(ResultsError, match="database or disk is full"):  # noqa: PT012
        for seed in range(100):
            writer.write((record(f"pybullet:n={seed}"), motion(seed)))
    writer.finish("interrupted")
    assert labels(Results.open(tmp_path).cases)[:2] == ["ghostball", "pymunk"]
    assert left(tmp_path) == ["ghostball", "pybullet"]


# --- two runs at once


def test_two_writers_are_never_in_one_folder(tmp_path: Path) -> None:
    # Breaks where their lines interleave, and each deletes the other's motion.
    first = written(tmp_path, record(), finish=False)
    second = ResultsWriter(tmp_path)
    message = f"^{re.escape(str(tmp_path))}: another run writes there. Wait .* another `--out`$"
    with pytest.raises(ResultsError, match=message):
        second.begin(ENVIRONMENT)
    with pytest.raises(ResultsError, match="another run writes there"), second.reserved():
        pass
    second.finish("interrupted")
    first.write((record("ghostball"), motion()))
    first.finish("complete")
    assert labels(Results.open(tmp_path).cases) == ["pymunk", "ghostball"]
    written(tmp_path, record("pybullet"))
    assert labels(Results.open(tmp_path).cases) == ["pybullet"]


def test_a_reserved_folder_is_free_only_afterwards(tmp_path: Path) -> None:
    writer, other = ResultsWriter(tmp_path), ResultsWriter(tmp_path)  # a lock alone is no content
    with writer.reserved():
        writer.begin(ENVIRONMENT)
        writer.finish("complete")
        with pytest.raises(ResultsError, match="another run writes there"):
            other.begin(ENVIRONMENT)
    other.begin(ENVIRONMENT)
    other.finish("complete")
    with pytest.raises(ZeroDivisionError), writer.reserved():
        raise ZeroDivisionError
    written(tmp_path)


def test_a_run_that_is_killed_as_it_begins_leaves_the_folder_ours(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as killed:
        killed.setattr(Path, "unlink", Mock(side_effect=KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            ResultsWriter(tmp_path)
    assert contents(tmp_path)  # what it tried the folder with
    written(tmp_path, record())
    assert set(contents(tmp_path)) - {LOCK} == {DATABASE}


def test_a_folder_that_is_not_ours_is_refused_and_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    before = contents(tmp_path)
    with pytest.raises(ResultsError, match="not empty and not a results folder"):
        ResultsWriter(tmp_path)
    assert contents(tmp_path) == before


def test_a_file_in_the_way_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "out"
    path.write_text("")
    with pytest.raises(ResultsError, match="not a folder"):
        ResultsWriter(path)
    with pytest.raises(ResultsError, match="can't write the results folder"):
        ResultsWriter(path / "below")


def test_a_folder_that_refuses_files_is_found_out_before_the_run(tmp_path: Path) -> None:
    # /proc takes no files from anyone, root included.
    if not Path("/proc/self").exists():
        pytest.skip("no /proc here")
    with pytest.raises(ResultsError, match="can't write the results folder"):
        ResultsWriter("/proc/ghostball-results")
