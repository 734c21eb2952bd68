"""Fixtures that run commands in the process of the tests."""

import sys

import commands
import pytest

import ghostball.reference_adapters.pybullet.loading


@pytest.fixture
def cli_with_processes(monkeypatch):
    """Run a command in this process with lines of 200 characters; engines in other processes."""
    monkeypatch.setenv("COLUMNS", "200")
    return commands.cli


@pytest.fixture
def cli(cli_with_processes, in_this_process):
    """Run a command and its engines in this process, because starting a process takes a second."""
    return cli_with_processes


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Work in an empty folder, for a new project."""
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    sys.modules.pop("my_engine", None)


@pytest.fixture
def without_pybullet(monkeypatch):
    reason = "pybullet isn't installed. Run `python -m pip install pybullet`"
    monkeypatch.setattr(
        ghostball.reference_adapters.pybullet.loading, "unavailable", lambda: reason
    )
