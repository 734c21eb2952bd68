"""Another revision of this checkout, in a worktree of its own while it is compared with."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from ghostball.engine import GhostballError
from ghostball.engine.core.cache_folder import cache_folder
from ghostball.validation.results.git import GitError, run_git


class RevisionError(GhostballError, ValueError):
    """A revision that there isn't, or no checkout to look for it in."""


def repository(source: Path) -> Path:
    """Return the root of the checkout that an engine's source is in.

    Raises
    ------
    RevisionError
        Where it is an installed package, or there is no git.
    """
    root = checkout_of(source)
    if root is None:
        raise RevisionError(
            f"`--against` needs a git repository with the engine's code, and {source} is in none. "
            "Clone it, or compare with baselines"
        )
    return root


def checkout_of(source: Path) -> Path | None:
    """Return the root of the repository that holds a file; None where none does."""
    path = source.resolve()
    root = next((one for one in path.parents if (one / ".git").exists()), None)
    if root is None:
        return None
    try:
        return root if run_git(root, "ls-files", "--", str(path)) else None
    except GitError:
        return None


def resolve(revision: str, root: Path) -> str:
    """Return the full name of a revision.

    Raises
    ------
    RevisionError
        Where there is no such commit.
    """
    try:
        commit = _git(root, "rev-parse", "--verify", "--quiet", f"{revision}^{{commit}}")
    except RevisionError:
        commit = ""
    if not re.fullmatch("[0-9a-f]{40,}", commit):  # "^HEAD" is none, but what isn't before HEAD
        shallow = _git(root, "rev-parse", "--is-shallow-repository") == "true"
        more = (
            "This clone is shallow: `git fetch --unshallow` brings the rest"
            if shallow
            else "`git log --oneline` lists those that there are"
        )
        raise RevisionError(f"`--against` must name a commit of {root}, got {revision!r}. {more}")
    return commit


@contextmanager
def worktree(root: Path, commit: str) -> Iterator[Path]:
    """Yield a folder with a revision checked out, and remove it at the end, whatever happens.

    It always lies in the same place, so that what was compiled for it is found again. Nobody else
    gets it meanwhile. One that a killed run left behind is removed by the next run.

    Raises
    ------
    RevisionError
        Where git can't make it, there is no place for it, or another run uses it.
    """
    folder = cache_folder("revisions").resolve()
    place = folder / f"{_mark(root)}-{commit[:16]}"
    with ExitStack() as stack:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            _remove_left_behind(root)
            stack.enter_context(_lock(place))
            stack.callback(_remove, root, place)
            _remove(root, place)
            _git(root, "worktree", "add", "--detach", "--force", str(place), commit)
        except Timeout:
            raise RevisionError(
                f"revision {commit[:12]} is being compared with by another run. Wait until it has "
                "ended"
            ) from None
        except OSError as error:
            reason = error.strerror or type(error).__name__
            raise RevisionError(
                f"{error.filename or folder}: can't be written: {reason}. Set "
                "`GHOSTBALL_CACHE_DIR` to another folder"
            ) from error
        yield place


def _mark(root: Path) -> str:
    """Return the beginning of the names of a checkout's worktrees."""
    return hashlib.sha256(os.fsencode(root)).hexdigest()[:8]


def _lock(place: Path) -> FileLock:
    return FileLock(place.with_name(f"{place.name}.lock"), timeout=0)


def _remove(root: Path, place: Path) -> None:
    """Remove a worktree, and what its repository knows of it."""
    if place.is_dir():
        shutil.rmtree(place, ignore_errors=True)
    else:
        place.unlink(missing_ok=True)
    with suppress(RevisionError):  # a repository that is gone knows of none
        _git(root, "worktree", "prune")


def _remove_left_behind(root: Path) -> None:
    """Remove the worktrees of ours that a repository knows and that no run uses, wherever they lie.

    Ours are known by their names: a mark of this checkout and the beginning of a commit's name.
    """
    _git(root, "worktree", "prune")  # those whose folders are gone
    ours = re.compile(f"{_mark(root)}-[0-9a-f]{{16}}")
    for line in _git(root, "worktree", "list", "--porcelain").splitlines():
        kind, _, path = line.partition(" ")
        place = Path(path)
        if kind == "worktree" and ours.fullmatch(place.name):
            with suppress(Timeout), _lock(place):  # else another run uses it
                _remove(root, place)


def _git(root: Path, *arguments: str) -> str:
    """Run git; what keeps it from that is an error of `--against`."""
    try:
        return run_git(root, *arguments)
    except GitError as error:
        raise RevisionError(f"`--against` needs git: {error}") from None
