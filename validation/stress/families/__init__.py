"""The families of trials, by name, in the order in which they are shown.

A family is a module here with a constant `FAMILY`. Its trials are a sweep, each with a right answer
that is known beforehand, or with something that no shot may break.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from ghostball.validation.stress.families import (
    air,
    combined,
    cradles,
    extremes,
    flight,
    graded,
    grazing,
    long_runs,
    near_degenerate,
    reversal,
    shipped,
    storms,
    sustained,
    touching,
    tunnelling,
)
from ghostball.validation.stress.family import Family

__all__ = ["FAMILIES", "Family"]

_MODULES: Final = (
    grazing,
    near_degenerate,
    touching,
    cradles,
    sustained,
    extremes,
    long_runs,
    reversal,
    storms,
    tunnelling,
    flight,
    air,
    combined,
    graded,
    shipped,
)

FAMILIES: Final[Mapping[str, Family]] = {module.FAMILY.name: module.FAMILY for module in _MODULES}
