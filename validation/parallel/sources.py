"""The code that runs on this machine: our sources, and what they compute with."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Iterable
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from ghostball.model import GhostballError
from ghostball.reference_adapters.javascript import packages as javascript
from ghostball.reference_adapters.workers.process import DISTRIBUTIONS, installed

OUR_PACKAGES = ("model", "engine", "reference_adapters", "validation")
"""Packages whose every line may decide a result."""

CODE_ENDINGS = (".py", ".mjs", ".html", ".so", ".pyd")
"""Files that hold code, templates too. Scenes and criteria lie beside them, and are inputs."""

LIBRARIES = (
    *("numpy", "numba", "llvmlite", "pymunk", "cffi", "pybullet"),
    *("mpmath", "gmpy2", "python-flint", "pydantic", "pydantic-core"),
    *("mujoco-core", "box2d", "dartpy", "sapien", "pyb2d3", "rapier3d"),
)
"""Distributions that compute, or are beneath one that does."""

PACKAGES = ("ghostball", *LIBRARIES)
"""Distributions whose versions can change a number."""

PACKAGE_OF: Final = {
    **dict.fromkeys(("certified", "paper-discrete", "paper-continuous"), "ghostball"),
    "mujoco": "mujoco-core",
    "box2d3": "pyb2d3",
    "dart": "dartpy",
    "physx": "sapien",
    "rapier": "rapier3d",
    "pooltool": "pooltool-billiards",
    "rapier-js": "@dimforge/rapier2d-compat",
}
"""What `versions` calls an engine of this project, where that isn't its name."""


class SourcesError(GhostballError):
    """Sources that can't be looked at, so that nobody can say whether they changed."""


def source_folders() -> tuple[Path, ...]:
    """Return the folders of our packages, as they are imported.

    Raises `SourcesError` where one is not in a folder, such as in a zip archive.
    """
    folders = []
    for name in OUR_PACKAGES:
        spec = find_spec(f"ghostball.{name}")
        folder = Path(spec.origin).parent if spec is not None and spec.origin else None
        if folder is None or not code_files(folder):
            raise SourcesError(f"package `{name}`: its source files can't be found")
        folders.append(folder)
    return tuple(folders)


def hash_sources(folders: Iterable[Path]) -> str:
    """Return the hash of every file of code below `folders`: names, places and contents.

    A folder may be given by the `__init__.py` in it; another file stands for itself.
    """
    digest = hashlib.sha256()
    for one in folders:
        folder = one.parent if one.is_file() else one
        for path in [one] if one.is_file() and one.stem != "__init__" else code_files(folder):
            content = path.read_bytes()
            head = [folder.name, path.relative_to(folder).as_posix(), len(content)]
            digest.update(json.dumps(head).encode() + content)
    return digest.hexdigest()


def code_files(folder: Path) -> list[Path]:
    """Return the files of code below a folder, in order."""
    return sorted(path for path in folder.rglob("*") if path.suffix in CODE_ENDINGS)


def versions() -> dict[str, str | None]:
    """Return the versions of `PACKAGES`, and of the workers' engines; None of what isn't there."""
    there = {**installed(), **javascript.installed()}
    others = (*DISTRIBUTIONS, javascript.NODE, *javascript.PACKAGES)
    return {name: version_of(name) for name in PACKAGES} | {
        name: there.get(name) for name in others
    }


@cache  # reading what is installed takes milliseconds, and every results folder asks
def version_of(package: str) -> str | None:
    """Return the version of a distribution; None where it isn't there."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def code_here() -> dict[str, str]:
    """Return what is the same where the same code runs: what our sources are, and versions.

    Of the workers' interpreter all that it has: what lies beneath an engine may change its numbers.
    """
    ours = {name: version_of(name) for name in PACKAGES}
    there = {**installed(), **javascript.installed()}
    theirs = {f"{name} of the workers": found for name, found in there.items()}
    return {
        "ghostball's sources": hash_sources(source_folders())[:12],
        "Python": platform.python_version(),
    } | {name: found for name, found in (ours | theirs).items() if found is not None}
