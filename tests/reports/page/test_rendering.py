"""Fails where text from a scene or an engine becomes markup, or leads out of the page."""

import json

import pytest

from ghostball.reports.page.rendering import (
    codes,
    embedded_json,
    render,
)

EVIL = ["</script><script>alert(1)</script>", '<img src=x onerror="alert(1)">', "`<b>`"]


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
