"""The page has all parts and failures, makes no requests, and shows texts without markup."""

import json
import re
from collections import Counter

import pytest
from page_texts import OPTIONAL, page_of, read, section
from stored_records import damage_motions, edit_records

from ghostball.model import GhostballError
from ghostball.reports import PAGE, write_report

SECTIONS = [
    *("verdict", "comparison", "matrix", "scenes", "failures", "numbers"),
    *("real-tables", "stress", "run"),
]
ALWAYS = [name for name in SECTIONS if name not in ("real-tables", "stress")]
"""Sections that every page has."""

EVIL = "</script><script>alert(1)</script><img src=x onerror=alert(1)>"


def test_sections_come_in_order_and_each_is_in_the_navigation(html):
    assert re.findall(r'<section id="([\w-]+)"', html) == ALWAYS
    navigation = html[html.index('<nav class="sections"') : html.index("<main>")]
    assert re.findall(r'href="#([\w-]+)"', navigation) == ALWAYS
    assert len(SECTIONS) <= 9  # more don't fit into the bar


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


def test_what_is_excused_is_one_folded_line_below_the_verdict_with_the_reason_inside(html):
    said = section(html, "verdict")
    (folded,) = re.findall(r'<details class="key">(.*?)</details>', said, re.DOTALL)
    assert "<summary>Excused from common limits: pymunk, naive</summary>" in folded
    (listed,) = re.findall(r'<ul class="excused">(.*?)</ul>', folded)
    assert listed == (
        "<li><code>pymunk:<wbr>config=naive</code> in 3 of the scenes: overlap_max, accuracy. "
        "A newcomer &lt;types&gt; this.</li>"
    )


def test_nobody_is_said_to_be_excused_who_is_not(small_folder):
    assert "[[excused]]" not in page_of(small_folder)


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
