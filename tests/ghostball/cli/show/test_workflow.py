"""The workflow that `ghostball init --ci` writes."""

from __future__ import annotations

from email.message import Message
from pathlib import Path

import pytest
import yaml

from ghostball.cli.show.workflow import UNKNOWN, repository

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
    assert step["uses"] == f"{repository()}@v1"
    assert (UNKNOWN in step["uses"]) == ("doesn't say which" in result.stderr)


def test_a_project_that_has_settings_gets_the_workflow_alone_and_once(cli, here):
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
