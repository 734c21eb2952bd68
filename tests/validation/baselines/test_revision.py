"""Other revisions: found by any name that git knows, checked out once, kept apart from the work."""

from __future__ import annotations

import os
import shutil
import subprocess

import pytest

from ghostball.validation.baselines import revision as revision_module
from ghostball.validation.baselines.revision import (
    KEPT,
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
    monkeypatch.setattr(revision_module, "cache_root", lambda: tmp_path / "cache" / "kernels")
    root = tmp_path / "repository"
    root.mkdir()
    git(root, "init", "-q", "-b", "main")
    commit(root, "first")
    commit(root, "second")
    return root


def checked_out(root, commit):
    """Return the folder of a revision, given back at once."""
    with worktree(root, commit) as place:
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


def test_a_revision_is_checked_out_once_beside_the_work(root):
    (root / "file").write_text("not committed")
    first = resolve("HEAD~1", root)
    place = checked_out(root, first)
    assert (place / "file").read_text() == "first"
    assert (root / "file").read_text() == "not committed"
    assert git(root, "branch", "--format", "%(refname:short)").splitlines()[-1] == "main"
    assert not place.is_relative_to(root)
    (place / "ignored").mkdir()  # git doesn't see an empty folder
    assert checked_out(root, first) == place
    assert (place / "ignored").exists(), "made anew"


@pytest.mark.parametrize("damage", ["edited", "added", "removed", "moved on", "no git", "a file"])
def test_a_checkout_that_is_not_that_revision_is_made_anew(root, damage):
    # Else something else would be compared with, under its name.
    first = resolve("HEAD~1", root)
    place = checked_out(root, first)
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
    assert checked_out(root, first) == place
    assert (place / "file").read_text() == "first"
    assert sorted(path.name for path in place.iterdir()) == [".git", "file"]
    assert git(place, "rev-parse", "HEAD") == first


def test_only_the_last_ones_are_kept(root):
    names = [commit(root, f"number {number}") for number in range(KEPT + 2)]
    places = []
    for number, name in enumerate(names):
        places.append(checked_out(root, name))
        os.utime(places[-1], (number + 1.0, number + 1.0))
    os.utime(places[-1], None)
    assert [place.exists() for place in places] == [False] * 2 + [True] * KEPT
    listed = git(root, "worktree", "list").splitlines()
    assert len(listed) == KEPT + 1


def test_nobody_else_gets_a_worktree_that_is_in_use_and_it_is_not_removed(root):
    first = resolve("HEAD~1", root)
    with worktree(root, first) as place:
        with pytest.raises(RevisionError, match="by another run"), worktree(root, first):
            pass
        for number in range(KEPT + 1):
            checked_out(root, commit(root, f"number {number}"))
        assert (place / "file").read_text() == "first"


def test_an_error_of_what_is_done_there_is_not_told_as_one_of_the_place(root):
    with pytest.raises(OSError, match="planted"), worktree(root, resolve("HEAD", root)):
        raise OSError("planted")


def test_a_cache_behind_a_link_will_do(root, tmp_path, monkeypatch):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    monkeypatch.setattr(revision_module, "cache_root", lambda: tmp_path / "link" / "kernels")
    place = checked_out(root, resolve("HEAD", root))
    assert place == place.resolve()


def test_the_worktrees_of_another_checkout_are_left_alone(root, tmp_path):
    git(tmp_path, "clone", "-q", str(root), "other")
    theirs = checked_out(tmp_path / "other", resolve("HEAD", tmp_path / "other"))
    for number in range(KEPT + 1):
        checked_out(root, commit(root, f"number {number}"))
    assert theirs.exists()


def test_a_hook_of_git_does_not_lead_astray(root, tmp_path, monkeypatch):
    # Git tells its hooks where they work by variables, which win over where a command is told to.
    git(tmp_path, "init", "-q", "elsewhere")
    commit(tmp_path / "elsewhere", "elsewhere")
    second = git(root, "rev-parse", "HEAD")
    monkeypatch.setenv("GIT_DIR", str(tmp_path / "elsewhere" / ".git"))
    monkeypatch.setenv("GIT_INDEX_FILE", str(tmp_path / "elsewhere" / ".git" / "index"))
    assert resolve("HEAD", root) == second
    assert (checked_out(root, second) / "file").read_text() == "second"


def test_a_cache_that_cannot_be_written_is_told(root, tmp_path):
    (tmp_path / "cache").write_text("in the way")
    with pytest.raises(RevisionError, match=r"can't be written: .* Set `GHOSTBALL_CACHE_DIR`"):
        checked_out(root, resolve("HEAD", root))


def test_without_git_it_says_so(root, monkeypatch):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(RevisionError, match=r"`--against` needs git: .* Install it"):
        resolve("HEAD", root)


def test_a_git_that_takes_for_ever_is_told(root, monkeypatch):
    def slow(*_, **options):
        raise subprocess.TimeoutExpired("git", options["timeout"])

    monkeypatch.setattr(subprocess, "run", slow)
    with pytest.raises(RevisionError, match=r"took over 120 s\. Try again"):
        checked_out(root, "0" * 40)


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
