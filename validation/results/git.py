"""Git, asked from a checkout: what it prints, or why it couldn't."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Final

from ghostball.model import GhostballError

TIMEOUT: Final = 120.0
"""Seconds: git checks a whole tree out within some."""

_OF_A_HOOK: Final = frozenset(
    (
        *("GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_OBJECT_DIRECTORY", "GIT_COMMON_DIR"),
        *("GIT_ALTERNATE_OBJECT_DIRECTORIES", "GIT_PREFIX", "GIT_NAMESPACE"),
    )
)
"""Variables that git sets for a hook: they would lead to the repository that called it."""


class GitError(GhostballError):
    """Git isn't there, took too long, or refused."""


def run_git(root: Path, *arguments: str) -> str:
    """Run git in a folder, whatever repository calls us, and return what it prints, stripped.

    `*arguments`: such as "rev-parse", "HEAD".

    Raises `GitError` where git isn't installed, doesn't end, fails, or prints what isn't UTF-8.
    """
    try:
        finished = subprocess.run(
            ["git", "-C", str(root), *arguments],
            capture_output=True,
            check=True,
            timeout=TIMEOUT,
            env={name: value for name, value in os.environ.items() if name not in _OF_A_HOOK},
        )
        return finished.stdout.decode("utf-8").strip()
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise GitError(f"`git` can't be run: {reason}. Install it") from None
    except subprocess.TimeoutExpired:
        raise GitError(f"`git {arguments[0]}` took over {TIMEOUT:.0f} s. Try again") from None
    except subprocess.CalledProcessError as error:
        said = " ".join(error.stderr.decode("utf-8", "replace").split()) or "no message"
        raise GitError(f"`git {' '.join(arguments)}` failed: {said}") from None
    except UnicodeDecodeError as error:
        raise GitError(f"`git {' '.join(arguments)}` printed what isn't UTF-8: {error}") from None
