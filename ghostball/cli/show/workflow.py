"""The workflow that `ghostball init --ci` writes: it guards an engine by Ghostball's own action."""

from __future__ import annotations

import re
from importlib.metadata import metadata
from pathlib import Path

WORKFLOW = Path(".github/workflows/ghostball.yml")

UNKNOWN = "OWNER/ghostball"
"""Stands for the repository where the installation doesn't say where that is."""

_TEXT = """\
# Plays billiard shots on the engine of this project, and compares them with the truth and with what
# was accepted. Which engine, which scenes and what fails stands in [tool.ghostball] of
# pyproject.toml. A run without baselines says what to commit.

name: ghostball

on:
  push:
    branches: [main]
  pull_request:

permissions:
  contents: read

jobs:
  ghostball:
    runs-on: ubuntu-latest
    steps:
      - uses: actions/checkout@v6
        with:
          persist-credentials: false
      - uses: {action}@v1
        with:
          fail-on: changed # or worse: only what moved away from the truth
{install}"""

_INSTALL = "          install: . # what the engine needs is installed with it\n"


def repository() -> str:
    """Return where Ghostball lies on GitHub, as "account/name", as its installation says it."""
    for one in metadata("ghostball").get_all("Project-URL") or ():
        if found := re.search(r"github\.com/([\w.-]+/[\w.-]+?)(?:\.git)?/?$", one):
            return found[1]
    return UNKNOWN


def workflow_text(*, package: bool) -> str:
    """Return the workflow's file; `package`: whether the project is one that pip installs."""
    return _TEXT.format(action=repository(), install=_INSTALL if package else "")
