"""Copies of Ghostball's packages, for tests that change their sources."""

from __future__ import annotations

import shutil
from pathlib import Path

from ghostball import engine

INSTALLED = Path(engine.__file__).parent.parent
"""Folder of the package `ghostball`, which contains all other packages."""


def copy_packages(folder: Path, *packages: str) -> Path:
    """Make a package `ghostball` in a folder, with copies of some parts, and return its path.

    All other parts are links to the originals. Cached bytecode is copied, too.
    """
    place = folder / "ghostball"
    place.mkdir(parents=True)
    for part in INSTALLED.iterdir():
        if part.name in packages:
            shutil.copytree(part, place / part.name)
        elif part.name != "__pycache__":
            (place / part.name).symlink_to(part.resolve())
    return place
