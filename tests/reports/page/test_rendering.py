"""Texts and colours of the page: markup is escaped, and texts have enough contrast."""

import json
import re
from importlib.resources import files

import pytest

from ghostball.reports import style
from ghostball.reports.accuracy import CLASSES
from ghostball.reports.page.rendering import (
    DARK_INK,
    LIGHT_INK,
    ON_DARK,
    ON_LIGHT,
    codes,
    embedded_json,
    engine_css,
    render,
)

EVIL = ["</script><script>alert(1)</script>", '<img src=x onerror="alert(1)">', "`<b>`"]


CSS = files("ghostball.reports.page").joinpath("assets", "page.css").read_text(encoding="utf-8")
TEXTS = [
    (ink, paper)
    for ink in ("ink", "muted", "accent")
    for paper in ("paper", "panel")
] + [
    ("on-accent", "accent"),
    ("ink", "cloth"),
    *((f"{kind}-ink", f"{kind}-paper") for kind in ("pass", "fail", "holds", "ref")),
    *((f"{look.slug}-ink", f"{look.slug}-paper") for look in CLASSES.values()),
]  # fmt: skip
LEAST_TEXT = 4.5  # contrast of text that WCAG 2.2 requires, level AA (1.4.3)
LEAST_LINE = 3.0  # contrast of graphics (1.4.11)


@pytest.mark.parametrize("text", EVIL)
def test_text_stays_text(text):
    html = codes(text)
    assert "<script" not in html
    assert "<img" not in html
    assert "<b>" not in html


def test_what_stands_between_back_quotes_is_code():
    assert codes("run `ghostball <x>` & so on") == (
        "run <code>ghostball &lt;x&gt;</code> &amp; so on"
    )  # fmt: skip


def test_json_can_not_end_its_script():
    value = {"title": "</script><!-- & \u2028", "x": [0.1, None]}
    text = embedded_json(value)
    assert not set("<>&\u2028") & set(text)
    assert json.loads(text) == value


def test_a_value_that_is_missing_is_no_empty_text():
    with pytest.raises(Exception, match="undefined"):
        render("scene.html")


def properties(scheme):
    light, dark = re.findall(r":root \{([^}]*)\}", CSS)
    found = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", light))
    if scheme == "dark":
        changed = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", dark))
        assert set(changed) == set(found), "a colour of one scheme would show in the other"
        found |= changed
    return found


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize(("ink", "paper"), TEXTS)
def test_text_can_be_read(scheme, ink, paper):
    colours = properties(scheme)
    assert contrast(colours[ink], colours[paper]) >= LEAST_TEXT


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_colour_of_the_stylesheet_is_one_of_these(scheme):
    # A pair of colours missing in the test above could be unreadable.
    known = {name for pair in TEXTS for name in pair} | {"line", "cushion"}
    assert set(properties(scheme)) == known
    assert not re.findall(r"(?:color|background|fill|stroke)\s*:\s*(?:#|rgb|hsl)", CSS)


def contrast(one: str, other: str) -> float:
    """Return the contrast of two colours "#rrggbb", 1 to 21 (WCAG 2.2, "contrast ratio")."""
    darker, lighter = sorted(map(luminance, (one, other)))
    return (lighter + 0.05) / (darker + 0.05)


def luminance(colour: str) -> float:
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    red, green, blue = (v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def test_contrast_is_that_of_the_standard():
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.478, abs=1e-3)


def test_inks_are_those_of_the_stylesheet():
    assert [properties(scheme)["ink"] for scheme in ("light", "dark")] == [LIGHT_INK, DARK_INK]


@pytest.mark.parametrize(("scheme", "other"), [("light", ON_LIGHT), ("dark", ON_DARK)])
def test_lines_of_engines_can_be_seen_on_both_papers_and_change_only_where_they_must(scheme, other):
    paper = properties(scheme)["paper"]
    for colour in {*style.FAMILY_COLOURS.values(), *style.OTHER_COLOURS} - {style.BLACK}:
        assert contrast(other.get(colour, colour), paper) >= LEAST_LINE
        assert (contrast(colour, paper) < LEAST_LINE) == (colour in other)


def test_each_engine_has_its_colour_and_ours_that_of_ink():
    assert engine_css(["ghostball", "billiards"]) == (
        f":root{{--engine-0:{LIGHT_INK};--engine-1:#4999c6;}}@media screen and "
        f"(prefers-color-scheme: dark){{:root{{--engine-0:{DARK_INK};--engine-1:#56b4e9;}}}}"
    )
