"""Text and colours of the page: markup is escaped, and what is read can be read."""

import json
import re
from importlib.resources import files

import pytest

from ghostball.reports import style
from ghostball.reports.accuracy import CLASSES
from ghostball.reports.page.rendering import (
    DARK_INK,
    DARK_PAPER,
    LEAST_LINE,
    LIGHT_INK,
    LIGHT_PAPER,
    codes,
    contrast,
    embedded_json,
    engine_css,
    readable,
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
LEAST_TEXT = 4.5  # what WCAG 2.2 asks for, level AA (1.4.3)
LABELS = ["ghostball", "pymunk", "paper-discrete", "billiards", "pooltool", "newcomer:x=1"]


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
    # A pair that the test above doesn't know could be unreadable.
    known = {name for pair in TEXTS for name in pair} | {"line", "cushion"}
    assert set(properties(scheme)) == known
    assert not re.findall(r"(?:color|background|fill|stroke)\s*:\s*(?:#|rgb|hsl)", CSS)


def test_contrast_is_that_of_the_standard():
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.478, abs=1e-3)


def test_papers_and_inks_are_those_of_the_stylesheet():
    assert properties("light")["paper"] == LIGHT_PAPER
    assert properties("dark")["paper"] == DARK_PAPER
    assert properties("light")["ink"] == LIGHT_INK
    assert properties("dark")["ink"] == DARK_INK


def test_lines_of_engines_can_be_seen_on_both_papers():
    found = re.findall(r"--engine-(\d+):(#[0-9a-f]{6})", engine_css(LABELS))
    assert len(found) == 2 * len(LABELS)
    for k, (_, colour) in enumerate(found):
        paper = LIGHT_PAPER if k < len(LABELS) else DARK_PAPER
        assert contrast(colour, paper) >= LEAST_LINE


def test_a_colour_that_can_be_seen_stays_as_it_is():
    assert readable(style.BLUE, LIGHT_PAPER) == style.BLUE.lower()
