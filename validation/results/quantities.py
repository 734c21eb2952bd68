"""Texts of numbers with a unit prefix that suits their size, and of long lists of names."""

from __future__ import annotations

import math
from collections.abc import Sequence

SMALLEST = 1e-16
"""Smallest number with a prefix; smaller numbers get a power of ten, because their prefixes are
hardly known.
"""

# By exponent, because 1e-3 * 1e-6 is not 1e-9 in floating point.
_PREFIXES = {0: "", -3: "m", -6: "µ", -9: "n", -12: "p", -15: "f"}


def scaled(value: float, unit: str, digits: int = 3) -> str:
    """Return a value with a prefix of its unit, so that the number is in [1, 1000): "3.67 mm".

    `digits`: significant digits.
    """
    if value < 0.0:
        return f"-{scaled(-value, unit, digits)}"
    if not math.isfinite(value):
        return f"{value} {unit}"
    if value == 0.0:
        return "0"
    # The prefix is chosen after rounding, so that the displayed number is in [1, 1000).
    rounded = float(f"{value:.{digits}g}")
    if rounded < SMALLEST:
        return f"{value:.1e} {unit}"
    exponent = 3 * math.floor(math.log10(rounded) / 3.0 + 1e-9)
    exponent = min(max(exponent, min(_PREFIXES)), 0)
    number = rounded * 10.0**-exponent
    shown = f"{value:.0f}" if number >= 999.5 else f"{number:.{digits}g}"
    return f"{shown} {_PREFIXES[exponent]}{unit}"


def listed(names: Sequence[str], most: int) -> str:
    """Return the first `most` names, and how many more there are: "a, b and 3 more"."""
    more = len(names) - most
    return ", ".join(names[:most]) + (f" and {more} more" if more > 0 else "")
