"""`ghostball stress`: options, exit statuses, and output."""

import json
import shlex
from functools import partial

import pytest
from commands import refused

import ghostball.cli.measure.stress
from ghostball.reference_adapters.pybullet.engine import PybulletEngine
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.stress import FAMILIES

ONE = "grazing/rolling-hit-1e-01"


@pytest.fixture
def stress(cli, here):
    return partial(cli, "stress")


def test_the_list_names_families_or_shots_as_the_command_takes_them(stress, here):
    result = stress("--list")
    assert result.exit_code == 0, result.output
    assert all(name in result.stdout for name in FAMILIES)
    names = stress("--list", "grazing").stdout.split()
    assert ONE in names
    assert all(name.startswith("grazing/") for name in names)
    assert len(stress("--list", "grazing", "--full").stdout.split()) > len(names)
    found = json.loads(stress("--list", "storms", "--seed=3", "--count=1", "--format=json").stdout)
    assert found["shots"] == ["storms/break-00003", "storms/begun-00003"]
    assert list(here.iterdir()) == []


@pytest.mark.parametrize(
    ("folder", "said"),
    [("out/stress", "`ghostball report out`"), ("shots", "Move shots to OUT/stress")],
)
def test_a_run_alone_has_no_report_but_where_it_is_shown_is_said(stress, cli, folder, said):
    assert stress(ONE, "-e", "ghostball", "--out", folder).exit_code == 0
    assert refused(cli("report", folder), said)


def test_a_scene_of_a_user_with_the_same_tag_has_a_report(cli, here):
    scene = find_scene("stop").model_copy(update={"name": "mine", "tags": ("stress",)})
    scene.save(here / "mine.toml")
    assert cli("validate", "mine.toml", "-e", "ghostball", "--no-report").exit_code == 0
    assert cli("report", "out", "--figures=none").exit_code == 0


def test_runs_and_engines_are_compared_although_no_motion_is_kept(stress, cli):
    name, coarse = "grazing/rolling-hit-1e-04", "pymunk:dt=0.05"
    for folder in ("a", "b"):
        stress(name, "-e", "ghostball", "-e", coarse, "--out", folder)
    same = cli("diff", "a", "b")
    assert same.exit_code == 0, same.output
    assert "2 of 2 cases unchanged" in same.stdout
    engines = cli("diff", "ghostball", coarse, "--out", "a", "--format=json")
    (case,) = json.loads(engines.stdout)["cases"]
    assert case["failed"]
    assert case["first_difference"] is None
    assert "ball-ball collisions 1 -> 0" in case["summary"]


def test_an_engine_that_cannot_run_here_is_refused_where_it_is_named(stress, here, monkeypatch):
    # Of the default engines, only the installed ones are needed.
    why = "pybullet is not installed"
    monkeypatch.setattr(PybulletEngine, "unavailable", classmethod(lambda cls: why))
    assert refused(stress(ONE, "-e", "ghostball", "-e", "pybullet", "--out", "out"), why)
    assert not (here / "out").exists()
    monkeypatch.setattr(ghostball.cli.measure.stress, "DEFAULT_ENGINES", ("ghostball", "pybullet"))
    assert stress(ONE, "--out", "out").exit_code == 0
    found = {one.label: one.outcome for one in Results.open("out").cases}
    assert found == {"ghostball": "ran", "pybullet": "unavailable"}


def test_only_engines_that_are_named_must_pass_or_ours_where_none_is(stress, cli, monkeypatch):
    # With this step, a collision with a depth of 1e-4 diameters is missed.
    coarse, name = "pymunk:dt=0.05", "grazing/rolling-hit-1e-04"
    monkeypatch.setattr(ghostball.cli.measure.stress, "DEFAULT_ENGINES", ("ghostball", coarse))
    result = stress(name, "--out", "out")
    assert (result.exit_code, "collision_count must be exactly 1, got 0" in result.stdout) == (
        0,
        True,
    )
    assert "0/1" in result.stdout
    result = stress(name, "-e", coarse, "--out", "a b")
    assert result.exit_code == 1
    said = dict(line.strip().split(": ", 1) for line in result.stdout.splitlines() if ": " in line)
    word, *arguments = shlex.split(said["to repeat"])
    assert word == "ghostball"
    assert cli(*arguments, "--out", "c").exit_code == 1
    assert cli(*shlex.split(said["to explain"])[1:]).exit_code == 0


def test_json_is_all_that_is_printed(stress):
    arguments = (ONE, "-e", "ghostball", "--out", "out")
    result = stress(*arguments, "--format=json")
    assert result.exit_code == 0, result.output
    (case,) = json.loads(result.stdout)["cases"]
    assert (case["scene"], case["outcome"]) == ("grazing.rolling-hit-1e-01", "ran")
    again = stress(*arguments)
    assert "1 case reused" in again.stderr
    assert "1/1" in again.stdout


def test_shards_are_all_shots_and_each_has_its_own_file(stress, here):
    polars = pytest.importorskip("polars")
    whole = stress("--list", "grazing").stdout.split()
    listed = [stress("--list", "grazing", "--shard", f"{i}/20").stdout.split() for i in (1, 2, 20)]
    assert listed == [whole[k::20] for k in (0, 1, 19)]
    for i in (1, 2):
        done = stress("grazing", "-e", "ghostball", "--shard", f"{i}/20", "--out", "shots")
        assert done.exit_code == 0, done.output
    for i in (1, 2):
        found = polars.read_parquet(f"shots/cases-{i:02}-of-20.parquet")
        names = [name.replace("/", ".", 1) for name in whole[i - 1 :: 20]]
        assert sorted(found["scene"]) == sorted(names)
    assert refused(
        stress("--shard", "65/64"), "a shard must be i/n with i from 1 to n, such as 7/64"
    )
    assert refused(
        stress(ONE, "--shard", "2/2"), "shard 2/2 has no shots, because there are 1 in all"
    )
