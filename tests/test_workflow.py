"""The workflow of GitHub Actions: what it may do, and that its commands do what they are for."""

import os
import re
import stat
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from ghostball.engine.core.kernel_cache import cache_key
from ghostball.validation.results.store import Results

ROOT = Path(__file__).parent.parent
WORKFLOW = yaml.safe_load((ROOT / ".github/workflows/ghostball.yml").read_text(encoding="utf-8"))
SETUP = yaml.safe_load((ROOT / ".github/actions/setup/action.yml").read_text(encoding="utf-8"))
JOBS = WORKFLOW["jobs"]
STEPS = [step for job in JOBS.values() for step in job["steps"]] + SETUP["runs"]["steps"]


def test_it_runs_for_pushes_and_pull_requests():
    on = WORKFLOW[True]  # YAML 1.1 reads `on` as a truth value
    assert on["push"] == {"branches": ["main"]}
    assert "pull_request" in on
    assert "pull_request_target" not in on  # would run a fork's code with rights to write


def test_it_may_read_and_nothing_else():
    assert WORKFLOW["permissions"] == {"contents": "read"}
    assert not any("permissions" in job for job in JOBS.values())
    checkouts = [step for step in STEPS if step.get("uses", "").startswith("actions/checkout")]
    assert checkouts
    assert all(step["with"]["persist-credentials"] is False for step in checkouts)


def test_every_job_ends():
    assert all(0 < job["timeout-minutes"] <= 180 for job in JOBS.values())
    assert "pull_request.number" in WORKFLOW["concurrency"]["group"]


def test_actions_are_pinned_to_a_major_version():
    used = [step["uses"] for step in STEPS if "uses" in step]
    assert used
    foreign = [action for action in used if not action.startswith("./")]
    assert all(re.fullmatch(r"actions/[a-z-]+@v\d+", action) for action in foreign), foreign
    assert all((ROOT / action / "action.yml").exists() for action in set(used) - set(foreign))


def test_no_expression_is_pasted_into_a_command():
    # A branch's name may be a command: what comes from outside goes through the environment.
    assert not [step["run"] for step in STEPS if "${{" in step.get("run", "")]


def test_all_that_is_checked_is_checked():
    job = JOBS["check"]
    assert [step["run"] for step in job["steps"] if "run" in step] == [".ci/run $PARTS"]
    parts = [part for parts in job["strategy"]["matrix"]["parts"] for part in parts.split()]
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    needed = dict(re.findall(r"^([a-z]+): (.*?)  ## ", makefile, re.MULTILINE))
    at = parts.index("coverage")  # runs the tests that it measures
    # It measures every adapter, so it installs every engine; without, their tests are skipped.
    assert "engines" in needed["coverage"].split()
    parts[at : at + 1] = [part for part in needed["coverage"].split() if part != "engines"]
    assert sorted(parts) == sorted(needed["check"].split())


def test_the_gallery_installs_the_engines_that_it_draws():
    # On a clean clone it stopped at the first one.
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    (needed,) = re.findall(r"^gallery: (.*?)  ## ", makefile, re.MULTILINE)
    assert needed.split() == ["engines", "validate"]


def test_what_the_readme_says_runs_on_every_version_that_is_promised():
    promised = re.findall(
        r"Python :: (3\.\d+)", (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    )
    assert JOBS["readme"]["strategy"]["matrix"]["python"] == promised
    commands = [step["run"] for step in JOBS["readme"]["steps"] if "run" in step]
    assert commands == ["make validate", "make test"]
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert all(f"    {command} " in readme for command in commands)
    wheel = JOBS["wheel"]["strategy"]["matrix"]["python"]
    assert {promised[0], promised[-1]} <= set(wheel) <= set(promised)


def test_each_job_gets_its_own_kernels_back():
    # A key is written once: with one for all jobs, all but the first to end compile at every run.
    names = [
        (step["with"]["job"], step["with"].get("python", "3.11"))
        for job in JOBS.values()
        for step in job["steps"]
        if step.get("uses") == "./.github/actions/setup"
    ]
    assert len(names) == len(set(names)) == len(JOBS)
    kept = [step["with"] for step in SETUP["runs"]["steps"] if "cache" in step.get("uses", "")]
    (kernels,) = (one for one in kept if one["path"].endswith("/kernels"))
    assert all(part in kernels["key"] for part in ("inputs.job", "inputs.python", "hash.outputs"))
    assert "restore-keys" not in kernels  # other kernels are of no use, and would be carried along
    (proofs,) = (one for one in kept if one["path"].endswith("/proofs"))
    assert "inputs.job" in proofs["key"]


def test_the_key_of_the_kernels_is_the_name_of_their_folder(tmp_path):
    (command,) = (
        step["run"] for step in SETUP["runs"]["steps"] if "cache_key" in step.get("run", "")
    )
    binary = tmp_path / ".venv/bin/python"
    binary.parent.mkdir(parents=True)
    written = tmp_path / "output"
    environment = os.environ | {"GITHUB_OUTPUT": str(written), "PYTHONPATH": str(ROOT)}
    binary.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    binary.chmod(0o755)
    subprocess.run(["bash", "-e", "-c", command], cwd=tmp_path, env=environment, check=True)
    assert written.read_text() == f"kernels={cache_key()}\n"


def test_what_failed_is_shown_and_kept():
    steps = JOBS["validate"]["steps"]
    start = next(k for k, step in enumerate(steps) if step.get("name") == "Validate")
    for step in steps[start + 1 :]:
        assert step["if"].startswith("${{ !cancelled()"), step["name"]


def test_the_revision_to_compare_with_is_there():
    checkout = JOBS["validate"]["steps"][0]
    assert checkout["with"]["fetch-depth"] == 0


@pytest.fixture
def clone(tmp_path):
    """A clone of what is committed, whose environment is that of the tests."""
    scratch = tmp_path / "clone"
    subprocess.run(["git", "clone", "--quiet", ROOT, scratch], check=True)
    git = ["git", "-C", str(scratch)]
    subprocess.run([*git, "update-ref", "refs/remotes/origin/base", "HEAD"], check=True)
    binaries = scratch / ".venv/bin"
    binaries.mkdir(parents=True)
    for name, command in {"python": "", "ghostball": "-m ghostball"}.items():
        script = binaries / name
        script.write_text(f'#!/bin/sh\nexec "{sys.executable}" {command} "$@"\n')
        script.chmod(script.stat().st_mode | stat.S_IXUSR)
    (scratch / ".venv/.ready").touch()
    return scratch


@pytest.mark.slow
def test_the_commands_of_the_job_do_what_they_are_there_for(clone, tmp_path):
    # A command that is gone, an option that is renamed, a folder that isn't there break it.
    page = tmp_path / "summary.md"
    given = {
        "SCENES": "stop half-ball-cut",
        "OUT": JOBS["validate"]["env"]["OUT"],
        "GITHUB_STEP_SUMMARY": str(page),
        "GITHUB_BASE_REF": "base",
        "PYTHONPATH": str(clone),
        # The same bits, and neither the clone nor its base has to be compiled.
        "NUMBA_DISABLE_JIT": "1",
    }
    said = {}
    for step in JOBS["validate"]["steps"]:
        if "run" not in step:
            continue
        done = subprocess.run(
            ["bash", "-e", "-o", "pipefail", "-c", step["run"]],
            cwd=clone,
            env=os.environ | given,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, f"{step['name']}\n{done.stdout}{done.stderr}"
        said[step["name"]] = done.stdout
    results = clone / given["OUT"]
    assert {"results.db", "report.html"} <= {path.name for path in results.iterdir()}
    assert "<testsuites" in (results / "junit.xml").read_text(encoding="utf-8")
    text = page.read_text(encoding="utf-8")
    assert text.startswith("## ✓ Ghostball: ")
    assert "| half-ball-cut | exact ✓" in text
    assert "What changed against the accepted baselines" in text
    assert "2 of 2 cases are alike" in text
    # A repository that narrows its scenes waits for no others.
    for folder in (given["OUT"], "out/head"):
        assert Results.open(clone / folder).scene_names == given["SCENES"].split()


def test_every_report_is_kept():
    kept = [
        step["with"]["path"] for step in JOBS["validate"]["steps"] if "path" in step.get("with", {})
    ]
    assert "out/**/report.html" in kept
