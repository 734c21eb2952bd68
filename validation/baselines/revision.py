"""Another revision of this checkout, in a temporary clone."""

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
    """A revision that doesn't exist, or code that isn't in a git checkout."""


def repository(source: Path) -> Path:
    """Return the root of the checkout with the source of an engine.

    Raises `RevisionError` if the source is an installed package, or if git is missing.
    """
    root = checkout_of(source)
    if root is None:
        raise RevisionError(
            f"`--against` needs a git repository with the engine's code, but {source} isn't in "
            "one. Clone the repository, or compare with baselines"
        )
    return root


def checkout_of(source: Path) -> Path | None:
    """Return the root of the git repository that tracks a file; None if there is none."""
    path = source.resolve()
    root = next((one for one in path.parents if (one / ".git").exists()), None)
    if root is None:
        return None
    try:
        return root if run_git(root, "ls-files", "--", str(path)) else None
    except GitError:
        return None


def resolve(revision: str, root: Path) -> str:
    """Return the full hash of a revision.

    Raises `RevisionError` if no such commit exists.
    """
    try:
        commit = _git(root, "rev-parse", "--verify", "--quiet", f"{revision}^{{commit}}")
    except RevisionError:
        commit = ""
    if not re.fullmatch("[0-9a-f]{40,}", commit):  # "^HEAD" resolves to "^" and a hash
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
    """Yield a clone with a revision checked out; the clone is removed at the end in any case.

    The clone of a revision always has the same path, so kernels that were compiled for it are found
    again. A lock keeps other runs out. Clones that killed runs left behind are removed first.

    Raises `RevisionError` if git fails, if the clone can't be written, or if another run uses it.
    """
    folder = cache_folder("revisions").resolve()
    mark = hashlib.sha256(os.fsencode(root)).hexdigest()[:8]
    place = folder / f"{mark}-{commit[:16]}"
    with ExitStack() as stack:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            for left in folder.glob(f"{mark}-{'[0-9a-f]' * 16}"):
                with suppress(Timeout), _lock(left):  # locked: another run uses it
                    shutil.rmtree(left, ignore_errors=True)
            stack.enter_context(_lock(place))
            stack.callback(shutil.rmtree, place, ignore_errors=True)
            # A clone, because git would register a worktree in the user's repository.
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
    """Run git for `--against`; raises `RevisionError` if it fails."""
    try:
        return run_git(root, *arguments)
    except GitError as error:
        raise RevisionError(f"`--against` needs git: {error}") from None
