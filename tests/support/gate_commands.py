"""`ghostball regress` and `accept`, run in the process of a test, in its working directory."""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path

from commands import cli


def regress(*arguments, scenes=("cut.toml", "roll.toml")):
    return cli("regress", *scenes, "--baselines", "accepted", *arguments)


def accept(*arguments, reason="It is right."):
    return cli("accept", "--baselines", "accepted", "--reason", reason, *arguments)


def edit_engine(old, new):
    path = Path("my_engine.py")
    text = path.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new), "utf-8")
    # Bytecode is of a file of this size and second: an edit of the same size comes a second later.
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


BASELINES = Path(__file__).parents[2] / "benchmarks" / "baselines"
"""Those of our own engine, in this repository."""
