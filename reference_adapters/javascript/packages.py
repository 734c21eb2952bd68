"""Find Node.js and the packages of the JavaScript engines, or report why they are missing."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from collections.abc import Mapping
from functools import cache
from pathlib import Path

DRIVER = Path(__file__).resolve().parent / "driver"
"""Folder with the code for Node.js and the lock file of the packages."""

FOLDER_VARIABLE = "GHOSTBALL_PEERS_JS"
"""Environment variable for the folder with `node_modules`."""

PEERS_JS = Path(__file__).resolve().parents[2] / ".peers-js"
"""Default folder, created by `make peers-js`."""

OLDEST_NODE = 18
"""Oldest version of Node.js that the packages support."""

PACKAGES = ("planck", "matter-js", "cannon-es")
"""The packages of the engines."""

NODE = "node"

_VERSION_TIME_LIMIT = 20.0
"""Time limit for `node --version` [s]."""


def folder() -> Path:
    """Return the folder with `node_modules`, which may not exist."""
    return Path(os.environ.get(FOLDER_VARIABLE) or PEERS_JS)


def why_unavailable(package: str) -> str | None:
    """Return why an engine's package can't run here and how to install it, or None."""
    node = shutil.which(NODE)
    if node is None:
        return (
            f"it runs in Node.js, which isn't on the PATH. Install Node.js {OLDEST_NODE} or "
            "newer, then run `make peers-js` in a checkout"
        )
    said = _version_of(node, _changed(node))
    number = re.fullmatch(r"v(\d+)\.\d+\.\d+\S*", said)
    if number is None:
        return (
            f"`{node} --version` must print a version such as v20.1.0, got {said[:80]!r}. Put "
            "Node.js on the PATH"
        )
    if int(number[1]) < OLDEST_NODE:
        return f"node must be {OLDEST_NODE} or newer, got {said} at {node}. Install a newer Node.js"
    if _package_version(package) is None:
        return (
            f"`{package}` isn't in {folder() / 'node_modules'}. Run `make peers-js` in a checkout, "
            f"or `npm ci` in a folder with package.json and package-lock.json of {DRIVER}, and "
            f"name it: {FOLDER_VARIABLE}=/path/to/folder"
        )
    return None


def installed() -> Mapping[str, str]:
    """Return the versions of Node.js and of the engines' packages; empty if there are none."""
    found = {name: version for name in PACKAGES if (version := _package_version(name)) is not None}
    node = shutil.which(NODE)
    if not found or node is None:
        return {}
    return {NODE: _version_of(node, _changed(node)), **found}


def _package_version(package: str) -> str | None:
    path = folder() / "node_modules" / package / "package.json"
    try:
        return str(json.loads(path.read_text(encoding="utf-8"))["version"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _changed(path: str) -> int:
    return os.stat(path).st_mtime_ns


@cache
def _version_of(node: str, changed: int) -> str:  # noqa: ARG001 - key of the cache
    """Return the version that Node.js prints, or the error that occurred."""
    try:
        done = subprocess.run(
            [node, "--version"],
            capture_output=True,
            text=True,
            check=False,
            timeout=_VERSION_TIME_LIMIT,
        )
    except (OSError, ValueError, subprocess.TimeoutExpired) as error:
        return str(error)
    return done.stdout.strip()
