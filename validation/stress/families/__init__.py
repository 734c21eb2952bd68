"""The families of trials, by name, in the order in which they are shown; which are asked for.

A family is a module here with a constant `FAMILY`. Its trials are a sweep, each with a right answer
that is known beforehand, or with something that no shot may break.
"""

from __future__ import annotations

import fnmatch
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from ghostball.validation.stress.families import (
    extremes,
    grazing,
    long_runs,
    pockets,
    reversal,
    shipped,
    storms,
    touching,
    tunnelling,
)
from ghostball.validation.stress.trial import Family, StressError, Suite, Trial

_MODULES: Final = (
    grazing,
    touching,
    extremes,
    long_runs,
    reversal,
    storms,
    tunnelling,
    pockets,
    shipped,
)

FAMILIES: Final[Mapping[str, Family]] = {module.FAMILY.name: module.FAMILY for module in _MODULES}


def chosen_trials(suite: Suite, only: Sequence[str] = ()) -> list[tuple[Family, Trial]]:
    """Return the trials of a suite that are asked for, in order, each with its family.

    `only`: families, or trials as `FAMILY/TRIAL`, each of which may be a pattern such as
    "grazing/*-miss-*"; all where it is empty.

    Raises `StressError` where one of them is the name of nothing.
    """
    chosen = []
    unmatched = dict.fromkeys(only)
    for family, trial in _candidates(suite, only):
        names = [
            pattern
            for pattern in only
            if fnmatch.fnmatchcase(family.name, pattern)
            or fnmatch.fnmatchcase(path_of(family, trial), pattern)
        ]
        if names or not only:
            chosen.append((family, trial))
        for pattern in names:
            unmatched.pop(pattern, None)
    for pattern in unmatched:
        raise StressError(
            f"no family or trial of suite {suite} is called {pattern!r}. Families: "
            f"{', '.join(FAMILIES)}; a trial is FAMILY/TRIAL, as `ghostball stress --list FAMILY` "
            "names it"
        )
    return chosen


def path_of(family: Family, trial: Trial) -> str:
    """Return the name of a trial as the command line has it: `FAMILY/TRIAL`."""
    return f"{family.name}/{trial.name}"


def _candidates(suite: Suite, only: Sequence[str]) -> Iterator[tuple[Family, Trial]]:
    # To make the trials of a family may take seconds: only where one may be asked for.
    families = [pattern.partition("/")[0] for pattern in only]
    for family in FAMILIES.values():
        if not only or any(fnmatch.fnmatchcase(family.name, one) for one in families):
            for trial in family.trials(suite):
                yield family, trial
