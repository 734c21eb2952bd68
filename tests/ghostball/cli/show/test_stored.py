"""What `ghostball report` and `export` show of an earlier run."""

from pathlib import Path

import pytest
from commands import refused
from stored_results import cut_short, in_database

from ghostball.validation.results.database import DATABASE


@pytest.mark.parametrize("damage", ["cut short", "another version", "no database"])
def test_results_that_cannot_be_read_are_one_line_and_stay(cli, tmp_path, damage):
    command = ("validate", "stop", "-e", "paper-discrete", "--out", tmp_path, "--no-report")
    assert cli(*command).exit_code == 0
    path = tmp_path / DATABASE
    if damage == "cut short":
        cut_short(tmp_path)
    elif damage == "another version":
        in_database(tmp_path, "PRAGMA user_version = 1")
    else:
        path.write_text("years of work")
    left = path.read_bytes()
    said = "its version must be" if damage == "another version" else "is cut short or damaged"
    for again in (command, ("report", tmp_path), ("export", tmp_path)):
        assert refused(cli(*again), str(path), said, "Move the file away")
    assert path.read_bytes() == left


def test_export_writes_what_was_found_for_anyone(cli, tmp_path):
    out = tmp_path / "out"
    cli("validate", "stop", "-e", "ghostball", "--out", out, "--no-report")
    result = cli("export", out)
    assert result.exit_code == 0, result.output
    files = [Path(line) for line in result.stdout.splitlines()]
    assert {path.parent for path in files} == {out / "export"}
    assert {"cases.jsonl", "checks.csv", "events.csv"} <= {path.name for path in files}
    assert cli("export", out, "--out", tmp_path / "there").exit_code == 0
    assert (tmp_path / "there" / "metrics.csv").read_text().startswith("scene,label,name,value\n")
    assert refused(cli("export", tmp_path / "none"), "no such results folder")
