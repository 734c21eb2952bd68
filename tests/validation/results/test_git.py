"""Fails where git answers for another repository, or its refusal is no error of ours."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from ghostball.validation.results.environment import git_state
from ghostball.validation.results.git import GitError, run_git


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    return make(tmp_path / "checkout", "first")


def make(folder: Path, message: str) -> Path:
    folder.mkdir()
    run_git(folder, "init", "--quiet")
    who = ("-c", "user.name=a", "-c", "user.email=a@b")
    run_git(folder, *who, "commit", "--quiet", "--allow-empty", "-m", message)
    return folder


def test_what_git_prints_is_returned_stripped(checkout: Path) -> None:
    assert run_git(checkout, "log", "--format=%s") == "first"


def test_a_hook_of_another_repository_changes_nothing(
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Breaks where the variables that git sets for a hook reach the git that is asked."""
    before = git_state(checkout)
    other = make(tmp_path / "other", "second")
    (other / "new").touch()
    monkeypatch.setenv("GIT_DIR", str(other / ".git"))
    monkeypatch.setenv("GIT_WORK_TREE", str(other))
    monkeypatch.setenv("GIT_INDEX_FILE", str(other / ".git" / "index"))
    assert run_git(checkout, "log", "--format=%s") == "first"
    assert git_state(checkout) == before
    assert before is not None
    assert before["dirty"] is False


def test_a_refusal_is_an_error_with_what_git_says(checkout: Path) -> None:
    with pytest.raises(GitError, match=r"`git show nosuch` failed: fatal: .*nosuch"):
        run_git(checkout, "show", "nosuch")


def test_git_that_is_not_there_is_an_error_and_no_state(
    checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", "")
    with pytest.raises(GitError, match=r"`git` can't be run: .*\. Install it"):
        run_git(checkout, "status")
    assert git_state(checkout) is None


def test_git_that_does_not_end_is_an_error(checkout: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def slow(*_arguments: object, timeout: float, **_options: object) -> None:
        raise subprocess.TimeoutExpired("git", timeout)

    monkeypatch.setattr(subprocess, "run", slow)
    with pytest.raises(GitError, match=r"`git status` took over \d+ s\. Try again"):
        run_git(checkout, "status")


def test_what_is_not_utf_8_is_an_error(checkout: Path) -> None:
    (checkout / "latin").write_bytes(b"\xe4")
    run_git(checkout, "add", "latin")
    with pytest.raises(GitError, match="isn't UTF-8"):
        run_git(checkout, "show", ":latin")
