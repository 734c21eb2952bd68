"""Colours of the page: what reads on what, and engines' colours on light and dark paper.

An engine has one colour in every figure (`reports.style`). On the page's paper, light or dark, it
is mixed with ink until a line of it can be distinguished from the paper.
"""

from __future__ import annotations

from collections.abc import Sequence

from ghostball.reports import style

LEAST_LINE = 3.0
"""Contrast that WCAG 2.2 asks for of what isn't text, level AA (1.4.11)."""

LIGHT_PAPER, DARK_PAPER = "#ffffff", "#14181d"
LIGHT_INK, DARK_INK = "#1a1f24", "#e6eaee"
"""`--paper` and `--ink` of page.css in both schemes; a test holds them to it."""

_STEPS = 40


def contrast(one: str, other: str) -> float:
    """Return the contrast of two colours "#rrggbb", 1 to 21 (WCAG 2.2, "contrast ratio")."""
    lighter, darker = sorted((_luminance(one), _luminance(other)), reverse=True)
    return (lighter + 0.05) / (darker + 0.05)


def readable(colour: str, paper: str) -> str:
    """Return a colour mixed with as little ink as makes a line of it readable on `paper`."""
    ink = max("#000000", "#ffffff", key=lambda one: contrast(one, paper))
    for step in range(_STEPS + 1):
        mixed = _mix(colour, ink, step / _STEPS)
        if contrast(mixed, paper) >= LEAST_LINE:
            return mixed
    return ink


def engine_css(labels: Sequence[str]) -> str:
    """Return the custom properties `--engine-0`, ... of the engines, for both schemes.

    Ours is black in figures, so that it has the colour of ink here.
    """
    light, dark = (
        "".join(
            f"--engine-{k}:{ink if look.ours else readable(look.colour, paper)};"
            for k, look in enumerate(map(style.engine_style, labels))
        )
        for paper, ink in ((LIGHT_PAPER, LIGHT_INK), (DARK_PAPER, DARK_INK))
    )
    return f":root{{{light}}}@media screen and (prefers-color-scheme: dark){{:root{{{dark}}}}}"


def _luminance(colour: str) -> float:
    parts = [value / 255 for value in _parts(colour)]
    linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def _mix(colour: str, ink: str, part: float) -> str:
    mixed = (
        round((1.0 - part) * a + part * b) for a, b in zip(_parts(colour), _parts(ink), strict=True)
    )
    return "#" + "".join(f"{value:02x}" for value in mixed)


def _parts(colour: str) -> tuple[int, int, int]:
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
