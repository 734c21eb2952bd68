"""The folder of a stress run: what was written reads back, whatever ended the run."""

from __future__ import annotations

import pytest

from ghostball.validation.results.database import transaction, writing
from ghostball.validation.results.files import ResultsError
from ghostball.validation.stress.findings import (
    RUN,
    Finding,
    StressFolder,
    StressRun,
    StressWriter,
    is_stress_folder,
)

KEYS = tuple(("grazing", name, "ghostball") for name in "abc")
ASKED = StressRun("quick", ("grazing",), ("ghostball",), {}, asked=KEYS)


def finding(trial: str, **changes) -> Finding:
    return Finding("grazing", trial, "ghostball", **{"outcome": "survived", **changes})


@pytest.fixture
def folder(tmp_path):
    """Return a folder with two of three findings."""
    writer = StressWriter(tmp_path / "out")
    with writer.reserved():
        writer.begin(RUN.dump_python(ASKED, mode="json"))
        writer.write(finding("b"))
        writer.write(finding("a", values={"depth": float("nan"), "é": "\u2028"}))
    return tmp_path / "out"


def trials(folder) -> list[str]:
    return [one.trial for one in StressFolder.load(folder).findings]


def test_what_was_added_reads_back(folder):
    assert trials(folder) == ["a", "b"]
    assert StressFolder.load(folder).missing == {KEYS[2]}
    assert StressFolder.load(folder).planned == 3
    assert not StressFolder.load(folder).whole
    assert StressFolder.load(folder).findings[0].values == {"depth": None, "é": "\u2028"}


def test_a_folder_of_something_else_is_said_to_be(tmp_path):
    with pytest.raises(ResultsError, match="not a results folder"):
        StressFolder.load(tmp_path)
    assert not is_stress_folder(tmp_path)
    with writing(tmp_path):
        assert not is_stress_folder(tmp_path)
    with pytest.raises(ResultsError, match="not a folder of `ghostball stress`"):
        StressFolder.load(tmp_path)


def test_what_somebody_edited_is_named(folder):
    with writing(folder) as database, transaction(database):
        database.execute("UPDATE records SET record = json_set(record, '$.shots', 'many')")
    with pytest.raises(ResultsError, match="a finding is damaged: `shots` must be a valid integer"):
        StressFolder.load(folder)


def test_the_worst_case_of_what_broke_is_never_a_survivor(tmp_path):
    broken = finding("b", outcome="broken", faults=("crashed",), severity=1.0, scene=None)
    run = StressRun("quick", ("f",), ("ghostball",), {})
    found = [finding("a", severity=0.9, scene={"name": "x"}), broken]
    folder = StressFolder(tmp_path, run, found)
    assert folder.worst(broken.family, broken.label) is None
    assert StressFolder(tmp_path, run, found[:1]).worst(broken.family, broken.label) == found[0]
