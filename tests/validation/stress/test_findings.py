"""The folder of a stress run: what was written reads back, whatever ended the run."""

from __future__ import annotations

import json

import filelock
import pytest

import validation.results.files
from validation.results.files import ResultsError
from validation.stress.findings import (
    FINDINGS_FILE,
    LOCK_FILE,
    Finding,
    StressFolder,
    StressRun,
    StressWriter,
)

KEYS = tuple(("grazing", name, "ghostball") for name in "abc")
RUN = StressRun("quick", ("grazing",), ("ghostball",), {}, missing=KEYS)


def finding(trial: str, **changes) -> Finding:
    return Finding("grazing", trial, "ghostball", **{"outcome": "survived", **changes})


@pytest.fixture
def folder(tmp_path):
    """Return a folder with two of three findings."""
    writer = StressWriter(tmp_path / "out")
    with writer.reserved():
        writer.begin(RUN, [])
        writer.add(finding("a", values={"depth": float("nan"), "é": "\u2028"}))
        writer.add(finding("b"))
    return tmp_path / "out"


def trials(folder) -> list[str]:
    return [one.trial for one in StressFolder.load(folder).findings]


def test_what_was_added_reads_back(folder):
    assert trials(folder) == ["a", "b"]
    assert StressFolder.load(folder).missing == {KEYS[2]}
    assert StressFolder.load(folder).planned == 3
    assert not StressFolder.load(folder).whole
    assert StressFolder.load(folder).findings[0].values == {"depth": None, "é": "\u2028"}


@pytest.mark.parametrize("cut", [1, 10, 100])
def test_a_line_that_a_kill_cut_short_costs_itself(folder, cut):
    path = folder / FINDINGS_FILE
    path.write_bytes(path.read_bytes()[:-cut])
    assert trials(folder) == ["a"]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (b"{\n", "not valid JSON"),
        (b"[]\n", "a JSON object was expected"),
        (b'{"schema": 99}\n', "`schema` must be 2"),
        (b'{"schema": 2, "more": 1}\n', "`"),
        (b"\xff\n", "can't be read"),
    ],
)
def test_damage_elsewhere_is_named_with_its_line(folder, line, message):
    path = folder / FINDINGS_FILE
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(lines[0] + line + lines[2])
    with pytest.raises(ResultsError, match=message) as caught:
        StressFolder.load(folder)
    assert FINDINGS_FILE in str(caught.value)


def test_another_file_is_no_folder_of_ours(tmp_path):
    with pytest.raises(ResultsError, match="not a folder of `ghostball stress`"):
        StressFolder.load(tmp_path)
    (tmp_path / FINDINGS_FILE).write_bytes(b"")
    with pytest.raises(ResultsError, match="is empty"):
        StressFolder.load(tmp_path)


def test_what_strangers_put_there_stays(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(ResultsError, match=r"something else \(thesis.tex\)"):
        StressWriter(tmp_path).reserved().__enter__()
    assert [entry.name for entry in tmp_path.iterdir()] == ["thesis.tex"]


def test_another_process_in_the_folder_is_waited_for(folder):
    lock = filelock.FileLock(folder / LOCK_FILE)
    with (
        lock,
        pytest.raises(ResultsError, match="another run is writing there"),
        StressWriter(folder).reserved(),
    ):
        pass
    with StressWriter(folder).reserved():
        pass


def test_the_worst_case_of_what_broke_is_never_a_survivor(tmp_path):
    broken = finding("b", outcome="broken", faults=("crashed",), severity=1.0, scene=None)
    run = StressRun("quick", ("f",), ("ghostball",), {})
    found = [finding("a", severity=0.9, scene={"name": "x"}), broken]
    folder = StressFolder(tmp_path, run, found)
    assert folder.worst(broken.family, broken.label) is None
    assert StressFolder(tmp_path, run, found[:1]).worst(broken.family, broken.label) == found[0]


def test_a_kill_before_the_first_line_leaves_the_folder_of_use(tmp_path):
    (tmp_path / f"{FINDINGS_FILE}.part").write_bytes(b'{"suite": "qu')
    writer = StressWriter(tmp_path)
    with writer.reserved():
        writer.begin(RUN, [])
    assert trials(tmp_path) == []


def test_a_full_disk_loses_nothing_that_was_written(folder, monkeypatch):
    class Full:
        def __init__(self, file):
            self.file = file

        def __enter__(self):
            return self

        def __exit__(self, *_):
            self.file.close()

        def write(self, content):
            self.file.write(content[:20])
            raise OSError(28, "No space left on device")

        def writelines(self, lines):
            self.write(next(iter(lines)))

    real = validation.results.files.Path.open
    monkeypatch.setattr(
        validation.results.files.Path, "open", lambda path, *mode, **k: Full(real(path, *mode, **k))
    )
    writer = StressWriter(folder)
    with pytest.raises(ResultsError, match=r"No space left on device\. Choose another `--out`"):
        writer.add(finding("c"))
    with pytest.raises(ResultsError, match="No space left"):
        writer.begin(RUN, [])
    monkeypatch.undo()
    assert trials(folder) == ["a", "b"]
    assert not list(folder.glob("*.part"))


def test_lines_are_json_without_nan(folder):
    for line in (folder / FINDINGS_FILE).read_text(encoding="utf-8").split("\n")[:-1]:
        json.loads(line, parse_constant=pytest.fail)
