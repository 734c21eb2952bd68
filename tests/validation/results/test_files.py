"""Files are written completely or not at all, their errors are clear, and git is read correctly."""

from __future__ import annotations

import errno
import subprocess
from pathlib import Path

import pytest
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ghostball.validation.results.environment import git_state
from ghostball.validation.results.files import (
    describe_validation_error,
    write_all_whole,
)
from ghostball.validation.results.git import GitError, run_git

# Files are written completely or not at all, and errors in them are clear


@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "No space left"), KeyboardInterrupt()])
def test_what_fails_half_way_leaves_what_was_there_and_no_part(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    first.write_text("old")
    honest = Path.write_bytes

    def full(path: Path, data: bytes) -> int:
        if path.name.startswith("second"):
            honest(path, data[:2])
            raise error
        return honest(path, data)

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(type(error)):
        write_all_whole({first: "new", second: "content"})
    assert [path.name for path in tmp_path.iterdir()] == ["first"]
    assert first.read_text() == "old"


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    band: int | float = Field(0.0, ge=0)
    names: tuple[str, ...] = ()


class _Whole(BaseModel):
    model_config = ConfigDict(extra="forbid")

    parts: dict[str, _Part]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{}", "`parts` is missing"),
        ('{"parts": {}, "odd": 1}', "`odd` is not a known field"),
        ('{"parts": {"a": {"band": "x"}}}', "`parts.a.band` must be a valid number, got 'x'"),
        ('{"parts": {"a": {"names": [1]}}}', "`parts.a.names[0]` must be a valid string, got 1"),
        ("[1]", "must be an object, got [1]"),
        ('{"par', "Invalid JSON: EOF while parsing a string at line 1 column 5"),
    ],
)
def test_what_a_model_refuses_is_described_in_words(text: str, said: str) -> None:
    with pytest.raises(ValidationError) as caught:
        _Whole.model_validate_json(text)
    assert describe_validation_error(caught.value) == said


def test_a_long_value_is_not_shown() -> None:
    with pytest.raises(ValidationError) as caught:
        _Whole.model_validate({"parts": "x" * 200})
    assert describe_validation_error(caught.value) == "`parts` must be a valid dictionary"


# Git answers for this repository, and its refusal is one of our errors


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
    """Fails if the variables that git sets for a hook redirect our git to another repository."""
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
