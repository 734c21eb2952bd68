"""The results folder: written case by case, read back to the bit, refused with a reason."""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
import threading
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import validation.results.store
from engine import EVENT_DTYPE, Ball, GhostballError, Scene
from validation.results.files import EARLIER_FILE, ENVIRONMENT_FILE, LOCK_FILE, RESULTS_FILE
from validation.results.store import (
    SCHEMA,
    CaseRecord,
    Check,
    Motion,
    Results,
    ResultsError,
    ResultsWriter,
    read_earlier,
)

SCENE = Scene(name="roll", tags=("smoke",), balls=[Ball(id="cue", position=(0.1, 0.2))])
ENVIRONMENT = {"scenes": ["roll", "other"], "engines": ["pymunk", "ghostball"]}


def record(label: str = "pymunk", scene: str = "roll", **changes: Any) -> CaseRecord:
    blank = CaseRecord(
        scene=scene,
        title="One ball",
        tags=("smoke",),
        definition=SCENE.model_dump(mode="json", by_alias=True),
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
        writer.write(item, motion())
    if finish:
        writer.finish("complete")
    return writer


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


# --- round trip


def test_a_case_reads_back_to_the_bit(tmp_path: Path) -> None:
    full = record(
        settings={"dt": 1e-4, "mode": "landed", "limit": None},
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
        taken_over=True,
        inputs_hash="12",
        code_hash="34",
    )
    written(tmp_path, full)
    (read,) = Results.open(tmp_path).cases
    for part in fields(CaseRecord):
        before, after = getattr(full, part.name), getattr(read, part.name)
        if part.name == "motion":
            assert after == "motion/roll--pymunk.npz"
        elif part.name == "motion_hash":
            content = (tmp_path / "motion/roll--pymunk.npz").read_bytes()
            assert after == hashlib.sha256(content).hexdigest()
        elif isinstance(before, np.ndarray):
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
    # The line must stay JSON: NaN and Infinity are not.
    blown = record(rest_positions=np.array([[np.nan, np.inf, 1.0]]), rest_time=float("inf"))
    written(tmp_path, blown)
    json.loads((tmp_path / RESULTS_FILE).read_text(), parse_constant=pytest.fail)
    (read,) = Results.open(tmp_path).cases
    assert read.rest_positions is not None
    assert np.array_equal(np.isnan(read.rest_positions), [[True, True, False]])
    assert read.rest_time is None


def test_names_come_in_the_order_asked_for(tmp_path: Path) -> None:
    written(tmp_path, record("ghostball", "other"), record("pymunk", "roll"))
    folder = Results.open(tmp_path)
    assert folder.scene_names == ["roll", "other"]
    assert folder.labels == ["pymunk", "ghostball"]
    assert folder.case("roll", "pymunk") is folder.cases[1]
    assert folder.case("roll", "ghostball") is None
    assert folder.state == "complete"


def test_labels_that_look_alike_in_a_file_name_keep_their_own_motion(tmp_path: Path) -> None:
    writer = ResultsWriter(tmp_path)
    writer.begin(ENVIRONMENT)
    writer.write(record("a:b=1"), motion(1))
    writer.write(record("a-b-1"), motion(2))
    writer.finish("complete")
    folder = Results.open(tmp_path)
    first, second = (folder.motion(case) for case in folder.cases)
    assert first is not None
    assert second is not None
    assert np.array_equal(first.positions, motion(1).positions)
    assert np.array_equal(second.positions, motion(2).positions)


def test_a_motion_without_phases_reads_back(tmp_path: Path) -> None:
    # As engines that record frames store it, and versions that knew no phases did.
    writer = ResultsWriter(tmp_path)
    writer.begin(ENVIRONMENT)
    writer.write(record(), replace(motion(), phases=None))
    writer.finish("complete")
    folder = Results.open(tmp_path)
    read = folder.motion(folder.cases[0])
    assert read is not None
    assert read.phases is None
    assert np.array_equal(read.positions, motion().positions)


def test_a_case_without_motion_has_none(tmp_path: Path) -> None:
    writer = ResultsWriter(tmp_path)
    writer.begin(ENVIRONMENT)
    writer.write(record(outcome="failed"), None)
    writer.finish("complete")
    folder = Results.open(tmp_path)
    assert folder.motion(folder.cases[0]) is None


@pytest.mark.parametrize(
    ("verdicts", "passed"),
    [([], None), ([None], None), ([True, None], True), ([True, False, None], False)],
)
def test_a_case_passes_where_all_its_verdicts_do(
    verdicts: list[bool | None], passed: bool | None
) -> None:
    checks = tuple(Check("m", 1, "at_most", 1, "m", verdict, "r") for verdict in verdicts)
    assert record(checks=checks).passed is passed


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


@pytest.mark.parametrize("cut", [1, 40])
def test_a_last_line_that_is_cut_short_is_left_out_and_named(tmp_path: Path, cut: int) -> None:
    # Also where only the line's end is missing: the JSON alone would still parse.
    written(tmp_path, record(), record("ghostball"))
    path = tmp_path / RESULTS_FILE
    path.write_bytes(path.read_bytes()[:-cut])
    folder = Results.open(tmp_path)
    assert [case.label for case in folder.cases] == ["pymunk"]
    assert folder.cut_short == f"{path}:2"
    assert folder.state == "killed"


def test_a_line_cut_short_elsewhere_or_within_a_character(tmp_path: Path) -> None:
    written(tmp_path, record(), record("ghostball"))
    path = tmp_path / RESULTS_FILE
    whole = path.read_bytes()
    path.write_bytes(whole + "µ".encode()[:1])
    assert len(Results.open(tmp_path).cases) == 2
    first, second = whole.splitlines()
    path.write_bytes(first[:-40] + b"\n" + second + b"\n")
    with pytest.raises(ResultsError, match=r"results\.jsonl:1: not valid JSON"):
        Results.open(tmp_path)


@pytest.mark.parametrize("left", [0, 30])
def test_an_environment_that_is_cut_short_is_said_to_be(tmp_path: Path, left: int) -> None:
    written(tmp_path, record())
    path = tmp_path / ENVIRONMENT_FILE
    path.write_bytes(path.read_bytes()[:left])
    with pytest.raises(ResultsError, match=r"env\.json: is cut short"):
        Results.open(tmp_path)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("{broken", r"results\.jsonl:2: not valid JSON"),
        ("[1]", r"results\.jsonl:2: a JSON object was expected"),
        ("", r"results\.jsonl:2: not valid JSON"),
        (f'{{"schema": {SCHEMA + 1}}}', r"results\.jsonl:2: `schema` must be 4, got 5"),
        (f'{{"schema": {SCHEMA}}}', r"results\.jsonl:2: `scene` is missing"),
    ],
)
def test_a_damaged_line_is_named(tmp_path: Path, line: str, message: str) -> None:
    written(tmp_path, record())
    with (tmp_path / RESULTS_FILE).open("a") as file:
        file.write(line + "\n")
    with pytest.raises(ResultsError, match=message):
        Results.open(tmp_path)


@pytest.mark.parametrize(
    ("change", "message"),
    [({"schema": 99}, "`schema` must be 4, got 99"), ({"format": "x"}, "not a results folder")],
)
def test_another_folder_is_refused(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    written(tmp_path, record())
    path = tmp_path / ENVIRONMENT_FILE
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(ResultsError, match=message):
        Results.open(tmp_path)


def test_what_is_missing_is_said(tmp_path: Path) -> None:
    with pytest.raises(ResultsError, match="no such results folder"):
        Results.open(tmp_path / "none")
    with pytest.raises(ResultsError, match="not a results folder"):
        Results.open(tmp_path)
    written(tmp_path / "out", record())
    (tmp_path / "out" / RESULTS_FILE).unlink()
    with pytest.raises(ResultsError, match="missing"):
        Results.open(tmp_path / "out")


def test_a_damaged_motion_is_named(tmp_path: Path) -> None:
    written(tmp_path, record())
    folder = Results.open(tmp_path)
    path = tmp_path / str(folder.cases[0].motion)
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(ResultsError, match=r"roll--pymunk\.npz: can't read the motion of `pymunk`"):
        folder.motion(folder.cases[0])


# --- taking over a folder


def test_earlier_results_stay_until_the_run_begins(tmp_path: Path) -> None:
    written(tmp_path, record(), record("ghostball"))
    (tmp_path / "report.md").write_text("drawn from them")
    before = contents(tmp_path)
    writer = ResultsWriter(tmp_path)
    assert contents(tmp_path) == before
    writer.begin(ENVIRONMENT)
    writer.write(record("pybullet"), motion())
    writer.finish("complete")
    folder = Results.open(tmp_path)
    assert [case.label for case in folder.cases] == ["pybullet"]
    assert [path.name for path in (tmp_path / "motion").iterdir()] == ["roll--pybullet.npz"]
    assert (tmp_path / "report.md").exists()  # not the store's to delete


def labels(cases: list[CaseRecord]) -> list[str]:
    return [case.label for case in cases]


def taking_over(path: Path) -> ResultsWriter:
    """Make a folder of three cases, and a writer that will take over the second of them."""
    written(path, record("pymunk"), record("ghostball"), record("pybullet"))
    return ResultsWriter(path)


def begin(writer: ResultsWriter) -> None:
    earlier = read_earlier(writer.path)
    writer.begin(ENVIRONMENT, taken_over=[replace(earlier[1], taken_over=True)], earlier=earlier)


def all_motions_read(path: Path) -> bool:
    folder = Results(path, [], {})
    return all(folder.motion(case) is not None for case in read_earlier(path))


def test_cases_that_are_taken_over_come_first_and_keep_their_motion(tmp_path: Path) -> None:
    writer = taking_over(tmp_path)
    begin(writer)
    writer.write(record("pymunk"), motion(7))
    writer.finish("complete", still_of_use=lambda case: False)
    folder = Results.open(tmp_path)
    assert [(case.label, case.taken_over) for case in folder.cases] == [
        ("ghostball", True),
        ("pymunk", False),
    ]
    kept, new = (folder.motion(case) for case in folder.cases)
    assert kept is not None
    assert new is not None
    assert np.array_equal(kept.positions, motion().positions)
    assert np.array_equal(new.positions, motion(7).positions)
    assert sorted(path.name for path in (tmp_path / "motion").iterdir()) == [
        "roll--ghostball.npz",
        "roll--pymunk-2.npz",
    ]
    assert not (tmp_path / EARLIER_FILE).exists()


def test_a_run_that_is_killed_leaves_earlier_cases_with_their_own_motion(tmp_path: Path) -> None:
    # Breaks where a new motion takes the place of an earlier one before its line is there.
    writer = taking_over(tmp_path)
    begin(writer)
    writer.write(record("pymunk"), motion(7))
    results = tmp_path / RESULTS_FILE
    results.write_bytes(results.read_bytes()[:-9])  # killed in the midst of that line
    left = read_earlier(tmp_path)
    assert labels(left) == ["pymunk", "ghostball", "pybullet", "ghostball"]
    assert all_motions_read(tmp_path)
    read = Results(tmp_path, [], {}).motion(left[0])
    assert read is not None
    assert np.array_equal(read.positions, motion().positions)
    writer.finish("interrupted")


@pytest.mark.parametrize("state", ["interrupted", "complete"])
def test_what_is_not_replaced_stays_put_by_if_it_is_of_use(tmp_path: Path, state: str) -> None:
    writer = taking_over(tmp_path)
    begin(writer)
    if state == "complete":
        writer.finish("complete", still_of_use=lambda case: case.label == "pybullet")
    else:
        writer.write(record("pymunk"), motion(7))
        writer.finish("interrupted")
    assert labels(Results.open(tmp_path).cases)[0] == "ghostball"
    assert labels(read_earlier(tmp_path))[0] == "pybullet"
    assert sum(label == "pymunk" for label in labels(read_earlier(tmp_path))) == (
        state == "interrupted"
    )
    assert all_motions_read(tmp_path)


@pytest.mark.parametrize("step", range(5))
def test_a_full_disk_while_a_run_begins_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: int
) -> None:
    writer = taking_over(tmp_path)
    earlier = read_earlier(tmp_path)
    steps = 0

    def failing(real: Any) -> Any:
        def call(*given: Any) -> Any:
            nonlocal steps
            steps += 1
            if steps == step + 1:
                raise OSError(28, "No space left on device")
            return real(*given)

        return call

    with monkeypatch.context() as full:
        full.setattr(
            validation.results.store, "write_lines", failing(validation.results.store.write_lines)
        )
        for name in ("_put_by", "_write_environment", "_drop_motion"):
            full.setattr(ResultsWriter, name, failing(getattr(ResultsWriter, name)))
        with pytest.raises(ResultsError, match="No space left"):
            writer.begin(ENVIRONMENT, taken_over=earlier[1:2], earlier=earlier)
    assert steps == step + 1
    assert set(labels(read_earlier(tmp_path))) == {"pymunk", "ghostball", "pybullet"}
    assert all_motions_read(tmp_path)


# --- two runs at once


def test_two_writers_are_never_in_one_folder(tmp_path: Path) -> None:
    # Breaks where their lines interleave, and each deletes the other's motion.
    first = written(tmp_path, record(), finish=False)
    before = contents(tmp_path)
    second = ResultsWriter(tmp_path)
    message = f"^{re.escape(str(tmp_path))}: another run writes there. Wait .* another `--out`$"
    with pytest.raises(ResultsError, match=message):
        second.begin(ENVIRONMENT)
    with pytest.raises(ResultsError, match="another run writes there"), second.reserved():
        pass
    second.finish("interrupted")
    assert contents(tmp_path) == before
    first.write(record("ghostball"), motion())
    first.finish("complete")
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


def test_a_thread_may_finish_what_another_began(tmp_path: Path) -> None:
    writer = written(tmp_path, record(), finish=False)
    thread = threading.Thread(target=writer.finish, args=("complete",))
    thread.start()
    thread.join()
    written(tmp_path, record())


def test_a_killed_run_locks_nobody_out(tmp_path: Path) -> None:
    script = (
        "import sys, time; from pathlib import Path\n"
        "from validation.results.store import ResultsWriter\n"
        "writer = ResultsWriter(sys.argv[1]); writer.begin({})\n"
        "print('begun', flush=True); time.sleep(600)"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script, str(tmp_path)],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "begun\n"
            with pytest.raises(ResultsError, match="another run writes there"):
                written(tmp_path)
        finally:
            process.kill()
    written(tmp_path, record())
    assert labels(Results.open(tmp_path).cases) == ["pymunk"]


def test_the_lock_is_no_part_of_the_results(tmp_path: Path) -> None:
    with ResultsWriter(tmp_path).reserved():
        pass
    assert contents(tmp_path) in ({}, {LOCK_FILE: b""})  # Windows leaves none
    assert read_earlier(tmp_path) == []
    with pytest.raises(ResultsError, match="not a results folder"):
        Results.open(tmp_path)
    written(tmp_path, record())  # not taken for something of the user's
    assert set(contents(tmp_path)) - {LOCK_FILE} == {
        "env.json",
        "results.jsonl",
        "motion/roll--pymunk.npz",
    }


def test_a_folder_without_results_holds_nothing_earlier(tmp_path: Path) -> None:
    assert read_earlier(tmp_path) == []
    assert read_earlier(tmp_path / "missing") == []


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


def test_a_scene_that_was_damaged_is_named_and_is_no_bug_of_ours() -> None:
    case = record(scene="stop", definition={"name": "stop", "balls": []})
    with pytest.raises(GhostballError, match=r'"stop" are damaged: `balls` must .*again'):
        case.load_scene()
