"""What is noted of machine and revision."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

from ghostball.reference_adapters.javascript import packages as javascript
from ghostball.reference_adapters.workers.process import DISTRIBUTIONS
from ghostball.validation.parallel.sources import PACKAGES
from ghostball.validation.results.environment import describe_environment, git_state


def test_the_description_is_plain_and_complete() -> None:
    described = json.loads(json.dumps(describe_environment()))
    assert set(described) == {
        *("date", "command", "cpu", "cores", "os", "python", "versions", "git")
    }
    assert list(described["versions"]) == [
        *PACKAGES,
        *DISTRIBUTIONS,
        javascript.NODE,
        *javascript.PACKAGES,
    ]
    assert described["versions"]["numpy"]
    assert described["cpu"]


def test_a_folder_inside_a_repository_is_not_that_repository(tmp_path: Path) -> None:
    # Else a package in someone's virtual environment would report their revision as its own.
    git(tmp_path, "init", "--quiet")
    inside = tmp_path / "site-packages"
    inside.mkdir()
    assert git_state(inside) is None
    assert git_state(tmp_path) is None  # no commit yet


def test_changes_make_a_checkout_dirty(tmp_path: Path) -> None:
    git(tmp_path, "init", "--quiet")
    git(tmp_path, "-c", "user.name=a", "-c", "user.email=a@b", "commit", "--allow-empty", "-mx")
    clean = git_state(tmp_path)
    assert clean is not None
    assert len(clean["revision"]) == 40
    assert clean["dirty"] is False
    (tmp_path / "new").write_text("")
    assert git_state(tmp_path) == {"revision": clean["revision"], "dirty": True}


def git(folder: Path, *arguments: str) -> None:
    subprocess.run(["git", "-C", str(folder), *arguments], check=True, capture_output=True)
