"""Node and the packages of the engines in JavaScript: where they are, or why they aren't."""

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
"""What node runs, and the lock file of the packages."""

VARIABLE = "GHOSTBALL_PEERS_JS"
"""The variable of the environment that names the folder with `node_modules`."""

PEERS_JS = Path(__file__).resolve().parents[2] / ".peers-js"
"""Made by `make peers-js`."""

LEAST_NODE = 18
"""What the packages ask for."""

PACKAGES = ("planck", "matter-js", "cannon-es")
"""The packages of the engines."""

NODE = "node"

_LONGEST = 20.0
"""How long node may take to say its version [s]."""


def folder() -> Path:
    """Return the folder with `node_modules`, which need not be there."""
    return Path(os.environ.get(VARIABLE) or PEERS_JS)


def why_not(package: str) -> str | None:
    """Return why an engine's package can't be played here and how to get it, or None."""
    node = shutil.which(NODE)
    if node is None:
        return (
            f"it runs in Node.js, which isn't on the PATH. Install Node.js {LEAST_NODE} or "
            "newer, then run `make peers-js` in a checkout"
        )
    said = _version_of(node, _changed(node))
    number = re.fullmatch(r"v(\d+)\.\d+\.\d+\S*", said)
    if number is None:
        return (
            f"`{node} --version` must say a version such as v20.1.0, got {said[:80]!r}. Put "
            "Node.js on the PATH"
        )
    if int(number[1]) < LEAST_NODE:
        return f"node must be {LEAST_NODE} or newer, got {said} at {node}. Install a newer Node.js"
    if _package_version(package) is None:
        return (
            f"`{package}` isn't in {folder() / 'node_modules'}. Run `make peers-js` in a checkout, "
            f"or `npm ci` in a folder with package.json and package-lock.json of {DRIVER}, and "
            f"name it: {VARIABLE}=/path/to/folder"
        )
    return None


def installed() -> Mapping[str, str]:
    """Return the versions of node and of the engines' packages; nothing where none is there."""
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
def _version_of(node: str, changed: int) -> str:  # noqa: ARG001 - key
    """Return what node says of its version; what went wrong where it doesn't."""
    try:
        done = subprocess.run(
            [node, "--version"], capture_output=True, text=True, check=False, timeout=_LONGEST
        )
    except (OSError, ValueError, subprocess.TimeoutExpired) as error:
        return str(error)
    return done.stdout.strip()
