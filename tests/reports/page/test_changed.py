"""Fails where a scene that changed isn't shown with both sides."""

import pytest
from page_texts import folded, page_of, read, section

from ghostball.validation.baselines import (
    FirstDifference,
    Quantity,
    Regression,
    SceneChange,
    save_regressions,
)

# The page needs no figure.
pytestmark = pytest.mark.usefixtures("without_run_figures")


EVIL = "</script><script>alert(1)</script><img src=x onerror=alert(1)>"


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
        "metrics": (Quantity(name="rest_error_max", unit="m", base=1e-16, head=3e-3),),
        "counters": (Quantity(name="events", unit="1", base=9, head=None),),
        "base_hash": "a" * 64,
        "head_hash": "b" * 64,
        "rest_base": ((1.5, 0.8, 0.028575),),
        "rest_head": ((1.503, 0.8, 0.028575),),
        "command": "ghostball regress stop",
    }
    change = SceneChange(**(fields | changes))
    return Regression(head={}, outcome="failed", scenes=(change,))


def test_what_changed_is_shown_with_both_sides(small_folder):
    save_regressions([regression()], small_folder)
    html = page_of(small_folder)
    text = section(html, "verdict")
    assert "✗ the gate fails" in text
    assert "worse: farther from the reference result: 1, <strong>fails</strong>" in text
    assert "(1.5, 0.8) m<td>(1.503, 0.8) m<td>3 mm" in text
    assert "<code>rest_error_max</code><td>0.1 fm<td>3 mm<td>+3 mm" in text
    assert "<code>events</code><td>9<td>–<td>–" in text
    assert "cue hits 1 no more" in text
    assert '<circle class="head" cx="1.503" cy="0.8" r="0.028575"/>' in text
    assert '<circle class="base" cx="1.5" cy="0.8" r="0.028575"/>' in text
    assert "≠ not equal" in folded(html, "hashes")
    assert read(html).wrong == []
    assert "<img" not in html
