"""A scratch repository with measurements that are committed, changed, renamed and damaged."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

PLACE = Path("benchmarks") / "results"


class Repository:
    """A repository of its own; each `commit` is a day later than the one before."""

    def __init__(self, path: Path) -> None:
        self.path, self.day = path, 0
        path.mkdir()
        self.git("init", "--quiet", "--initial-branch=main")
        (path / "pyproject.toml").touch()

    def git(self, *arguments: str) -> str:
        """Run git there, with nobody's settings."""
        nobody = {
            f"GIT_{who}_{what}": "a@b"
            for who in ("AUTHOR", "COMMITTER")
            for what in ("NAME", "EMAIL")
        }
        nowhere = {"GIT_CONFIG_GLOBAL": os.devnull, "GIT_CONFIG_NOSYSTEM": "1"}
        done = subprocess.run(
            ["git", "-C", str(self.path), *arguments],
            env={**os.environ, **nobody, **nowhere},
            check=True,
            capture_output=True,
            text=True,
        )
        return done.stdout

    def put(self, name: str, content: dict[str, Any] | str) -> None:
        """Write a file of measurements."""
        path = self.path / PLACE / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content if isinstance(content, str) else json.dumps(content, indent=2))

    def commit(self) -> str:
        """Commit everything and return the revision."""
        self.git("add", "--all")
        self.git("commit", "--quiet", "--message=x")
        return self.git("rev-parse", "HEAD").strip()


def environment(revision: str, day: int, *, dirty: bool = False) -> dict[str, Any]:
    """Where and when something was measured."""
    date = f"2026-01-{day:02}T00:00:00+00:00"
    return {"date": date, "cpu": "c", "cores": 2, "git": {"revision": revision, "dirty": dirty}}


def targets(revision: str, day: int, seconds: float, *, dirty: bool = False) -> dict[str, Any]:
    """A measurement of the targets with two quantities, of which one is counted."""
    row = {"workload": "break", "title": "t", "samples": 3, "target_kind": "at_most"}
    spread = {"median": seconds, "least": 0.9 * seconds, "greatest": 1.5 * seconds}
    count = {"median": 347.0, "least": 347.0, "greatest": 347.0, "target": 400.0}
    return {
        "schema": 1,
        "kind": "targets",
        "environment": environment(revision, day, dirty=dirty),
        "rounds": 3,
        "rows": [
            {**row, "quantity": "kernel", "unit": "s", **spread, "target": 3e-5},
            {**row, "quantity": "bytes_per_ball", "unit": "B", **count},
        ],
    }
