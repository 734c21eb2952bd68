"""`ghostball init`: what it writes runs, and nothing is overwritten; lists of what there is."""

from __future__ import annotations

import sys
import tomllib
from email.message import Message
from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner

from ghostball.cli import app
from ghostball.cli.show.lists import _version
from ghostball.cli.show.workflow import UNKNOWN, repository
from ghostball.reference_adapters import engine_class

ROOT = Path(__file__).parents[4]


@pytest.fixture
def here(tmp_path, monkeypatch, in_this_process):
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    sys.modules.pop("my_engine", None)


def cli(*arguments):
    return CliRunner().invoke(app, [*map(str, arguments)])


def test_a_project_begins_with_two_files(here):
    result = cli("init")
    assert result.exit_code == 0, result.output
    assert result.stdout.split() == ["my_engine.py", "pyproject.toml"]
    assert "ghostball regress" in result.stderr
    table = tomllib.loads((here / "pyproject.toml").read_text("utf-8"))["tool"]["ghostball"]
    assert table["engines"] == ["my_engine:simulate"]
    assert cli("run", "stop", "-e", "my_engine:simulate").exit_code == 0


def test_what_a_project_has_stays(here):
    (here / "pyproject.toml").write_text('[project]\nname = "mine"\n', "utf-8")
    assert cli("init", "-e", "pymunk").exit_code == 0
    plain = tomllib.loads((here / "pyproject.toml").read_text("utf-8"))
    assert plain["project"] == {"name": "mine"}
    assert plain["tool"]["ghostball"]["engines"] == ["pymunk"]
    assert not (here / "my_engine.py").exists()
    before = (here / "pyproject.toml").read_bytes()
    again = cli("init")
    assert again.exit_code == 2
    assert "has `[tool.ghostball]` already" in again.stderr
    assert (here / "pyproject.toml").read_bytes() == before


def test_a_file_that_is_there_is_not_overwritten(here):
    (here / "my_engine.py").write_text("mine = 1\n", "utf-8")
    result = cli("init")
    assert result.exit_code == 2
    assert "my_engine.py: is there already" in result.stderr
    assert (here / "my_engine.py").read_text("utf-8") == "mine = 1\n"
    assert not (here / "pyproject.toml").exists()


def workflow_of(folder):
    text = (folder / ".github/workflows/ghostball.yml").read_text("utf-8")
    return yaml.safe_load(text)["jobs"]["ghostball"]["steps"][-1]


def test_a_workflow_is_written_that_uses_the_action(here):
    result = cli("init", "--ci")
    assert result.exit_code == 0, result.output
    assert result.stdout.split()[-1] == ".github/workflows/ghostball.yml"
    step = workflow_of(here)
    action = yaml.safe_load((ROOT / "action.yml").read_text("utf-8"))
    assert set(step["with"]) <= set(action["inputs"])
    assert "install" not in step["with"]  # the project is a file
    assert step["uses"] == f"{repository()}@v1"
    assert (UNKNOWN in step["uses"]) == ("doesn't say which" in result.stderr)


def test_a_project_that_has_settings_gets_the_workflow_alone_and_once(here):
    text = '[project]\nname = "mine"\n[tool.ghostball]\nengines = ["pymunk"]\n'
    (here / "pyproject.toml").write_text(text, "utf-8")
    assert "Edit it there" in cli("init", "--ci", "-e", "pymunk").stderr
    assert cli("init", "--ci").stdout.split() == [".github/workflows/ghostball.yml"]
    assert (here / "pyproject.toml").read_text("utf-8") == text
    assert workflow_of(here)["with"]["install"] == "."
    again = cli("init", "--ci")
    assert again.exit_code == 2
    assert "ghostball.yml: is there already" in again.stderr


@pytest.mark.parametrize(
    ("urls", "found"),
    [
        (["Source, https://github.com/some-one/ghost.ball"], "some-one/ghost.ball"),
        (["Source, https://github.com/a/b.git"], "a/b"),
        (["Docs, https://example.org"], UNKNOWN),
        ([], UNKNOWN),
    ],
)
def test_where_the_action_lies_is_what_the_installation_says(monkeypatch, urls, found):
    metadata = Message()
    for url in urls:
        metadata["Project-URL"] = url
    monkeypatch.setattr("ghostball.cli.show.workflow.metadata", lambda _: metadata)
    assert repository() == found


def test_an_engine_that_is_not_there_is_refused(here):
    assert "pymonk" in cli("init", "-e", "pymonk").stderr
    assert list(here.iterdir()) == []


def test_lists_are_for_programs_too(here):
    for command in ("scenes", "metrics"):
        assert cli(command, "--format", "json").stdout.startswith(f'{{"{command}": ')
    assert cli("scenes", "stop").stdout.startswith("schema = 1\n")
    assert "half-ball-cut" in cli("scenes", "smoke").stdout
    assert "around-the-table" not in cli("scenes", "smoke").stdout
    assert "rest_error_max" in cli("metrics").stdout
    assert "pymunk  available" in cli("engines", "pymunk").stdout
    assert "paper-discrete" not in cli("engines", "pymunk").stdout


@pytest.mark.parametrize(("text", "jobs"), [("auto", 7), ("3", 3)])
def test_jobs_are_a_number_or_all_processors(monkeypatch, text, jobs):
    from ghostball.cli.shared.options import processors

    monkeypatch.setattr("ghostball.cli.shared.options.processor_count", lambda: 7)
    assert processors(text) == jobs


def test_the_shell_completes_scenes_tags_and_engines():
    from ghostball.cli.shared.options import complete_engine, complete_scene

    assert complete_scene("half-ball-c") == ["half-ball-cut"]
    assert "smoke" in complete_scene("smo")
    assert complete_engine("pym") == ["pymunk"]


def test_the_table_of_engines_fits_a_terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    lines = cli("engines").stdout.splitlines()
    assert max(map(len, lines)) <= 80
    assert len(lines) < 60
    assert "".join(lines).count(" pymunk ") == 1


def test_the_version_of_an_engine_in_javascript_is_that_of_its_own_package(monkeypatch):
    # Breaks where a Python distribution of that name is asked, which is other people's.
    monkeypatch.setattr("ghostball.cli.show.lists.installed", lambda: {"planck": "1.4.2"})
    monkeypatch.setattr("ghostball.cli.show.lists.version", lambda _: "9.9.9")
    assert _version(engine_class("planck")) == "1.4.2"
    assert _version(engine_class("p2")) == ""
    assert _version(engine_class("pymunk")) == "9.9.9"


def test_a_recipe_is_code_of_that_engine_alone():
    found = cli("engines", "pymunk", "--recipe")
    assert found.exit_code == 0, found.output
    compile(found.stdout, "recipe", "exec")
    assert "import pymunk" in found.stdout
    assert "ghostball" not in found.stdout
    assert "has no recipe" in cli("engines", "ghostball", "--recipe").stderr
    assert (
        "needs an engine: box2d, box2d3, dart, mujoco, physx, pybullet, pymunk, rapier"
        in cli("engines", "--recipe").stderr
    )
