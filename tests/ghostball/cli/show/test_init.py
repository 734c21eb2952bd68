"""`ghostball init`: what it writes runs, and nothing is overwritten; lists of what there is."""

from __future__ import annotations

import tomllib


def test_a_project_begins_with_two_files(cli, here):
    result = cli("init")
    assert result.exit_code == 0, result.output
    assert result.stdout.split() == ["my_engine.py", "pyproject.toml"]
    assert "ghostball regress" in result.stderr
    table = tomllib.loads((here / "pyproject.toml").read_text("utf-8"))["tool"]["ghostball"]
    assert table["engines"] == ["my_engine:simulate"]
    assert cli("run", "stop", "-e", "my_engine:simulate").exit_code == 0


def test_what_a_project_has_stays(cli, here):
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


def test_a_file_that_is_there_is_not_overwritten(cli, here):
    (here / "my_engine.py").write_text("mine = 1\n", "utf-8")
    result = cli("init")
    assert result.exit_code == 2
    assert "my_engine.py: is there already" in result.stderr
    assert (here / "my_engine.py").read_text("utf-8") == "mine = 1\n"
    assert not (here / "pyproject.toml").exists()


def test_an_engine_that_is_not_there_is_refused(cli, here):
    assert "pymonk" in cli("init", "-e", "pymonk").stderr
    assert list(here.iterdir()) == []
