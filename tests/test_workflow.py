"""The workflow of GitHub Actions: a fork's code gets no rights, and all of `make check` runs."""

import re
import subprocess
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).parent.parent
WORKFLOW = yaml.safe_load((ROOT / ".github/workflows/ghostball.yml").read_text(encoding="utf-8"))
SETUP = yaml.safe_load((ROOT / ".github/actions/setup/action.yml").read_text(encoding="utf-8"))
RELEASE = yaml.safe_load((ROOT / ".github/workflows/release.yml").read_text(encoding="utf-8"))
WEEKLY = yaml.safe_load((ROOT / ".github/workflows/weekly.yml").read_text(encoding="utf-8"))
JOBS = WORKFLOW["jobs"]
STEPS = [
    *(step for job in JOBS.values() for step in job["steps"]),
    *(step for job in (RELEASE["jobs"] | WEEKLY["jobs"]).values() for step in job["steps"]),
    *SETUP["runs"]["steps"],
]


def test_it_may_read_and_nothing_else():
    assert WORKFLOW["permissions"] == {"contents": "read"}
    assert "pull_request_target" not in WORKFLOW[True]  # YAML 1.1 reads `on` as a truth value


def test_the_one_job_that_may_publish_is_of_main_and_runs_no_code():
    assert [name for name in JOBS if "permissions" in JOBS[name]] == ["pages"]
    pages = JOBS["pages"]
    assert pages["permissions"] == {"pages": "write", "id-token": "write"}
    assert "github.ref == 'refs/heads/main'" in pages["if"]
    assert not [step for step in pages["steps"] if "run" in step]
    (kept,) = (step for step in JOBS["check"]["steps"] if "documentation" in str(step.get("with")))
    assert kept["with"]["name"] == pages["steps"][0]["with"]["name"]


def test_lowest_versions_are_those_that_are_allowed():
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    run = subprocess.run(
        [sys.executable, ROOT / ".ci/lowest"], capture_output=True, text=True, check=True
    )
    pins = [line.split("==") for line in run.stdout.splitlines() if "==" in line]
    assert {"numpy", "numba", "scipy", "polars", "distributed"} <= {name for name, _ in pins}
    assert all(f'"{name}>={version}' in text for name, version in pins)


def test_foreign_actions_are_pinned_by_hash():
    """A tag can be moved to other code; one action is of one version everywhere."""
    files = [*(ROOT / ".github").rglob("*.yml"), ROOT / "action.yml"]
    found = re.findall(
        r"uses: (?!\./)(\S+)(.*)", "\n".join(path.read_text("utf-8") for path in files)
    )
    versions = set()
    for action, comment in found:
        assert re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40}", action), action
        assert re.fullmatch(r" # v\d+\.\d+\.\d+", comment), action
        versions.add((action.partition("@")[0], action, comment))
    assert len(versions) == len({name for name, *_ in versions}) == 8


def test_each_week_tries_the_systems_of_which_there_are_wheels():
    systems = WEEKLY["jobs"]["systems"]["strategy"]["matrix"]["system"]
    released = RELEASE["jobs"]["wheel"]["strategy"]["matrix"]["system"]
    assert set(systems) == set(released) - {"ubuntu-24.04"}


def test_forms_ask_for_each_thing_once_and_name_pages_that_are_there():
    forms = sorted((ROOT / ".github/ISSUE_TEMPLATE").glob("*.yml"))
    assert len(forms) > 1
    for path in forms:
        form = yaml.safe_load(path.read_text("utf-8"))
        fields = [part for part in form.get("body", ()) if part["type"] != "markdown"]
        assert len({field["id"] for field in fields}) == len(fields)
        for named in re.findall(r"docs/[\w/.-]+\w", path.read_text("utf-8")):
            assert (ROOT / named).exists(), named


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
    assert sorted(parts) == sorted(needed["check"].replace("lint-and-docs", "lint docs").split())


def test_the_one_job_of_a_release_with_a_right_runs_no_code_of_ours():
    assert WEEKLY["permissions"] == RELEASE["permissions"] == {"contents": "read"}
    jobs = RELEASE["jobs"]
    assert [name for name in jobs if "permissions" in jobs[name]] == ["publish"]
    assert jobs["publish"]["permissions"] == {"id-token": "write"}
    assert jobs["publish"]["needs"] == ["sdist", "wheel"]  # only what was built and tried
    assert jobs["publish"]["if"] == "${{ github.event_name == 'release' }}"
    assert not [step for step in jobs["publish"]["steps"] if "run" in step]
