"""Other revisions: git finds them by any name; each is checked out once, outside the repository."""

from __future__ import annotations

import os
import subprocess
from contextlib import suppress

import pytest

from ghostball.validation.baselines.revision import RevisionError, checked_out, repository, resolve


def git(root, *arguments):
    identity = {
        f"GIT_{who}_{what}": "tests"
        for who in ("AUTHOR", "COMMITTER")
        for what in ("NAME", "EMAIL")
    }
    done = subprocess.run(
        ["git", "-C", str(root), *arguments],
        env=os.environ | identity,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def commit(root, content):
    (root / "file").write_text(content)
    git(root, "add", "-A")
    git(root, "commit", "-q", "-m", content)
    return git(root, "rev-parse", "HEAD")


@pytest.fixture
def root(tmp_path, monkeypatch):
    """Create a repository with two commits, and a separate cache."""
    monkeypatch.setenv("GHOSTBALL_CACHE_DIR", str(tmp_path / "cache"))
    root = tmp_path / "repository"
    root.mkdir()
    git(root, "init", "-q", "-b", "main")
    commit(root, "first")
    commit(root, "second")
    return root


def test_any_name_of_a_commit_will_do(root):
    second = git(root, "rev-parse", "HEAD")
    git(root, "tag", "-a", "-m", "a tag", "v1")
    for name in ("HEAD", "main", "v1", second, second[:8], "HEAD^{}", "@"):
        assert resolve(name, root) == second
    assert resolve("HEAD~1", root) != second


@pytest.mark.parametrize(
    "name", ["none", "", "HEAD~9", "--all", "-h", "HEAD:file", "a b", "..", "^HEAD"]
)
def test_what_names_no_commit_is_refused_with_what_to_do(root, name):
    with pytest.raises(RevisionError, match="`--against` must name a commit") as raised:
        resolve(name, root)
    assert repr(name) in str(raised.value)
    assert "`git log --oneline`" in str(raised.value)


def test_a_shallow_clone_says_how_to_get_the_rest(root, tmp_path):
    first = git(root, "rev-parse", "HEAD~1")
    git(tmp_path, "clone", "-q", "--depth", "1", f"file://{root}", "shallow")
    with pytest.raises(RevisionError, match="shallow: `git fetch --unshallow`"):
        resolve(first, tmp_path / "shallow")


def test_a_revision_is_checked_out_beside_the_work_and_always_in_one_place(root):
    (root / "file").write_text("not committed")
    first = resolve("HEAD~1", root)
    with checked_out(root, first) as place:
        assert (place / "file").read_text() == "first"
        assert git(place, "rev-parse", "HEAD") == first
        assert (root / "file").read_text() == "not committed"
        assert not place.is_relative_to(root)
    with checked_out(root, first) as again:
        assert again == place, "its kernels are compiled again"


@pytest.mark.parametrize("end", [None, ValueError, KeyboardInterrupt, SystemExit])
def test_nothing_is_left_however_it_ends_and_the_repository_knows_of_nothing(root, end):
    """Fails if `git worktree list` keeps a removed checkout: git never prunes its commits."""
    before = sorted(path for path in (root / ".git").rglob("*"))
    with suppress(BaseException), checked_out(root, resolve("HEAD~1", root)) as place:
        if end:
            raise end
    assert sorted(path for path in (root / ".git").rglob("*")) == before
    assert not place.exists()


def test_what_a_killed_run_left_behind_is_removed_by_the_next_one(root):
    with checked_out(root, resolve("HEAD~1", root)) as place:
        left = place.with_name(f"{place.name[:8]}-{'0' * 16}")
    left.mkdir()
    with checked_out(root, resolve("HEAD", root)):
        assert not left.exists()


def test_nobody_else_gets_a_checkout_that_is_in_use_and_it_is_not_removed(root):
    first = resolve("HEAD~1", root)
    with checked_out(root, first) as place:
        with pytest.raises(RevisionError, match="by another run"), checked_out(root, first):
            pass
        with checked_out(root, resolve("HEAD", root)):
            pass
        assert (place / "file").read_text() == "first"


def test_an_error_of_what_is_done_there_is_not_called_one_of_the_place(root):
    with pytest.raises(OSError, match="planted"), checked_out(root, resolve("HEAD", root)):
        raise OSError("planted")


def test_an_installed_package_has_no_other_revisions(tmp_path):
    module = tmp_path / "site-packages" / "validation" / "__init__.py"
    module.parent.mkdir(parents=True)
    module.write_text("")
    with pytest.raises(RevisionError, match="needs a git repository with the engine's code"):
        repository(module)
