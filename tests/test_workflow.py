"""The workflow of GitHub Actions: a fork's code gets no rights, and all of `make check` runs."""

import re
from pathlib import Path

import yaml

ROOT = Path(__file__).parent.parent
WORKFLOW = yaml.safe_load((ROOT / ".github/workflows/ghostball.yml").read_text(encoding="utf-8"))
SETUP = yaml.safe_load((ROOT / ".github/actions/setup/action.yml").read_text(encoding="utf-8"))
RELEASE = yaml.safe_load((ROOT / ".github/workflows/release.yml").read_text(encoding="utf-8"))
JOBS = WORKFLOW["jobs"]
STEPS = [
    *(step for job in (JOBS | RELEASE["jobs"]).values() for step in job["steps"]),
    *SETUP["runs"]["steps"],
]


def test_it_may_read_and_nothing_else():
    assert WORKFLOW["permissions"] == {"contents": "read"}
    assert "pull_request_target" not in WORKFLOW[True]  # YAML 1.1 reads `on` as a truth value


def test_no_expression_is_pasted_into_a_command():
    # A branch's name may be a command: what comes from outside goes through the environment.
    assert not [step["run"] for step in STEPS if "${{" in step.get("run", "")]


def test_all_that_is_checked_is_checked():
    job = JOBS["check"]
    run, changes = (step["run"] for step in job["steps"] if "run" in step)
    assert run == ".ci/run $PARTS"
    assert changes == 'make coverage-of-changes BASE="origin/$GITHUB_BASE_REF"'
    parts = [part for parts in job["strategy"]["matrix"]["parts"] for part in parts.split()]
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    needed = dict(re.findall(r"^([a-z]+): (.*?)  ## ", makefile, re.MULTILINE))
    at = parts.index("coverage")  # runs the tests that it measures
    # It measures every adapter, so it installs every engine; without, their tests are skipped.
    assert "engines" in needed["coverage"].split()
    parts[at : at + 1] = [part for part in needed["coverage"].split() if part != "engines"]
    assert sorted(parts) == sorted(needed["check"].split())


def test_a_release_is_published_from_wheels_of_every_platform_that_were_tried():
    assert RELEASE["permissions"] == {"contents": "read"}
    jobs = RELEASE["jobs"]
    systems = jobs["wheel"]["strategy"]["matrix"]["system"]
    linux, macos, windows = systems[:2], systems[2:4], systems[4:]
    assert linux == ["ubuntu-24.04", "ubuntu-24.04-arm"]
    assert macos == ["macos-15-intel", "macos-15"]
    assert windows == ["windows-2025", "windows-11-arm"]
    (build,) = (step for step in jobs["wheel"]["steps"] if "pip wheel" in step.get("run", ""))
    assert build["env"]["GHOSTBALL_BUILD_KERNELS"] == "1"
    assert jobs["publish"]["needs"] == ["sdist", "wheel"]
    assert jobs["publish"]["if"] == "${{ github.event_name == 'release' }}"
    # The one job with a right, that to say who it is, runs no code of ours.
    assert [name for name in jobs if "permissions" in jobs[name]] == ["publish"]
    assert jobs["publish"]["permissions"] == {"id-token": "write"}
    assert not [step for step in jobs["publish"]["steps"] if "run" in step]
