"""Another revision of this checkout, in a worktree of its own, kept for the next time."""

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
from ghostball.engine.core.kernel import cache_root
from ghostball.validation.results.git import GitError, run_git

KEPT = 3
"""Worktrees that are kept: each has its own compiled kernels, which take a minute or two."""


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
    """Yield a folder with a revision checked out; made, and old ones removed, where needed.

    It always lies in the same place, so that what was compiled for it is found again. Nobody else
    gets it meanwhile.

    Raises
    ------
    RevisionError
        Where git can't make it, there is no place for it, or another run uses it.
    """
    cache = cache_root().resolve()
    folder = cache.with_name(f"{cache.name}-revisions")
    mark = hashlib.sha256(os.fsencode(root)).hexdigest()[:8]
    place = folder / f"{mark}-{commit[:16]}"
    with ExitStack() as stack:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            stack.enter_context(_lock(place))
            _check_out(root, commit, place)
            _drop_old(root, folder, mark, place)
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


def _lock(place: Path) -> FileLock:
    return FileLock(place.with_name(f"{place.name}.lock"), timeout=0)


def _check_out(root: Path, commit: str, place: Path) -> None:
    if not _is_clean(place, commit):
        if place.is_dir():
            shutil.rmtree(place)
        place.unlink(missing_ok=True)
        _git(root, "worktree", "prune")
        _git(root, "worktree", "add", "--detach", "--force", str(place), commit)
    os.utime(place)


def _is_clean(place: Path, commit: str) -> bool:
    """Whether a folder holds that very revision, untouched."""
    if not (place / ".git").exists():
        return False
    try:
        there = _git(place, "rev-parse", "HEAD")
        return there == commit and not _git(place, "status", "--porcelain")
    except RevisionError:  # half made, or its repository was moved
        return False


def _drop_old(root: Path, folder: Path, mark: str, keep: Path) -> None:
    others = [path for path in folder.glob(f"{mark}-*") if path != keep and path.is_dir()]
    others.sort(key=lambda path: path.stat().st_mtime, reverse=True)
    for old in others[KEPT - 1 :]:
        with suppress(Timeout), _lock(old):  # else another run uses it
            shutil.rmtree(old, ignore_errors=True)
    _git(root, "worktree", "prune")


def _git(root: Path, *arguments: str) -> str:
    """Run git; what keeps it from that is an error of `--against`."""
    try:
        return run_git(root, *arguments)
    except GitError as error:
        raise RevisionError(f"`--against` needs git: {error}") from None
