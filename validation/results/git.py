"""Run git in a checkout, and return its output or the reason of its failure."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Final

from ghostball.model import GhostballError

TIMEOUT: Final = 120.0
"""Time limit of a git command [s]; checking out a whole tree takes a few seconds."""

_HOOK_VARIABLES: Final = frozenset(
    (
        *("GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_OBJECT_DIRECTORY", "GIT_COMMON_DIR"),
        *("GIT_ALTERNATE_OBJECT_DIRECTORIES", "GIT_PREFIX", "GIT_NAMESPACE"),
    )
)
"""Variables that git sets for a hook; they would redirect git to the repository with the hook."""


class GitError(GhostballError):
    """Git isn't installed, took too long, or failed."""


def run_git(root: Path, *arguments: str) -> str:
    """Run git in a folder, ignoring any repository whose hook runs Ghostball; return its output.

    `*arguments`: such as "rev-parse", "HEAD".

    Raises `GitError` if git isn't installed, doesn't end, fails, or prints text that isn't UTF-8.
    """
    try:
        finished = subprocess.run(
            ["git", "-C", str(root), *arguments],
            capture_output=True,
            check=True,
            timeout=TIMEOUT,
            env={name: value for name, value in os.environ.items() if name not in _HOOK_VARIABLES},
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
        raise GitError(
            f"`git {' '.join(arguments)}` printed text that isn't UTF-8: {error}"
        ) from None
