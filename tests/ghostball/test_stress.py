"""`ghostball stress`: options, exit statuses, what is printed where."""

import json

import pytest
from typer.testing import CliRunner

from ghostball.cli import app
from validation.stress import FAMILIES

ONE = "grazing/rolling-hit-1e-01"


def stress(*arguments):
    return CliRunner().invoke(app, ["stress", *map(str, arguments)])


def test_the_list_names_every_family_and_tries_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = stress("--list")
    assert result.exit_code == 0, result.output
    assert all(name in result.stdout for name in FAMILIES)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["grasing"], "'grasing'"),
        ([ONE, "--engines", "chess"], "chess"),
        ([ONE, "--engines", "ghostball,ghostball"], "once"),
        ([ONE, "--jobs", "0"], "--jobs"),
        ([ONE, "--suite", "endless"], "--suite"),
        ([ONE, "--time-limit", "0"], "`time_limit`"),
        ([ONE, "--time-limit", "soon"], "--time-limit"),
    ],
)
def test_bad_options_are_refused(tmp_path, arguments, message):
    result = stress(*arguments, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert message in result.stderr
    assert "Traceback" not in result.stderr
    assert not (tmp_path / "out").exists()


def test_a_folder_with_something_else_is_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    result = stress(ONE, "--out", tmp_path)
    assert result.exit_code == 2
    assert "something else" in result.stderr
    assert [entry.name for entry in tmp_path.iterdir()] == ["thesis.tex"]


def test_json_is_all_that_is_printed(tmp_path):
    arguments = (ONE, "--engines", "ghostball", "--out", tmp_path, "--no-report")
    result = stress(*arguments, "--json")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert (found["planned"], found["done"], found["exit_status"]) == (1, 1, 0)
    assert found["survival"][0]["survived"] == 1
    again = stress(*arguments)
    assert "are known" in again.stderr
    assert "1/1" in again.stdout
