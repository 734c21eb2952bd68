"""Other revisions: found by any name that git knows, checked out once, kept apart from the work."""

from __future__ import annotations

import os
import shutil
import subprocess
from contextlib import suppress

import pytest

from ghostball.validation.baselines.revision import (
    RevisionError,
    repository,
    resolve,
    worktree,
)


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
    """A repository with two commits, and a cache of its own."""
    monkeypatch.setenv("GHOSTBALL_CACHE_DIR", str(tmp_path / "cache"))
    root = tmp_path / "repository"
    root.mkdir()
    git(root, "init", "-q", "-b", "main")
    commit(root, "first")
    commit(root, "second")
    return root


def known(root):
    """Return the worktrees that a repository knows, but itself."""
    lines = git(root, "worktree", "list", "--porcelain").splitlines()
    return [line.split(" ", 1)[1] for line in lines if line.startswith("worktree ")][1:]


def leave_behind(root, commit):
    """Return the folder that a killed run leaves."""
    with worktree(root, commit) as place:
        pass
    git(root, "worktree", "add", "-q", "--detach", str(place), commit)
    return place


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
    with worktree(root, first) as place:
        assert (place / "file").read_text() == "first"
        assert git(place, "rev-parse", "HEAD") == first
        assert (root / "file").read_text() == "not committed"
        assert not place.is_relative_to(root)
    with worktree(root, first) as again:
        assert again == place, "its kernels are compiled again"


@pytest.mark.parametrize("end", [None, ValueError, KeyboardInterrupt, SystemExit])
def test_nothing_is_left_in_the_repository_however_it_ends(root, end):
    """A worktree that was kept stood in `git worktree list`, and its commits were never pruned."""
    with suppress(BaseException), worktree(root, resolve("HEAD~1", root)) as place:
        assert known(root) == [str(place)]
        if end:
            raise end
    assert known(root) == []
    assert not place.exists()


def test_what_a_killed_run_left_behind_is_removed_by_the_next(root, tmp_path):
    places = [leave_behind(root, resolve(name, root)) for name in ("HEAD", "HEAD~1")]
    moved = tmp_path / "elsewhere" / places[0].name  # by a cache in another place
    gone = tmp_path / "gone" / places[0].name
    theirs = tmp_path / "theirs" / "12345678-0123456789abcdef"
    for place in (places[0], moved, gone, theirs):
        git(root, "worktree", "add", "-q", "--detach", str(place), "HEAD")
    shutil.rmtree(gone.parent)
    assert len(known(root)) == 5
    with worktree(root, resolve("HEAD", root)) as place:
        assert (place / "file").read_text() == "second"
    assert known(root) == [str(theirs)]
    assert not any(path.exists() for path in (*places, moved))


@pytest.mark.parametrize("damage", ["edited", "added", "removed", "moved on", "no git", "a file"])
def test_a_checkout_that_was_left_and_is_not_that_revision_is_made_anew(root, damage):
    # Else something else would be compared with, under its name.
    first = resolve("HEAD~1", root)
    place = leave_behind(root, first)
    if damage == "edited":
        (place / "file").write_text("other")
    elif damage == "added":
        (place / "new").write_text("other")
    elif damage == "removed":
        (place / "file").unlink()
    elif damage == "moved on":
        git(place, "checkout", "-q", "--detach", "main")
    elif damage == "no git":
        (place / ".git").unlink()
    else:
        shutil.rmtree(place)
        place.write_text("in the way")
    with worktree(root, first) as again:
        assert again == place
        assert (place / "file").read_text() == "first"
        assert sorted(path.name for path in place.iterdir()) == [".git", "file"]
        assert git(place, "rev-parse", "HEAD") == first


def test_nobody_else_gets_a_worktree_that_is_in_use_and_it_is_not_removed(root):
    first = resolve("HEAD~1", root)
    with worktree(root, first) as place:
        with pytest.raises(RevisionError, match="by another run"), worktree(root, first):
            pass
        with worktree(root, resolve("HEAD", root)):
            pass
        assert (place / "file").read_text() == "first"
        assert known(root) == [str(place)]


def test_an_error_of_what_is_done_there_is_not_told_as_one_of_the_place(root):
    with pytest.raises(OSError, match="planted"), worktree(root, resolve("HEAD", root)):
        raise OSError("planted")


def test_a_cache_behind_a_link_will_do(root, tmp_path, monkeypatch):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    monkeypatch.setenv("GHOSTBALL_CACHE_DIR", str(tmp_path / "link"))
    with worktree(root, resolve("HEAD", root)) as place:
        assert place == place.resolve()


def test_the_worktrees_of_another_checkout_are_left_alone(root, tmp_path):
    git(tmp_path, "clone", "-q", str(root), "other")
    theirs = leave_behind(tmp_path / "other", resolve("HEAD", tmp_path / "other"))
    with worktree(root, resolve("HEAD", root)):
        pass
    assert theirs.exists()


def test_a_hook_of_git_does_not_lead_astray(root, tmp_path, monkeypatch):
    # Git tells its hooks where they work by variables, which win over where a command is told to.
    git(tmp_path, "init", "-q", "elsewhere")
    commit(tmp_path / "elsewhere", "elsewhere")
    second = git(root, "rev-parse", "HEAD")
    monkeypatch.setenv("GIT_DIR", str(tmp_path / "elsewhere" / ".git"))
    monkeypatch.setenv("GIT_INDEX_FILE", str(tmp_path / "elsewhere" / ".git" / "index"))
    assert resolve("HEAD", root) == second
    with worktree(root, second) as place:
        assert (place / "file").read_text() == "second"


def test_a_cache_that_cannot_be_written_is_told(root, tmp_path):
    (tmp_path / "cache").write_text("in the way")
    with pytest.raises(RevisionError, match=r"can't be written: .* Set `GHOSTBALL_CACHE_DIR`"):
        worktree(root, resolve("HEAD", root)).__enter__()


def test_without_git_it_says_so(root, monkeypatch):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(RevisionError, match=r"`--against` needs git: .* Install it"):
        resolve("HEAD", root)


def test_a_git_that_takes_for_ever_is_told(root, monkeypatch):
    def slow(*_, **options):
        raise subprocess.TimeoutExpired("git", options["timeout"])

    monkeypatch.setattr(subprocess, "run", slow)
    with pytest.raises(RevisionError, match=r"took over 120 s\. Try again"):
        worktree(root, "0" * 40).__enter__()


def test_an_installed_package_has_no_other_revisions(tmp_path):
    module = tmp_path / "site-packages" / "validation" / "__init__.py"
    module.parent.mkdir(parents=True)
    module.write_text("")
    with pytest.raises(RevisionError, match="needs a git repository with the engine's code"):
        repository(module)


def test_a_checkout_is_found_by_a_file_that_it_tracks(root):
    tracked, other = root / "ours" / "code.py", root / "theirs.py"
    tracked.parent.mkdir()
    for path in (tracked, other):
        path.write_text("")
    git(root, "add", str(tracked))
    assert repository(tracked) == root
    with pytest.raises(RevisionError, match="is in none"):
        repository(other)
