"""Another revision of this checkout, in a clone of its own while it is compared with."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from ghostball.model import GhostballError
from ghostball.model.cache_folder import cache_folder
from ghostball.validation.results.git import GitError, run_git


class RevisionError(GhostballError, ValueError):
    """A revision that there isn't, or no checkout to look for it in."""


def repository(source: Path) -> Path:
    """Return the root of the checkout that an engine's source is in.

    Raises `RevisionError` where it is an installed package, or there is no git.
    """
    root = checkout_of(source)
    if root is None:
        raise RevisionError(
            f"`--against` needs a git repository with the engine's code, but {source} isn't in "
            "one. Clone the repository, or compare with baselines"
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

    Raises `RevisionError` where there is no such commit.
    """
    try:
        commit = _git(root, "rev-parse", "--verify", "--quiet", f"{revision}^{{commit}}")
    except RevisionError:
        commit = ""
    if not re.fullmatch("[0-9a-f]{40,}", commit):  # "^HEAD" is none, but what isn't before HEAD
        shallow = _git(root, "rev-parse", "--is-shallow-repository") == "true"
        more = (
            "This clone is shallow: `git fetch --unshallow` fetches the rest"
            if shallow
            else "`git log --oneline` lists the commits"
        )
        raise RevisionError(f"`--against` must name a commit of {root}, got {revision!r}. {more}")
    return commit


@contextmanager
def checked_out(root: Path, commit: str) -> Iterator[Path]:
    """Yield a clone with a revision checked out, and remove it at the end, whatever happens.

    It always lies in the same place, so that what was compiled for it is found again. Nobody else
    gets it meanwhile. What killed runs left behind of this checkout is removed first.

    Raises `RevisionError` where git can't make it, there is no place for it, or another run uses
    it.
    """
    folder = cache_folder("revisions").resolve()
    mark = hashlib.sha256(os.fsencode(root)).hexdigest()[:8]
    place = folder / f"{mark}-{commit[:16]}"
    with ExitStack() as stack:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            for left in folder.glob(f"{mark}-{'[0-9a-f]' * 16}"):
                with suppress(Timeout), _lock(left):  # else another run uses it
                    shutil.rmtree(left, ignore_errors=True)
            stack.enter_context(_lock(place))
            stack.callback(shutil.rmtree, place, ignore_errors=True)
            # A clone, not a worktree: of that the user's repository would know.
            _git(root, "clone", "--quiet", "--shared", "--no-checkout", str(root), str(place))
            _git(place, "checkout", "--quiet", "--detach", commit)
        except Timeout:
            raise RevisionError(
                f"revision {commit[:12]} is in use by another run. Wait until that run finishes"
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


def _git(root: Path, *arguments: str) -> str:
    """Run git; what keeps it from that is an error of `--against`."""
    try:
        return run_git(root, *arguments)
    except GitError as error:
        raise RevisionError(f"`--against` needs git: {error}") from None
