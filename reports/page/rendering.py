"""How text gets into the page: templates that escape, Markdown of our own, JSON, stylesheets.

Titles and reasons come from users' files and from other people's engines. Nothing of them may
become markup: templates escape what isn't `Markup`, the Markdown that reports share knows no HTML,
no picture and no link but to a place in the page, and JSON within a script has no `<`.
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
from markdown_it import MarkdownIt
from markdown_it.renderer import RendererHTML
from markdown_it.token import Token
from markdown_it.utils import EnvType, OptionsDict
from markupsafe import Markup

from ghostball.reports import style

SCENE_ANCHOR = "scene="
"""What stands before a scene's name in the fragment that leads to it."""


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
        inline=inline,
        label=label_html,
        markdown=markdown,
        time=style.format_time,
    )
    return environment


def render(template: str, **values: Any) -> Markup:
    """Return a template filled with values."""
    return Markup(templates().get_template(template).render(values))


def asset(name: str) -> Markup:
    """Return a stylesheet or script of ours, to stand within its element.

    Raises
    ------
    ValueError
        Where it would end that element early.
    """
    text = files("ghostball.reports.page").joinpath("assets", name).read_text(encoding="utf-8")
    if "</style" in text.lower() or "</script" in text.lower():
        raise ValueError(f"asset {name} holds the end of its own element")
    return Markup(text)


def embedded_json(value: Any) -> Markup:
    """Return JSON for `<script type="application/json">`: it can't end the element, nor start one.

    Raises
    ------
    ValueError
        Where a number is nan or infinite, for which JSON has no word.
    """
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    for sign in "<>&\u2028\u2029":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Markup(text)


def label_html(label: str) -> Markup:
    """Return an engine's label, which may break after its name and between settings."""
    return Markup("<code>%s</code>") % Markup("<wbr>").join(re.split(r"(?<=[:,])", label))


def inline(text: str) -> Markup:
    """Return one line of the Markdown that reports are written in, as HTML."""
    return Markup(_markdown().renderInline(text, {}))


def markdown(text: str | Sequence[str], caption: str = "", *, wraps: bool = False) -> Markup:
    """Return paragraphs, lists and tables of the Markdown that reports are written in, as HTML.

    Parameters
    ----------
    text : str or sequence of str
        One text, or parts of it.
    caption : str
        Of each table in it, which says also what its region is called; one that has none is
        no table of ours, and its region is called "Table".
    wraps : bool
        Whether its cells hold sentences, which go on in a next line.
    """
    parts = text if isinstance(text, str) else "\n\n".join(part for part in text if part)
    return Markup(_markdown().render(parts, {"caption": caption, "wraps": wraps}))


@cache
def _markdown() -> MarkdownIt:
    # No HTML, no pictures, no links found in plain text: what isn't enabled stays text.
    parser = MarkdownIt("zero", {"html": False}).enable(
        ["table", "list", "blockquote", "heading", "backticks", "emphasis", "escape", "link"]
    )
    parser.validateLink = lambda url: url.startswith("#")  # type: ignore[method-assign]
    parser.add_render_rule("link_open", _link_open)
    parser.add_render_rule("table_open", _table_open)
    parser.add_render_rule("table_close", _table_close)
    parser.add_render_rule("th_open", _th_open)
    parser.add_render_rule("td_open", _td_open)
    parser.add_render_rule("td_close", _td_close)
    return parser


def _link_open(
    _self: RendererHTML, tokens: Sequence[Token], idx: int, _options: OptionsDict, _env: EnvType
) -> str:
    # Markdown of ours leads to scenes by their names.
    target = str(tokens[idx].attrs["href"]).removeprefix("#")
    return f'<a href="#{SCENE_ANCHOR}{Markup.escape(target)}">'


def _table_open(
    _self: RendererHTML, _tokens: Sequence[Token], _idx: int, _options: OptionsDict, env: EnvType
) -> str:
    caption = Markup.escape(env.get("caption", ""))
    # What has the focus has a name.
    name = f' role="region" aria-label="{caption or "Table"}"'
    said = f"<caption>{caption}</caption>" if caption else ""
    kind = ' class="text"' if env.get("wraps") else ""
    return f'<div class="wide"{name} tabindex="0"><table{kind}>{said}'


def _table_close(
    _self: RendererHTML, _tokens: Sequence[Token], _idx: int, _options: OptionsDict, _env: EnvType
) -> str:
    return "</table></div>"


def _th_open(
    _self: RendererHTML, _tokens: Sequence[Token], _idx: int, _options: OptionsDict, _env: EnvType
) -> str:
    return '<th scope="col">'


def _td_open(
    _self: RendererHTML, tokens: Sequence[Token], idx: int, _options: OptionsDict, _env: EnvType
) -> str:
    # The first cell of a row says what the row is about.
    return '<th scope="row">' if _is_first(tokens, idx) else "<td>"


def _td_close(
    _self: RendererHTML, tokens: Sequence[Token], idx: int, _options: OptionsDict, _env: EnvType
) -> str:
    opened = next(i for i in range(idx, -1, -1) if tokens[i].type == "td_open")
    return "</th>" if _is_first(tokens, opened) else "</td>"


def _is_first(tokens: Sequence[Token], idx: int) -> bool:
    return tokens[idx - 1].type == "tr_open"
