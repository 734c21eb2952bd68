from __future__ import annotations

import re
import tomllib
from email.message import Message
from pathlib import Path

import pytest
import yaml
from commands import edit_engine, refused
from stored_records import cut_short, in_database

from ghostball.cli.show.init import UNKNOWN_REPOSITORY, repository
from ghostball.validation import scene_names
from ghostball.validation.results.database import DATABASE

# `ghostball engines --check`: a complete installation, a missing engine, a broken engine


@pytest.mark.usefixtures("without_pybullet")
def test_a_missing_optional_engine_is_listed_and_breaks_nothing(cli, tmp_path, monkeypatch):
    listed = cli("engines")
    assert listed.exit_code == 0
    assert "pybullet" in listed.stdout.partition("Not installed: ")[2].partition(".")[0]
    assert "pybullet isn't installed" in cli("engines", "pybullet").stdout
    examined = cli("engines", "--check")
    assert "pip install pybullet" in " ".join(examined.stdout.split())
    assert examined.exit_code == 0, examined.output
    monkeypatch.setattr("ghostball.cli.measure.validate.DEFAULT_ENGINES", ("ghostball", "pybullet"))
    out = tmp_path / "out"
    validated = cli("validate", "stop", "--out", out, "--format", "junit")
    assert validated.exit_code == 0, validated.output
    assert "1 case not run: engine unavailable" in validated.stderr
    assert "unavailable" in (out / "report.html").read_text()
    assert "pybullet isn't installed" in validated.stdout
    assert "unavailable" in cli("report", out, "--format", "markdown").stdout


def test_a_broken_foreign_engine_is_named_and_hides_no_other(cli, tmp_path, monkeypatch):
    metadata = tmp_path / "broken_engine-1.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: broken-engine\nVersion: 1\n")
    (metadata / "entry_points.txt").write_text("[ghostball.engines]\nbroken = no_such_module:X\n")
    monkeypatch.syspath_prepend(tmp_path)
    listed = cli("engines")
    assert listed.exit_code == 0
    (row,) = (line for line in listed.stdout.splitlines() if line.split()[:1] == ["broken"])
    assert row.split()[1] == "no"
    why = cli("engines", "broken", "ghostball").stdout
    assert "broken  unavailable" in why
    assert "no_such_module" in why
    examined = cli("engines", "--check")
    assert examined.exit_code == 1
    assert "The installation is broken" in examined.stderr


def test_the_check_names_versions_kernels_engines_and_scenes(cli):
    result = cli("engines", "--check")
    assert result.exit_code == 0, result.output
    for part in ("python", "numpy", "kernels", "engine ghostball", f"{len(scene_names())} shipped"):
        assert part in result.stdout


def test_the_export_counts_one_scene_in_the_singular(cli, here):
    result = cli("scenes", "stop", "--export", "there")
    assert result.stdout == "1 scene and the schema of scenes written to there\n"


def test_scenes_are_not_written_onto_a_file(cli, here):
    Path("there").write_text("mine", encoding="utf-8")
    result = cli("scenes", "stop", "--export", "there")
    assert result.exit_code == 2
    said = " ".join(result.stderr.split())
    assert said == "error: there: can't be written: File exists. Choose another folder"
    assert Path("there").read_text("utf-8") == "mine"


# `ghostball init`: its files run, and nothing is overwritten


def test_a_project_begins_with_two_files(cli, here):
    result = cli("init")
    assert result.exit_code == 0, result.output
    assert result.stdout.split() == ["my_engine.py", "pyproject.toml"]
    assert "my_engine.py contains a deliberate mistake" in result.stderr
    assert "ghostball regress" in result.stderr
    table = tomllib.loads((here / "pyproject.toml").read_text("utf-8"))["tool"]["ghostball"]
    assert table["engines"] == ["my_engine:simulate"]
    assert cli("run", "stop", "-e", "my_engine:simulate").exit_code == 0


@pytest.mark.parametrize(
    "scenes", [["restitution-head-on", "stop"], pytest.param([], marks=pytest.mark.slow)]
)
def test_the_example_fails_until_its_one_mistake_is_fixed(cli, here, in_this_process, scenes):
    assert cli("init").exit_code == 0
    first = cli("validate", *scenes, "--no-report")
    assert first.exit_code == 1, first.output
    failed = re.findall(r"^failed +(\S+) on my_engine:simulate", first.stdout, re.MULTILINE)
    assert set(failed) == {"restitution-head-on"}
    named = "ghostball explain restitution-head-on --engine my_engine:simulate"
    assert f"next: `{named}`" in " ".join(first.stdout.split())
    cause = " ".join(cli(*named.split()[1:]).stdout.split())
    assert "my_engine:simulate behaves as if `ball_restitution` were" in cause
    assert ": elastic, not 0.9." in cause
    # The change that the file itself suggests
    (fixed,) = re.findall("change one line: `(.*)`", Path("my_engine.py").read_text("utf-8"))
    edit_engine("restitution = 1.0", fixed)
    again = cli("validate", *scenes, "--no-report")
    assert again.exit_code == 0, again.output
    assert " 0 failed" in again.stdout


def test_existing_files_of_a_project_stay(cli, here):
    (here / "pyproject.toml").write_text('[project]\nname = "mine"\n', "utf-8")
    started = cli("init", "-e", "pymunk")
    assert started.exit_code == 0
    assert "mistake" not in started.stderr
    plain = tomllib.loads((here / "pyproject.toml").read_text("utf-8"))
    assert plain["project"] == {"name": "mine"}
    assert plain["tool"]["ghostball"]["engines"] == ["pymunk"]
    assert not (here / "my_engine.py").exists()
    before = (here / "pyproject.toml").read_bytes()
    again = cli("init")
    assert again.exit_code == 2
    assert "already has `[tool.ghostball]`" in again.stderr
    assert (here / "pyproject.toml").read_bytes() == before


def test_a_file_that_is_there_is_not_overwritten(cli, here):
    (here / "my_engine.py").write_text("mine = 1\n", "utf-8")
    result = cli("init")
    assert result.exit_code == 2
    assert "my_engine.py: already exists" in result.stderr
    assert (here / "my_engine.py").read_text("utf-8") == "mine = 1\n"
    assert not (here / "pyproject.toml").exists()


# `ghostball report`: output and export of an earlier run


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
    said = "its version must be" if damage == "another version" else "is truncated or damaged"
    for again in (command, ("report", tmp_path), ("report", tmp_path, "--export", "there")):
        assert refused(cli(*again), str(path), said, "Move the file away")
    assert path.read_bytes() == left


def test_export_writes_the_tables_of_results(cli, tmp_path):
    out = tmp_path / "out"
    cli("validate", "stop", "-e", "ghostball", "--out", out, "--no-report")
    result = cli("report", out, "--export", tmp_path / "there")
    assert result.exit_code == 0, result.output
    files = [Path(line) for line in result.stdout.splitlines()]
    assert {path.parent for path in files} == {tmp_path / "there"}
    assert {"cases.jsonl", "checks.csv", "events.csv"} <= {path.name for path in files}
    assert not (out / "report.html").exists()
    assert (tmp_path / "there" / "metrics.csv").read_text().startswith("scene,label,name,value\n")


# The workflow that `ghostball init --ci` writes


ROOT = Path(__file__).parents[4]


def workflow_of(folder):
    text = (folder / ".github/workflows/ghostball.yml").read_text("utf-8")
    return yaml.safe_load(text)["jobs"]["ghostball"]["steps"][-1]


def test_a_workflow_is_written_that_uses_the_action(cli, here):
    result = cli("init", "--ci")
    assert result.exit_code == 0, result.output
    assert result.stdout.split()[-1] == ".github/workflows/ghostball.yml"
    step = workflow_of(here)
    action = yaml.safe_load((ROOT / "action.yml").read_text("utf-8"))
    assert set(step["with"]) <= set(action["inputs"])
    assert "install" not in step["with"]  # the project is a file
    assert step["uses"] == f"{repository()}@COMMIT"
    assert (UNKNOWN_REPOSITORY in step["uses"]) == ("replace OWNER" in result.stderr)
    assert "COMMIT by the full hash" in " ".join(result.stderr.split())


def test_a_project_that_has_settings_gets_the_workflow_alone_and_once(cli, here):
    text = '[project]\nname = "mine"\n[tool.ghostball]\nengines = ["pymunk"]\n'
    (here / "pyproject.toml").write_text(text, "utf-8")
    assert "Edit that table" in cli("init", "--ci", "-e", "pymunk").stderr
    assert cli("init", "--ci").stdout.split() == [".github/workflows/ghostball.yml"]
    assert (here / "pyproject.toml").read_text("utf-8") == text
    assert workflow_of(here)["with"]["install"] == "."
    again = cli("init", "--ci")
    assert again.exit_code == 2
    assert "ghostball.yml: already exists" in again.stderr


@pytest.mark.parametrize(
    ("urls", "found"),
    [
        (["Source, https://github.com/some-one/ghost.ball"], "some-one/ghost.ball"),
        (["Source, https://github.com/a/b.git"], "a/b"),
        (["Docs, https://example.org"], UNKNOWN_REPOSITORY),
        ([], UNKNOWN_REPOSITORY),
    ],
)
def test_where_the_action_lies_is_what_the_installation_says(monkeypatch, urls, found):
    metadata = Message()
    for url in urls:
        metadata["Project-URL"] = url
    monkeypatch.setattr("ghostball.cli.show.init.metadata", lambda _: metadata)
    assert repository() == found
