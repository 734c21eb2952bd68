"""The families of shots by name, in display order, and the choice of shots.

A family is a module in this folder with a constant `FAMILY`. Its shots vary a parameter. Each shot
has a result that is known in advance, or limits that hold for every shot.
"""

from __future__ import annotations

import fnmatch
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Final

from ghostball.validation.stress import (
    extremes,
    grazing,
    lasting,
    long_runs,
    pockets,
    reversal,
    storms,
    touching,
    tunnelling,
)
from ghostball.validation.stress.shots import StressError, StressFamily, StressShot, StressSize

_MODULES: Final = (
    grazing,
    touching,
    lasting,
    extremes,
    long_runs,
    reversal,
    storms,
    tunnelling,
    pockets,
)

FAMILIES: Final[Mapping[str, StressFamily]] = {
    module.FAMILY.name: module.FAMILY for module in _MODULES
}


def chosen_shots(size: StressSize, only: Sequence[str] = ()) -> list[StressShot]:
    """Return the chosen shots, in order.

    `only`: families, or shots as `FAMILY/SHOT`, each of which may be a pattern such as
    "grazing/*-miss-*"; empty: all. Shots that don't belong to this size are looked up among all
    shots.

    Raises `StressError` if a name or pattern matches no family and no shot.
    """
    chosen, unmatched = _matching(size, only)
    if unmatched and not size.full:
        more, unmatched = _matching(replace(size, full=True), unmatched)
        chosen += more
    for pattern in unmatched:
        raise StressError(
            f"no family or shot is called {pattern!r}. Families: {', '.join(FAMILIES)}; a shot is "
            "FAMILY/SHOT, as `ghostball stress --list FAMILY` names it"
        )
    return chosen


def _matching(size: StressSize, only: Sequence[str]) -> tuple[list[StressShot], list[str]]:
    """Return the shots that patterns name, and the patterns that name none."""
    chosen, unmatched = [], dict.fromkeys(only)
    for family, shot in _candidates(size, only):
        names = (family.name, path_of(shot.scene.name))
        matching = [
            pattern for pattern in only if any(fnmatch.fnmatchcase(name, pattern) for name in names)
        ]
        if matching or not only:
            chosen.append(shot)
        for pattern in matching:
            unmatched.pop(pattern, None)
    return chosen, list(unmatched)


def path_of(scene: str) -> str:
    """Return the name of a shot on the command line, `FAMILY/SHOT`, from the name of its scene."""
    return scene.replace(".", "/", 1)


def _candidates(size: StressSize, only: Sequence[str]) -> Iterator[tuple[StressFamily, StressShot]]:
    # Generating the shots of a family may take seconds, so only families that may match do this.
    families = [pattern.partition("/")[0] for pattern in only]
    for family in FAMILIES.values():
        if not only or any(fnmatch.fnmatchcase(family.name, one) for one in families):
            for shot in _shots(family, size):
                yield family, shot


@cache  # shots are looked up again, by other patterns or by another command of the same process
def _shots(family: StressFamily, size: StressSize) -> tuple[StressShot, ...]:
    return tuple(family.shots(size))
