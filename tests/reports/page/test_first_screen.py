"""Fails where the picture of the first screen leaves a scene out."""

import re

import pytest

from ghostball.reports.page.first_screen import engines_html
from ghostball.validation.results.store import Results


@pytest.fixture(scope="module")
def results(results_folder):
    return Results.open(results_folder)


def test_every_scene_of_an_engine_is_in_its_bar(results):
    html = str(engines_html(results))
    rows = re.findall(
        r'<tr><th scope="row">(.*?)<td class="bars"[^>]*>(.*?)</div>', html, re.DOTALL
    )
    assert len(rows) == len(results.labels)
    for label, (_, bar) in zip(results.labels, rows, strict=True):
        assert sum(map(int, re.findall(r"flex-grow:(\d+)", bar))) == len(results.scene_names), label
