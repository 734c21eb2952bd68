"""The results folder: written case by case, read back to the bit, refused with a reason."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from stored_cases import in_database, motion, record, taking_over, written

from ghostball.validation.results.database import writing
from ghostball.validation.results.store import (
    Results,
    ResultsError,
    ResultsWriter,
    has_results,
)


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
