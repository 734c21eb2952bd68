"""The environment of a run, stored with its results: machine, versions and code revision."""

from __future__ import annotations

import os
import platform
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from ghostball.validation.parallel.sources import versions
from ghostball.validation.results.git import GitError, run_git


def describe_environment() -> dict[str, Any]:
    """Return machine, versions, revision and command line as plain values."""
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": [Path(sys.argv[0]).name, *sys.argv[1:]],
        "cpu": cpu_name(),
        "cores": os.cpu_count(),
        "os": platform.platform(),
        "python": platform.python_version(),
        "versions": versions(),
        "git": git_state(Path(__file__).resolve().parents[2]),
    }


def cpu_name() -> str:
    """Return the processor's model name, or its architecture if the system hides the name."""
    return _cpu("model name") or platform.processor() or platform.machine()


def cpu_flags() -> str:
    """Return the instruction set features of the processor, or "" if the system hides them."""
    return _cpu("flags", "Features")


def _cpu(*fields: str) -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:  # not Linux
        return ""
    return next((x.partition(":")[2].strip() for x in lines if x.startswith(fields)), "")


def git_state(root: Path) -> dict[str, Any] | None:
    """Return the git revision and whether there are changes; None if `root` is no checkout.

    A package that is installed inside another repository isn't a checkout of Ghostball.
    """
    if not (root / ".git").exists():
        return None
    try:
        revision = run_git(root, "rev-parse", "HEAD")
        changes = run_git(root, "status", "--porcelain")
    except GitError:  # git isn't installed, or there is no commit yet
        return None
    return {"revision": revision, "dirty": bool(changes)}
