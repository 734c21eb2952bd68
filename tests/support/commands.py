"""Run commands in the process of a test, and check their results."""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from ghostball.cli import app

Result = Any
"""Result type of typer's runner."""

HEAD = 'schema = 1\nname = "shot"\n[table]\nlength = 2.0\nwidth = 1.0\n'
"""Start of a scene file, before the balls."""


def ball(name: str = "cue", x: str = "0.5", extra: str = "") -> str:
    """Return the TOML of a ball that moves along x, for a scene file."""
    return f'[[balls]]\nid = "{name}"\nposition = [{x}, 0.5]\nvelocity = [1.0, 0.0]\n{extra}'


def cli(*arguments: object) -> Result:
    """Run a command as a user types it."""
    result = CliRunner().invoke(app, [*map(str, arguments)])
    assert "\x1b" not in result.output, "control codes without a terminal"
    return result


def regress(*arguments, scenes=("cut.toml", "roll.toml")):
    return cli("regress", *scenes, "--baselines", "accepted", *arguments)


def accept(*arguments, reason="It is right."):
    return cli("accept", "--baselines", "accepted", "--reason", reason, *arguments)


def edit_engine(old, new):
    path = Path("my_engine.py")
    text = path.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new), "utf-8")
    # Python reuses bytecode if size and second of the file are unchanged, so the time is advanced.
    edited = path.stat().st_mtime + 1.0
    os.utime(path, (edited, edited))
    importlib.invalidate_caches()
    sys.modules.pop("my_engine", None)


def write_config(folder, **settings):
    lines = [f"{key} = {value!r}" for key, value in settings.items()]
    text = "\n".join(["[tool.ghostball]", *lines])
    (folder / "pyproject.toml").write_text(text, "utf-8")


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def refused(result: Result, *parts: str) -> bool:
    """Assert that the input was rejected with one message, without a traceback and a result.

    `parts`: texts that the message must contain.
    """
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    said = " ".join(result.stderr.split())
    for part in parts:
        assert part in said
    return True


BASELINES = Path(__file__).parents[2] / "benchmarks" / "baselines"
"""Baselines of Ghostball's engine in this repository."""
