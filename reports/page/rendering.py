"""How text gets into the page: templates that escape, JSON, stylesheets, engines' colours.

Titles and reasons come from users' files and from other people's engines. Nothing of them may
become markup: templates escape what isn't `Markup`, and JSON within a script has no `<`.

An engine has one colour in every figure (`reports.style`). On the page's paper, light or dark, the
colour is mixed with ink until a line of it can be distinguished from the paper.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from typing import Any
from urllib.parse import urlencode

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from ghostball.reports import style

REPLAY_SCRIPTS = (
    *("replay_parts.js", "replay_look.js", "replay_cloth.js", "replay_player.js"),
    *("replay_turning.js", "replay_motion.js", "replay_plate.js", "replay_side.js"),
    *("replay_timeline.js", "replay_readout.js", "replay_events.js", "replay_help.js"),
    "replay.js",
)
"""In the order in which a page runs them: each adds to the global object `Ghostball`."""


LEAST_LINE = 3.0
"""Contrast that WCAG 2.2 asks for of what isn't text, level AA (1.4.11)."""

LIGHT_PAPER, DARK_PAPER = "#ffffff", "#14181d"
LIGHT_INK, DARK_INK = "#1a1f24", "#e6eaee"
"""`--paper` and `--ink` of page.css in both schemes; a test holds them to it."""

_STEPS = 40


def scene_link(scene: str, t: float | None = None, engines: Sequence[str] = ()) -> str:
    """Return the fragment that opens a scene, at an instant [s] and with these engines shown."""
    at = [] if t is None else [("t", repr(t))]
    shown = [("engine", engine) for engine in dict.fromkeys(engines)]
    return "#" + urlencode([("scene", scene), *at, *shown])


@cache
def templates() -> Environment:
    """Return the templates of the page, which escape every value."""
    environment = Environment(
        loader=PackageLoader("ghostball.reports.page"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(
        codes=codes,
        label=label_html,
        time=style.format_time,
        length_text=lambda metres: style.format_length(float(metres)),
        digits=lambda number: repr(float(number)),
    )
    return environment


def render(template: str, **values: Any) -> Markup:
    """Return a template filled with values."""
    return Markup(templates().get_template(template).render(values))


def asset(name: str) -> Markup:
    """Return a stylesheet or script of ours, to stand within its element."""
    text = files("ghostball.reports.page").joinpath("assets", name).read_text(encoding="utf-8")
    if "</style" in text.lower() or "</script" in text.lower():
        raise ValueError(f"asset {name} holds the end of its own element")
    return Markup(text)


def replay_script() -> Markup:
    """Return what defines `Ghostball.mountReplay`, for `<script>`."""
    return Markup("\n").join(map(asset, REPLAY_SCRIPTS))


def embedded_json(value: Any) -> Markup:
    """Return JSON for `<script type="application/json">`, which can neither end nor start one.

    Nor can it a comment.
    """
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    for sign in "<>&\u2028\u2029":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Markup(text)


def label_html(label: str) -> Markup:
    """Return an engine's label, which may break after its name and between settings."""
    return Markup("<code>%s</code>") % Markup("<wbr>").join(re.split(r"(?<=[:,])", label))


def codes(text: str) -> Markup:
    """Return a sentence of ours in which what stands between `back quotes` is code."""
    parts = enumerate(text.split("`"))
    return Markup("").join(Markup("<code>%s</code>") % part if k % 2 else part for k, part in parts)


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
