"""`ghostball stress`: options, exit statuses, what is printed where."""

import json
import shlex

import pytest
from commands import refused
from typer.testing import CliRunner

import ghostball.cli.measure.stress
from ghostball.cli import app
from ghostball.reference_adapters.pybullet.engine import PybulletEngine
from ghostball.validation.stress import FAMILIES

ONE = "grazing/rolling-hit-1e-01"


def stress(*arguments):
    return CliRunner().invoke(app, ["stress", *map(str, arguments)])


def test_the_list_names_every_family_and_tries_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = stress("--list")
    assert result.exit_code == 0, result.output
    assert all(name in result.stdout for name in FAMILIES)
    assert list(tmp_path.iterdir()) == []


def test_the_list_of_a_family_names_its_trials_as_the_command_takes_them():
    names = stress("--list", "grazing").stdout.split()
    assert ONE in names
    assert all(name.startswith("grazing/") for name in names)
    assert len(stress("--list", "grazing", "--full").stdout.split()) > len(names)
    assert stress("--list", "grazing/*-1e-01").stdout.split() == [
        name for name in names if name.endswith("-1e-01")
    ]
    assert stress("--list", "grasing").exit_code == 2


@pytest.mark.usefixtures("in_this_process")
def test_a_run_is_a_section_of_the_report_of_the_folder_that_it_lies_in(tmp_path):
    folder = tmp_path / "out" / "stress-quick"
    assert stress(ONE, "-e", "ghostball", "--out", folder).exit_code == 0
    alone = CliRunner().invoke(app, ["report", str(folder)])
    assert refused(alone, f"`ghostball report {folder.parent}`")


@pytest.mark.parametrize("option", ["--open", "--figures=none", "--jobs=2"])
def test_what_no_print_of_results_can_heed_is_refused(tmp_path, option):
    report = CliRunner().invoke(app, ["report", str(tmp_path), "--format=json", option])
    assert report.exit_code == 2
    assert "writes no report" in " ".join(report.stderr.split())


@pytest.mark.usefixtures("in_this_process")
def test_an_engine_that_cannot_run_here_is_refused_where_it_is_named(tmp_path, monkeypatch):
    # Of the engines by default, those that are here will do.
    why = "pybullet is not installed"
    monkeypatch.setattr(PybulletEngine, "unavailable", classmethod(lambda cls: why))
    result = stress(ONE, "-e", "ghostball", "-e", "pybullet", "--out", tmp_path / "out")
    assert refused(result, why)
    assert not (tmp_path / "out").exists()
    monkeypatch.setattr(ghostball.cli.measure.stress, "DEFAULT_ENGINES", ("ghostball", "pybullet"))
    result = stress(ONE, "--out", tmp_path / "out", "--format=json")
    assert result.exit_code == 0
    found = {one["engine"]: one for one in json.loads(result.stdout)["survival"]}
    assert found["pybullet"]["unavailable"] == found["ghostball"]["survived"] == 1


def test_the_command_to_try_again_gives_the_same_verdict(tmp_path):
    name = "grazing/rolling-hit-1e-04"
    result = stress(name, "-e", "pymunk:dt=0.05", "--out", tmp_path / "a b", "--format=json")
    assert result.exit_code == 1
    first = json.loads(result.stdout)["survival"][0]
    assert first["broken"] == 1
    word, *arguments = shlex.split(first["again"])
    assert word == "ghostball"
    again = CliRunner().invoke(app, [*arguments, "--format=json"])
    assert again.exit_code == 1
    second = json.loads(again.stdout)["survival"][0]
    for key in ("trial", "outcome", "faults", "severity"):
        assert second["worst"][key] == first["worst"][key]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["grasing"], "'grasing'"),
        ([ONE, "-e", "chess"], "chess"),
        ([ONE, "-e", "ghostball", "-e", "ghostball"], "once"),
        ([ONE, "--jobs", "0"], "--jobs"),
        ([ONE, "--suite", "full"], "--suite"),
        ([ONE, "--time-limit", "0"], "`time_limit`"),
        ([ONE, "--time-limit", "soon"], "--time-limit"),
    ],
)
def test_bad_options_are_refused(tmp_path, arguments, message):
    assert refused(stress(*arguments, "--out", tmp_path / "out"), message)
    assert not (tmp_path / "out").exists()


def test_a_folder_with_something_else_is_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    assert refused(stress(ONE, "--out", tmp_path), "not a results folder of ours")
    assert [entry.name for entry in tmp_path.iterdir()] == ["thesis.tex"]


def test_json_is_all_that_is_printed(tmp_path):
    arguments = (ONE, "-e", "ghostball", "--out", tmp_path)
    result = stress(*arguments, "--format=json")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert (found["planned"], found["done"], found["exit_status"]) == (1, 1, 0)
    assert found["survival"][0]["survived"] == 1
    again = stress(*arguments)
    assert "are known" in again.stderr
    assert "1/1" in again.stdout
