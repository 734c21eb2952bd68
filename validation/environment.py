"""Where and with what a run was made: kept with its results, for numbers mean little without."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

PACKAGES = (
    "ghostball",
    "numpy",
    "numba",
    "llvmlite",
    "pymunk",
    "pybullet",
    "mpmath",
    "python-flint",
    "pydantic",
)
"""Distributions whose versions can change a number."""

_GIT_TIMEOUT = 10.0
"""Seconds: a repository on a slow disk answers within one."""


def describe_environment() -> dict[str, Any]:
    """Return machine, versions, revision and command line as plain values."""
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": [Path(sys.argv[0]).name, *sys.argv[1:]],
        "cpu": cpu_name(),
        "cores": os.cpu_count(),
        "os": platform.platform(),
        "python": platform.python_version(),
        "versions": {name: _version(name) for name in PACKAGES},
        "git": git_state(Path(__file__).resolve().parent.parent),
    }


def cpu_name() -> str:
    """Return the processor's model name, or its architecture where the system hides the name."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:  # not Linux
        return platform.processor() or platform.machine()
    models = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(models, platform.machine())


def cpu_flags() -> str:
    """Return what the processor says that it can do, "" where the system hides it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:  # not Linux
        return ""
    flags = (line.partition(":")[2] for line in lines if line.startswith(("flags", "Features")))
    return next(flags, "").strip()


def git_state(root: Path) -> dict[str, Any] | None:
    """Return revision and whether files differ from it, or None where `root` is no checkout.

    A package installed inside someone else's repository is no checkout of ours.
    """
    if not (root / ".git").exists():
        return None
    try:
        revision = _git(root, "rev-parse", "HEAD")
        changes = _git(root, "status", "--porcelain")
    except (OSError, subprocess.SubprocessError):  # no git here, or no commit yet
        return None
    return {"revision": revision, "dirty": bool(changes)}


def _git(root: Path, *arguments: str) -> str:
    finished = subprocess.run(
        ["git", "-C", str(root), *arguments],
        capture_output=True,
        text=True,
        check=True,
        timeout=_GIT_TIMEOUT,
    )
    return finished.stdout.strip()


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
