"""How much an engine adds to an installation: its distribution, and what that needs."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, distribution
from typing import Final

from packaging.requirements import Requirement

from ghostball.reference_adapters.registry import OURS, parse_spec

COMMON: Final = frozenset({"numpy", "setuptools"})
"""What every engine of Python needs, or brings."""

_OURS: Final = ("numba",)
"""What our engine computes with; the rest of `ghostball` draws, and compares."""


def installed_size(spec: str) -> int | None:
    """Return the size of an engine's distribution and of all that it needs but numpy [bytes].

    None for an engine that no distribution of this environment brings, by itself or as an extra of
    `ghostball`: one of the user's own, or one that runs in another interpreter.
    """
    name, _ = parse_spec(spec)
    wanted = set(_OURS if name == OURS else _brought_by(name))
    if not wanted:
        return None
    todo, found = wanted, set[str]()
    while todo:
        found |= todo
        todo = {need for one in todo for need in _needs(one)} - found - COMMON
    return sum(_size(one) for one in found)


def _brought_by(engine: str) -> list[str]:
    """Return what `ghostball`, or its extra of an engine's name, installs for that engine."""
    said = [Requirement(one) for one in distribution("ghostball").requires or ()]
    extra = [one.name for one in said if one.marker and one.marker.evaluate({"extra": engine})]
    return [one for one in extra if one not in _plain(said)] or [
        one for one in _plain(said) if one == engine
    ]


def _plain(said: list[Requirement]) -> list[str]:
    return [one.name for one in said if one.marker is None or one.marker.evaluate({"extra": ""})]


def _needs(name: str) -> list[str]:
    try:
        return _plain([Requirement(one) for one in distribution(name).requires or ()])
    except PackageNotFoundError:  # of another platform, or left out on purpose
        return []


def _size(name: str) -> int:
    try:
        files = distribution(name).files or ()
    except PackageNotFoundError:
        return 0
    places = (file.locate() for file in files)
    return sum(place.stat().st_size for place in places if place.is_file())  # type: ignore[attr-defined]
