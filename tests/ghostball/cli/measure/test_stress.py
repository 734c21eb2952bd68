"""`ghostball stress`: options, exit statuses, what is printed where."""

import json
import shlex

import pytest
from commands import refused
from typer.testing import CliRunner

import ghostball.cli.measure.stress
from ghostball.cli import app
from ghostball.reference_adapters.pybullet.engine import PybulletEngine
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.stress import FAMILIES

ONE = "grazing/rolling-hit-1e-01"


def stress(*arguments):
    return CliRunner().invoke(app, ["stress", *map(str, arguments)])


def test_the_list_names_families_or_shots_as_the_command_takes_them(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = stress("--list")
    assert result.exit_code == 0, result.output
    assert all(name in result.stdout for name in FAMILIES)
    names = stress("--list", "grazing").stdout.split()
    assert ONE in names
    assert all(name.startswith("grazing/") for name in names)
    assert len(stress("--list", "grazing", "--full").stdout.split()) > len(names)
    found = json.loads(stress("--list", "storms", "--seed=3", "--count=1", "--format=json").stdout)
    assert found["shots"] == ["storms/break-00003", "storms/begun-00003"]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("in_this_process")
def test_a_run_is_a_section_of_the_report_of_the_folder_that_it_lies_in(tmp_path):
    folder = tmp_path / "out" / "stress"
    assert stress(ONE, "-e", "ghostball", "--out", folder).exit_code == 0
    alone = CliRunner().invoke(app, ["report", str(folder)])
    assert refused(alone, f"`ghostball report {folder.parent}`")


@pytest.mark.usefixtures("in_this_process")
def test_a_run_elsewhere_is_told_where_the_report_looks_for_it(tmp_path):
    folder = tmp_path / "shots"
    assert stress(ONE, "-e", "ghostball", "--out", folder).exit_code == 0
    alone = CliRunner().invoke(app, ["report", str(folder)])
    assert refused(alone, f"Move {folder} to OUT/stress")


@pytest.mark.usefixtures("in_this_process")
def test_a_scene_of_a_user_with_the_same_tag_has_a_report(tmp_path):
    file = tmp_path / "mine.toml"
    scene = find_scene("stop").model_copy(update={"name": "mine", "tags": ("stress",)})
    scene.save(file)
    arguments = ["-e", "ghostball", "--no-report", "--out", str(tmp_path / "out")]
    assert CliRunner().invoke(app, ["validate", str(file), *arguments]).exit_code == 0
    arguments = ["report", str(tmp_path / "out"), "--figures=none"]
    assert CliRunner().invoke(app, arguments).exit_code == 0


@pytest.mark.usefixtures("in_this_process")
def test_runs_and_engines_are_compared_although_no_motion_is_kept(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name, coarse = "grazing/rolling-hit-1e-04", "pymunk:dt=0.05"
    for folder in ("a", "b"):
        stress(name, "-e", "ghostball", "-e", coarse, "--out", tmp_path / folder)
    same = CliRunner().invoke(app, ["diff", str(tmp_path / "a"), str(tmp_path / "b")])
    assert same.exit_code == 0, same.output
    assert "2 of 2 cases alike" in same.stdout
    arguments = ["diff", "ghostball", coarse, "--out", str(tmp_path / "a"), "--format=json"]
    (case,) = json.loads(CliRunner().invoke(app, arguments).stdout)["cases"]
    assert case["failed"]
    assert case["first_difference"] is None
    assert "ball-ball collisions 1 -> 0" in case["summary"]


@pytest.mark.usefixtures("in_this_process")
def test_an_engine_that_cannot_run_here_is_refused_where_it_is_named(tmp_path, monkeypatch):
    # Of the engines by default, those that are here will do.
    why = "pybullet is not installed"
    monkeypatch.setattr(PybulletEngine, "unavailable", classmethod(lambda cls: why))
    result = stress(ONE, "-e", "ghostball", "-e", "pybullet", "--out", tmp_path / "out")
    assert refused(result, why)
    assert not (tmp_path / "out").exists()
    monkeypatch.setattr(ghostball.cli.measure.stress, "DEFAULT_ENGINES", ("ghostball", "pybullet"))
    assert stress(ONE, "--out", tmp_path / "out").exit_code == 0
    found = {one.label: one.outcome for one in Results.open(tmp_path / "out").cases}
    assert found == {"ghostball": "ran", "pybullet": "unavailable"}


@pytest.mark.usefixtures("in_this_process")
def test_only_engines_that_are_named_must_pass_or_ours_where_none_is(tmp_path, monkeypatch):
    # At this step a path that goes 1e-4 diameters deep is missed.
    coarse, name = "pymunk:dt=0.05", "grazing/rolling-hit-1e-04"
    monkeypatch.setattr(ghostball.cli.measure.stress, "DEFAULT_ENGINES", ("ghostball", coarse))
    result = stress(name, "--out", tmp_path / "out")
    assert (result.exit_code, "collision_count must be == 1, got 0" in result.stdout) == (0, True)
    assert "0/1" in result.stdout
    result = stress(name, "-e", coarse, "--out", tmp_path / "a b")
    assert result.exit_code == 1
    lines = result.stdout.splitlines()
    (again,) = (line.partition("again: ")[2] for line in lines if "again: " in line)
    word, *arguments = shlex.split(again)
    assert word == "ghostball"
    assert CliRunner().invoke(app, [*arguments, "--out", str(tmp_path / "c")]).exit_code == 1
    (why,) = (line.partition("why: ")[2] for line in lines if "why: " in line)
    assert CliRunner().invoke(app, shlex.split(why)[1:]).exit_code == 0


@pytest.mark.usefixtures("in_this_process")
def test_json_is_all_that_is_printed(tmp_path):
    arguments = (ONE, "-e", "ghostball", "--out", tmp_path)
    result = stress(*arguments, "--format=json")
    assert result.exit_code == 0, result.output
    (case,) = json.loads(result.stdout)["cases"]
    assert (case["scene"], case["outcome"]) == ("grazing.rolling-hit-1e-01", "ran")
    again = stress(*arguments)
    assert "1 case unchanged, reused" in again.stderr
    assert "1/1" in again.stdout
