"""The versions that `constraints.txt` pins can be installed by any Python that is accepted."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

ROOT = Path(__file__).parents[1]
OLDEST = "3.11.0"
"""Debian 12 has 3.11.2, which is older than what some packages ask of 3.11."""

PINNED = [
    Requirement(line.strip())
    for line in (ROOT / "constraints.txt").read_text().splitlines()
    if line and not line.startswith("#")
]


@pytest.mark.parametrize("pinned", PINNED, ids=lambda pinned: pinned.name)
def test_a_pinned_version_can_be_installed_by_the_oldest_python(pinned: Requirement) -> None:
    try:
        installed = metadata(pinned.name)
    except PackageNotFoundError:
        pytest.skip(f"{pinned.name} isn't installed")
    if not pinned.specifier.contains(installed["Version"], prereleases=True):
        pytest.skip(f"another version of {pinned.name} is installed: {installed['Version']}")
    accepted = SpecifierSet(",".join(installed.get_all("Requires-Python") or ()))
    assert accepted.contains(OLDEST), f"it needs Python {accepted}: pin an older one in `dev`"


def test_the_list_is_read() -> None:
    assert len(PINNED) > 100
