"""`[tool.ghostball]`: every command that reads wrong settings rejects them."""

from __future__ import annotations

import errno
import os

import pytest
import tomli_w
from commands import refused
from damage import DEEP, VALUES, assert_refused_or_done, faults, reads

from ghostball.cli.shared import config
from ghostball.cli.shared.config import load_config
from ghostball.model.text_files import read_text


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            'engins = ["ghostball"]',
            "`tool.ghostball.engins` is not a known setting. Did you mean `engines`?",
        ),
        ("engines = [1]", "`tool.ghostball.engines[0]` must be a valid string, got 1"),
        ('scenes = ["none-such"]', 'unknown scene or tag "none-such"'),
        ('scenes = ["none-such/*.toml"]', "matches no shipped scene and no TOML file"),
        ("engines = [", "not valid TOML"),
    ],
)
def test_a_configuration_that_is_wrong_is_refused(cli, tmp_path, monkeypatch, text, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pyproject.toml").write_text(f"[tool.ghostball]\n{text}\n", "utf-8")
    for command in ("regress", "validate"):
        assert refused(cli(command), said)
    assert not (tmp_path / "out").exists()


def test_a_file_without_permission_is_refused(cli, tmp_path, monkeypatch):
    (tmp_path / "pyproject.toml").write_text("[tool.ghostball]\n")
    monkeypatch.chdir(tmp_path)

    def forbidden(path):
        if path.resolve().parent == tmp_path:
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        return read_text(path)

    monkeypatch.setattr(config, "read_text", forbidden)
    for command in ("regress", "validate", "init"):
        assert refused(cli(command), "pyproject.toml: can't be read: Permission denied")
    access = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: path != tmp_path and access(path, mode))
    # A folder without permission isn't searched for a project.
    assert load_config() == config.Config()


def test_settings_of_another_shape_are_refused(tmp_path, monkeypatch):
    valid = {"engines": ["pymunk"], "scenes": ["smoke"], "baselines": "baselines", "out": "out"}
    values = [value for value in VALUES if value is not None and value != "\ud800"]
    every = ["[tool.ghostball]\na = " + DEEP, "[tool.ghostball", "tool = 3"]
    every += [tomli_w.dumps({"tool": {"ghostball": one}}) for one in faults(valid, values)]
    file = tmp_path / "pyproject.toml"

    def read(path):
        load_config(path.parent)

    assert reads(read, file, tomli_w.dumps({"tool": {"ghostball": valid}}))
    assert sum(reads(read, file, one) for one in every) < len(every) / 2
    monkeypatch.chdir(tmp_path)
    file.write_text("[tool.ghostball]\nscenes = " + DEEP)
    assert_refused_or_done("validate", "--no-report")
