"""The repository around the code: pinned versions, and workflows."""

from __future__ import annotations

import re
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, metadata
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

ROOT = Path(__file__).parents[1]
OLDEST = "3.11.0"
"""Debian 12 has 3.11.2, which is older than what some packages ask of 3.11."""

LINES = (ROOT / "constraints.txt").read_text().splitlines()
PINNED = [Requirement(line) for line in LINES if line and not line.startswith("#")]


@pytest.mark.parametrize("pinned", PINNED, ids=lambda pinned: pinned.name)
def test_a_pinned_version_can_be_installed_by_the_oldest_python(pinned):
    try:
        installed = metadata(pinned.name)
    except PackageNotFoundError:
        pytest.skip(f"{pinned.name} isn't installed")
    if not pinned.specifier.contains(installed["Version"], prereleases=True):
        pytest.skip(f"another version of {pinned.name} is installed: {installed['Version']}")
    accepted = SpecifierSet(",".join(installed.get_all("Requires-Python") or ()))
    assert accepted.contains(OLDEST), f"it needs Python {accepted}: pin an older one in `dev`"


# --- workflows: a fork's code gets no rights, and all of `make check` runs


def read(path):
    return yaml.safe_load((ROOT / ".github" / path).read_text(encoding="utf-8"))


WORKFLOW, RELEASE, WEEKLY = (
    read(f"workflows/{name}.yml") for name in ("ghostball", "release", "weekly")
)
JOBS = WORKFLOW["jobs"]
STEPS = [
    step for job in (JOBS | RELEASE["jobs"] | WEEKLY["jobs"]).values() for step in job["steps"]
]
STEPS += read("actions/setup/action.yml")["runs"]["steps"]


def test_a_job_with_a_right_is_of_main_or_of_a_release_and_runs_no_code():
    for workflow in (WORKFLOW, RELEASE, WEEKLY):
        assert workflow["permissions"] == {"contents": "read"}
    assert "pull_request_target" not in WORKFLOW[True]  # YAML 1.1 reads `on` as a truth value
    assert [name for name in JOBS if "permissions" in JOBS[name]] == ["pages"]
    assert [name for name in RELEASE["jobs"] if "permissions" in RELEASE["jobs"][name]] == [
        "publish"
    ]
    pages, publish = JOBS["pages"], RELEASE["jobs"]["publish"]
    assert pages["permissions"] == {"pages": "write", "id-token": "write"}
    assert publish["permissions"] == {"id-token": "write"}
    assert "github.ref == 'refs/heads/main'" in pages["if"]
    assert publish["if"] == "${{ github.event_name == 'release' }}"
    assert publish["needs"] == ["sdist", "wheel"]  # only what was built and tried
    assert not [step for job in (pages, publish) for step in job["steps"] if "run" in step]
    (kept,) = (step for step in JOBS["check"]["steps"] if "documentation" in str(step.get("with")))
    assert kept["with"]["name"] == pages["steps"][0]["with"]["name"]


def test_no_expression_is_pasted_into_a_command():
    # A branch's name may be a command: what comes from outside goes through the environment.
    assert not [step["run"] for step in STEPS if "${{" in step.get("run", "")]


def test_lowest_versions_are_those_that_are_allowed():
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    pins = subprocess.check_output([sys.executable, ROOT / ".ci/lowest"], text=True).splitlines()
    versions = dict(line.split("==") for line in pins if "==" in line)
    assert {"numpy", "numba", "scipy", "polars", "distributed"} <= set(versions)
    assert all(f'"{name}>={version}' in text for name, version in versions.items())


def test_foreign_actions_are_pinned_by_hash():
    """A tag can be moved to other code; one action is of one version everywhere."""
    files = [*(ROOT / ".github").rglob("*.yml"), ROOT / "action.yml"]
    texts = "\n".join(path.read_text("utf-8") for path in files)
    versions = set()
    for action, comment in re.findall(r"uses: (?!\./)(\S+)(.*)", texts):
        assert re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40}", action), action
        assert re.fullmatch(r" # v\d+\.\d+\.\d+", comment), action
        versions.add((action.partition("@")[0], action, comment))
    assert len(versions) == len({name for name, *_ in versions}) == 8


def test_each_week_tries_the_systems_of_which_there_are_wheels():
    systems = WEEKLY["jobs"]["systems"]["strategy"]["matrix"]["system"]
    released = RELEASE["jobs"]["wheel"]["strategy"]["matrix"]["system"]
    assert set(systems) == set(released) - {"ubuntu-24.04"}


def test_all_that_is_checked_is_checked():
    job = JOBS["check"]
    assert [step["run"] for step in job["steps"] if "run" in step] == [
        ".ci/run $PARTS",
        'make coverage-of-changes BASE="origin/$GITHUB_BASE_REF"',
    ]
    parts = [part for parts in job["strategy"]["matrix"]["parts"] for part in parts.split()]
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    needed = dict(re.findall(r"^([a-z]+): (.*?)  ## ", makefile, re.MULTILINE))
    at = parts.index("coverage")  # runs the tests that it measures
    # It measures every adapter, so it installs every engine; without, their tests are skipped.
    assert "engines" in needed["coverage"].split()
    parts[at : at + 1] = [part for part in needed["coverage"].split() if part != "engines"]
    assert sorted(parts) == sorted(needed["check"].replace("lint-and-docs", "lint docs").split())
