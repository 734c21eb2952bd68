"""Fill the page's templates: escaping, JSON, stylesheets and scripts, colours of engines.

Titles and reasons come from users' files and from other people's engines and must not become
markup: templates escape every value that isn't `Markup`, and JSON within a script has no `<`.

Each engine has one colour in all figures (`reports.style`); a colour too faint for the page is
darkened or lightened.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from typing import Any
from urllib.parse import urlencode

from jinja2 import Environment
from markupsafe import Markup

from ghostball.reports import style
from ghostball.reports.templating import templates_of
from ghostball.reports.words import many

REPLAY_SCRIPTS = (
    *("replay_parts.js", "replay_look.js", "replay_cloth.js", "replay_player.js"),
    *("replay_turning.js", "replay_motion.js", "replay_plate.js", "replay_side.js"),
    *("replay_timeline.js", "replay_readout.js", "replay_events.js", "replay_help.js"),
    "replay.js",
)
"""Scripts of the replay, in the order of execution: each adds to the global object `Ghostball`."""


LIGHT_INK, DARK_INK = "#1a1f24", "#e6eaee"
"""The colour `--ink` in page.css, in the light and dark scheme. A test compares both files."""

ON_LIGHT = {style.ORANGE: "#c48700", style.SKY: "#4999c6", style.YELLOW: "#9c942b"}
ON_DARK = {style.BROWN: "#875c1a"}
"""Replacements for colours of engines that are too faint on the page's background.

Each is the original colour mixed with the least ink that gives a contrast of 3, which WCAG 2.2
requires for graphics (1.4.11, level AA).
"""


def scene_link(scene: str, t: float | None = None, engines: Sequence[str] = ()) -> str:
    """Return the URL fragment that opens a scene at time t [s] and shows these engines."""
    at = [] if t is None else [("t", repr(t))]
    shown = [("engine", engine) for engine in dict.fromkeys(engines)]
    return "#" + urlencode([("scene", scene), *at, *shown])


@cache
def templates() -> Environment:
    """Return the templates of the page, which escape every value."""
    environment = templates_of("ghostball.reports.page")
    environment.filters.update(
        codes=codes,
        engine=style.engine_name,
        label=label_html,
        time=style.format_time,
        quantity=style.format_quantity,
        digits=lambda number: repr(float(number)),
    )
    environment.globals.update(many=many)
    return environment


def render(template: str, **values: Any) -> Markup:
    """Return a template filled with values."""
    return Markup(templates().get_template(template).render(values))


def asset(name: str) -> Markup:
    """Return a stylesheet or script of this package, as the content of its HTML element."""
    text = files("ghostball.reports.page").joinpath("assets", name).read_text(encoding="utf-8")
    if "</style" in text.lower() or "</script" in text.lower():
        raise ValueError(f"asset {name} holds the end of its own element")
    return Markup(text)


def replay_script() -> Markup:
    """Return the script that defines `Ghostball.mountReplay`, as the content of `<script>`."""
    return Markup("\n").join(map(asset, REPLAY_SCRIPTS))


def embedded_json(value: Any) -> Markup:
    """Return JSON for `<script type="application/json">`.

    The JSON can't start or end an element or a comment.
    """
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    for sign in "<>&\u2028\u2029":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Markup(text)


def label_html(label: str) -> Markup:
    """Return an engine's label; a line may break after the name and between settings."""
    return Markup("<code>%s</code>") % Markup("<wbr>").join(re.split(r"(?<=[:,])", label))


def codes(text: str) -> Markup:
    """Return a sentence of this package as markup: text between `back quotes` becomes code."""
    parts = enumerate(text.split("`"))
    return Markup("").join(Markup("<code>%s</code>") % part if k % 2 else part for k, part in parts)


def engine_css(labels: Sequence[str]) -> str:
    """Return the CSS properties `--engine-0`, `--engine-1`, ... for the light and dark scheme.

    Ghostball's engine, black in figures, has the colour `--ink` on the page.
    """
    light, dark = (
        "".join(
            f"--engine-{k}:{ink if look.ours else other.get(look.colour, look.colour).lower()};"
            for k, look in enumerate(map(style.engine_style, labels))
        )
        for other, ink in ((ON_LIGHT, LIGHT_INK), (ON_DARK, DARK_INK))
    )
    return f":root{{{light}}}@media screen and (prefers-color-scheme: dark){{:root{{{dark}}}}}"
