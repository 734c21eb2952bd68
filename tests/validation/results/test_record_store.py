"""The records of a folder after complete and interrupted runs, and refused folders."""

from __future__ import annotations

import re
from pathlib import Path
from unittest.mock import Mock

import pytest
from stored_records import ENVIRONMENT, labels, left, motion, record, taking_over, written

from ghostball.validation.results.database import DATABASE, LOCK
from ghostball.validation.results.store import Results, ResultsError, ResultsWriter


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


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
    assert (tmp_path / "report.html").exists()  # the store doesn't delete other files


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


def test_failed_cases_and_cases_of_unknown_code_are_not_reused(tmp_path: Path) -> None:
    writer = ResultsWriter(tmp_path, "code")
    writer.begin(ENVIRONMENT)
    writer.write((record("pymunk", outcome="failed"), None), "inputs")
    writer.write((record("pybullet", status="rest"), None))  # an engine with unknown code
    writer.finish("complete")
    assert writer.known() == (0, {})


def test_two_writers_are_never_in_one_folder(tmp_path: Path) -> None:
    # Fails if two writers mix their records or delete each other's motion.
    first = written(tmp_path, record(), finish=False)
    second = ResultsWriter(tmp_path)
    message = (
        f"^{re.escape(str(tmp_path))}: another run is writing to this folder. Wait .* another "
        f"`--out`$"
    )
    with pytest.raises(ResultsError, match=message):
        second.begin(ENVIRONMENT)
    with (
        pytest.raises(ResultsError, match="another run is writing to this folder"),
        second.reserved(),
    ):
        pass
    second.finish("interrupted")
    first.write((record("ghostball"), motion()))
    first.finish("complete")
    assert labels(Results.open(tmp_path).cases) == ["pymunk", "ghostball"]
    written(tmp_path, record("pybullet"))
    assert labels(Results.open(tmp_path).cases) == ["pybullet"]


def test_a_reserved_folder_is_free_only_afterwards(tmp_path: Path) -> None:
    writer, other = ResultsWriter(tmp_path), ResultsWriter(tmp_path)  # a lock file isn't content
    with writer.reserved():
        writer.begin(ENVIRONMENT)
        writer.finish("complete")
        with pytest.raises(ResultsError, match="another run is writing to this folder"):
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
    assert contents(tmp_path)  # the test file for write access
    written(tmp_path, record())
    assert set(contents(tmp_path)) - {LOCK} == {DATABASE}


def test_a_folder_that_is_not_ours_is_refused_and_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    before = contents(tmp_path)
    with pytest.raises(ResultsError, match="not empty and not a Ghostball results folder"):
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
    # Nobody can create files in /proc, not even root.
    if not Path("/proc/self").exists():
        pytest.skip("no /proc here")
    with pytest.raises(ResultsError, match="can't write the results folder"):
        ResultsWriter("/proc/ghostball-results")
