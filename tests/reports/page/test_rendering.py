"""Fails where text from a scene or an engine becomes markup, or leads out of the page."""

import json

import pytest

from ghostball.reports.page.rendering import (
    embedded_json,
    inline,
    markdown,
    render,
)

EVIL = [
    "</script><script>alert(1)</script>",
    '<img src=x onerror="alert(1)">',
    "![a](https://example.org/a.png)",
    "[a](https://example.org)",
    "[a](javascript:alert(1))",
    "<https://example.org>",
    '[a](#x"onclick="alert(1))',
    "`<b>`",
]


@pytest.mark.parametrize("text", EVIL)
def test_text_stays_text(text):
    for html in (inline(text), markdown(text), markdown(f"- {text}")):
        assert "<script" not in html
        assert "<img" not in html
        assert "<b>" not in html
        assert 'href="h' not in html
        assert 'href="j' not in html
        assert '"onclick' not in html


def test_markdown_of_ours_is_shown():
    text = "**bold** *so* `code` and [stop](#stop)"
    assert inline(text) == (
        "<strong>bold</strong> <em>so</em> <code>code</code> and "
        '<a href="#scene=stop">stop</a>'
    )  # fmt: skip


def test_a_table_names_its_region_its_columns_and_its_rows():
    html = markdown("| a | b |\n| --- | --- |\n| x \\| y | 1 |", 'What "it" is')
    assert 'role="region" aria-label="What &#34;it&#34; is" tabindex="0"' in html
    assert "<caption>What &#34;it&#34; is</caption>" in html
    assert html.count('<th scope="col">') == 2
    assert '<th scope="row">x | y</th>' in html
    assert "<td>1</td>" in html


def test_json_can_not_end_its_script():
    value = {"title": "</script><!-- & \u2028", "x": [0.1, None]}
    text = embedded_json(value)
    assert not set("<>&\u2028") & set(text)
    assert json.loads(text) == value


def test_a_value_that_is_missing_is_no_empty_text():
    with pytest.raises(Exception, match="undefined"):
        render("scene.html")
