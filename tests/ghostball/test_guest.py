"""Installed in another project's environment, ghostball doesn't meet that project's packages.

Broken by: a part of it that is imported, or found, by a name that others use too.
"""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

NAMES = ("engine", "reference_adapters", "validation", "reports")


@pytest.fixture
def project(tmp_path):
    """A project that has a package of each name, and an engine of its own."""
    for name in NAMES:
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("whose = 'theirs'\n")
    (tmp_path / "engine" / "mine.py").write_text(
        "from ghostball.validation.examples.stepper import Stepper\n\n\n"
        "class Mine(Stepper):\n    name = 'mine'\n"
    )
    return tmp_path


def run(project, *arguments):
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=project,
        env=os.environ | {"PYTHONPATH": str(project), "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


THEIRS = "; ".join(f"import {name}; assert {name}.whose == 'theirs'" for name in NAMES)
OURS = "; ".join(f"import ghostball.{name}" for name in NAMES) + (
    "; from ghostball import Results, Scene, find_scene, simulate"
    "; assert isinstance(find_scene('stop'), Scene)"
)


def test_both_are_imported(project):
    run(project, "-c", f"{OURS}; {THEIRS}")


def test_the_plugin_of_pytest_finds_an_engine_in_a_package_called_engine(project):
    printed = run(
        project, "-m", "pytest", "-q", "--rootdir", ".", "--collect-only",
        "--ghostball", "--ghostball-engine", "engine.mine:Mine",
    )  # fmt: skip
    assert "stop" in printed


@pytest.mark.checkout
def test_by_its_short_name_a_part_refuses_to_be_a_second_one(pytestconfig):
    for name in NAMES:
        done = subprocess.run(
            [sys.executable, "-c", f"import {name}"],
            cwd=pytestconfig.rootpath,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 1
        assert f"is part of ghostball: import `ghostball.{name}`" in done.stderr
