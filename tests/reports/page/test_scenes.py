"""Fails where a scene lacks its part of the page, or a part of it."""

import json
import re

import numpy as np
import pytest
from stored_records import change_motion

from ghostball.reports.page import scene_part
from ghostball.reports.shots import load_shot
from ghostball.validation.results.store import Results

# The page needs no figure.
pytestmark = pytest.mark.usefixtures("without_run_figures")


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


@pytest.mark.parametrize("label", ["ghostball", "pymunk"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_an_engine_that_blew_up_does_not_break_the_page(small_folder, label, bad):
    def blown_up(values):
        return np.where(np.arange(len(values)) < len(values) // 2, values.T, bad).T

    names = ("positions", "velocities", "angular_velocities")
    energies = ("energy_translation", "energy_rotation", "energy_height")
    change_motion(small_folder, "stop", label, **dict.fromkeys(names + energies, blown_up))
    # The scene's part alone: the figures of the report have tests of their own.
    html = scene_part(load_shot(Results.open(small_folder), "stop")).html
    assert "nan" not in "".join(re.findall(r'<path[^>]* d="([^"]*)"', html))
    assert "Energy of all balls against time" in html
