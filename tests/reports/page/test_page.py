"""Fails where the page lacks a part, hides a failure, asks a network, or lets text be markup."""

import json
import re
from collections import Counter
from html.parser import HTMLParser

import numpy as np
import pytest
from stored_results import (
    change_motion,
    damage_motions,
    edit_records,
)

from ghostball.model import GhostballError
from ghostball.reports import PAGE, write_report
from ghostball.reports.page import scene_part
from ghostball.reports.shots import load_shot
from ghostball.validation.baselines import (
    FirstDifference,
    Quantity,
    Regression,
    SceneChange,
    save_regressions,
)
from ghostball.validation.results.store import Results

# The page needs no figure.
pytestmark = pytest.mark.usefixtures("without_run_figures")

SECTIONS = ["verdict", "matrix", "scenes", "failures", "numbers", "board", "stress", "run"]
ALWAYS = [name for name in SECTIONS if name not in ("board", "stress")]
"""Those that are there whatever lies beside the results."""

EVIL = "</script><script>alert(1)</script><img src=x onerror=alert(1)>"
VOID = {"meta", "link", "br", "wbr", "input", "hr", "img"}
OPTIONAL = {"li", "dt", "dd", "tr", "td", "th", "thead", "tbody", "p"}


class Reader(HTMLParser):
    """Collects elements; says where one is closed that isn't open."""

    def __init__(self):
        super().__init__()
        self.elements, self.open, self.wrong, self.texts = [], [], [], []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        while self.open and self.open[-1] != tag and self.open[-1] in OPTIONAL:
            self.open.pop()
        if not self.open or self.open[-1] != tag:
            self.wrong.append((tag, self.getpos()))
        else:
            self.open.pop()

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("script", "style"):
            self.texts.append(data)

    def all(self, tag):
        return [attrs for name, attrs in self.elements if name == tag]


def read(html):
    reader = Reader()
    reader.feed(html)
    reader.close()
    return reader


def page_of(folder):
    return write_report(folder, figures="none").read_text(encoding="utf-8")


def section(html, name):
    start = html.index(f'<section id="{name}"')
    return html[start : html.find('<section id="', start + 1)]


def folded(html, name):
    """Return a part of a section that is folded."""
    start = html.index(f'<details class="part" id="{name}"')
    return html[start : html.find('<details class="part"', start + 1)]


@pytest.fixture(scope="module")
def html(module_folder):
    """Three scenes on seven engines: some pass, some fail, one crashed, one can't represent."""
    return page_of(module_folder)


def test_sections_come_in_order_and_each_is_in_the_navigation(html):
    assert re.findall(r'<section id="([\w-]+)"', html) == ALWAYS
    navigation = html[html.index('<nav class="sections"') : html.index("<main>")]
    assert re.findall(r'href="#([\w-]+)"', navigation) == ALWAYS
    assert len(SECTIONS) <= 9  # more don't stay in the bar


def test_what_is_long_is_folded_but_the_first_picture(html):
    parts = re.findall(r'<details class="part" id="([\w-]+)"( open)?>', html)
    assert [name for name, opened in parts if opened] == ["cost"]
    assert [name for name, _ in parts] == [
        *("cost", "closed-forms", "horizons", "energy", "hashes", "timing"),
        *("truth", "environment"),
    ]


def test_the_markup_is_whole(html):
    reader = read(html)
    assert reader.wrong == []
    assert [tag for tag in reader.open if tag not in OPTIONAL] == []
    ids = Counter(attrs["id"] for _, attrs in reader.elements if "id" in attrs)
    assert [name for name, count in ids.items() if count > 1] == []
    targets = {a["href"][1:] for a in reader.all("a")}
    assert targets - set(ids) == set()
    assert {ref for _, attrs in reader.elements if (ref := attrs.get("aria-labelledby"))} <= set(
        ids
    )


def test_nothing_is_asked_of_a_network(html):
    reader = read(html)
    for _, attrs in reader.elements:
        for name in ("src", "href", "srcset", "data", "action", "poster", "xlink:href"):
            value = attrs.get(name, "#")
            assert value.startswith(("#", "data:")), (name, value)
    shown = re.sub(r'<script type="application/json".*?</script>', "", html, flags=re.DOTALL)
    assert not re.search(r"@import|url\((?!['\"]?data:)", shown)
    assert not re.search(r"\b(fetch|XMLHttpRequest|WebSocket|importScripts|sendBeacon)\b", shown)
    assert "//" not in re.sub(r"(?m)^\s*//.*$|\s// .*$", "", shown).replace(
        "http://www.w3.org/2000/svg", ""
    )


def test_tables_have_captions_and_scopes_and_can_be_scrolled_by_keys(html):
    tables = re.findall(r"<table.*?</table>", html, flags=re.DOTALL)
    assert len(tables) > 20
    for table in tables:
        assert "<caption>" in table
        assert re.findall(r"<th(?! scope=)[ >]", table) == []
    for region in re.findall(r'<div class="wide"[^>]*>', html):
        assert 'role="region"' in region
        assert 'aria-label="' in region
        assert 'tabindex="0"' in region


def test_the_verdict_comes_first_with_what_failed(html):
    text = section(html, "verdict")
    assert "Of 21 cases, 6 failed, 1 did not finish." in text
    assert "<strong>8 passed, 6 failed</strong>" in text
    assert '<a href="#scene=stop">stop</a> on <code>paper-discrete</code>' in text
    assert "No comparison was made" in text
    assert "ghostball regress" in text


def test_what_is_excused_stands_beside_the_verdict_with_the_reason(html):
    said = section(html, "verdict")
    (listed,) = re.findall(r'<ul class="key excused">(.*?)</ul>', said)
    assert listed == (
        "<li><code>pymunk:<wbr>config=default</code> in 3 of the scenes: overlap_max, accuracy. "
        "A newcomer &lt;types&gt; this.</li>"
    )


def test_nobody_is_said_to_be_excused_who_is_not(small_folder):
    assert "[[excused]]" not in page_of(small_folder)


def test_the_matrix_says_why_without_colour_and_without_a_pointer(html):
    text = section(html, "matrix")
    link = "#scene=stop&amp;engine=ghostball&amp;engine=pymunk%3Aconfig%3Ddefault"
    cell = f'<td class="acc-cm"><a href="#scene=stop" data-view="{link}">90 mm <span class="mark">✗'
    assert f'{cell}</span><span class="why">' in text
    assert (
        "stop on pymunk:config=default: centimetres: the farthest ball is 90 mm from where it "
        "should be; worse than its limits: rest_error_max breaks its limit" in text
    )
    assert "<code>pybullet</code> not representable: no table | with legs" in text
    assert "did not finish: division by zero" in text


def test_every_scene_has_its_section_and_its_data(html):
    for name in ("stop", "head-on", "break-7"):
        assert f'<section class="scene" id="scene={name}"' in html
        data = re.search(
            f'<script type="application/json" id="replay-{name}">(.*?)</script>', html, re.DOTALL
        )
        assert json.loads(data[1])["scene"] == name
        assert f'data-replay="replay-{name}"' in html


def test_a_limit_is_said_once_with_all_that_it_judges(html):
    start = html.index('id="scene=stop"')
    text = html[start : html.index("</section>", start)]
    assert text.count("a tenth of a ball") == 1 + 2  # in its table, and with each that breaks it
    assert "<li>✓ <code>pymunk</code> 2 mm</li>" in text
    assert "<li>✗ <code>paper-discrete</code> 30 mm</li>" in text


def test_every_failure_is_explained_with_its_command_and_what_it_must_give(html):
    text = section(html, "failures")
    assert text.count('<details class="failure"') == 7
    assert "<dt>Expected<dd>at most 5 mm" in text
    assert "<dt>Found<dd>30 mm (0.03 m)" in text
    assert "ghostball explain stop --engine paper-discrete" in text
    assert "ghostball run head-on --engine newcomer:dt=1e-3" in text
    assert re.search(r'<code>hash</code> [^<]* <code class="hash">[0-9a-f]{64}</code>', text)
    assert "<code>cue</code> at (1.47, 0.8) m" in text


def test_what_is_missing_says_so_and_how_to_get_it(html):
    for name, words in {
        "closed-forms": "is what rounding the scene’s numbers once would cause",
        "cost": "one sample of its run time each",
        "horizons": "can be predicted to their end",
        "energy": "No motion of an engine that records it exactly is stored",
        "hashes": "No comparison was made",
        "timing": "One sample each",
    }.items():
        assert words in folded(html, name), name


def test_text_of_scenes_and_engines_is_inert(small_folder):
    evil = json.dumps(EVIL)[1:-1]

    def spoiled(text):
        text = text.replace("One ball rolls to rest", evil).replace("a tenth of a ball", evil)
        return text.replace('"reason":""', f'"reason":"{evil}"')

    edit_records(small_folder, spoiled)
    html = page_of(small_folder)
    reader = read(html)
    assert reader.wrong == []
    assert reader.all("img") == []
    assert all("onerror" not in attrs for _, attrs in reader.elements)
    assert "alert(1)" in "".join(reader.texts)  # shown, not dropped
    scripts = re.findall(r"<script(?![^>]*application/json)[^>]*>(.*?)</script>", html, re.DOTALL)
    assert len(scripts) == 2
    assert all("alert(1)" not in script for script in scripts)


def test_a_damaged_motion_leaves_the_old_page(small_folder):
    (small_folder / PAGE).write_text("old")
    damage_motions(small_folder)
    with pytest.raises(GhostballError, match=r"the motion of .* is damaged"):
        write_report(small_folder)
    assert (small_folder / PAGE).read_text() == "old"


def regression(**changes):
    fields = {
        "scene": "stop",
        "title": "One ball rolls to rest",
        "change": "worse",
        "failed": True,
        "summary": f"the cue ball ends 3 mm farther {EVIL}",
        "first_difference": FirstDifference(
            index=4, before_horizon=True, words="cue hits 1 no more"
        ),
        "metrics": (
            Quantity(
                name="rest_error_max", unit="m", base=1e-16, head=3e-3, high=1e-15,
                level="error", within=False, why="a few roundings",
            ),
        ),
        "counters": (
            Quantity(
                name="events", unit="1", base=9, head=9, level="warn", within=True, why="exact"
            ),
        ),
        "base_hash": "a" * 64,
        "head_hash": "b" * 64,
        "rest_base": ((1.5, 0.8, 0.028575),),
        "rest_head": ((1.503, 0.8, 0.028575),),
        "command": "ghostball regress stop",
    }  # fmt: skip
    change = SceneChange(**(fields | changes))
    return Regression(base={}, head={}, outcome="failed", scenes=(change,))


def test_what_changed_is_shown_with_both_sides(small_folder):
    save_regressions([regression()], small_folder)
    html = page_of(small_folder)
    text = section(html, "verdict")
    assert "✗ the gate fails" in text
    assert "worse than what was accepted: 1, <strong>fails</strong>" in text
    assert "(1.5, 0.8) m<td>(1.503, 0.8) m<td>3 mm" in text
    assert "<code>rest_error_max</code><td>0.1 fm<td>3 mm<td>+3 mm<td>to 1 fm<td>✗" in text
    assert "cue hits 1 no more" in text
    assert "1 did not" in text
    assert '<circle class="head" cx="1.503" cy="0.8" r="0.028575"/>' in text
    assert '<circle class="base" cx="1.5" cy="0.8" r="0.028575"/>' in text
    assert "≠ not equal" in folded(html, "hashes")
    assert read(html).wrong == []
    assert "<img" not in html


@pytest.mark.parametrize("label", ["ghostball", "pymunk"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_an_engine_that_blew_up_does_not_break_the_page(small_folder, label, bad):
    def blown_up(values):
        return np.where(np.arange(len(values)) < len(values) // 2, values.T, bad).T

    names = ("positions", "velocities", "angular_velocities")
    energies = ("energy_translation", "energy_rotation", "energy_height")
    change_motion(small_folder, "stop", label, **dict.fromkeys(names + energies, blown_up))
    html = page_part(small_folder)
    assert "nan" not in "".join(re.findall(r'<path[^>]* d="([^"]*)"', html))
    assert "Energy of all balls against time" in html


def page_part(folder):
    """The scene's part alone: the figures of the report have tests of their own."""
    return scene_part(load_shot(Results.open(folder), "stop")).html
