"""Pictures of scenes and results in notebooks."""

import re
import subprocess
import sys
from xml.etree import ElementTree

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import Ball, Scene, Table
from ghostball.reports.notebook import picture

SVG = "{http://www.w3.org/2000/svg}"
BALLS = [
    Ball(id="<cue>", position=(0.6, 0.4), velocity=(1.0, 0.5)),
    Ball(id="object", position=(1.2, 0.7)),
]
SCENE = Scene(name="shot", title="A & B", table=Table(length=2.54, width=1.27), balls=BALLS)


def drawn(text, tag):
    return list(ElementTree.fromstring(text).iter(SVG + tag))


def centres(text):
    return [(float(c.get("cx")), float(c.get("cy"))) for c in drawn(text, "circle")]


def test_a_scene_shows_its_balls_by_name_and_where_they_are_going():
    text = SCENE._repr_svg_()
    assert [name.text for name in drawn(text, "text")] == ["<cue>", "object"]
    assert drawn(text, "title")[0].text == "A & B"
    assert len(centres(text)) == 2
    aim = drawn(text, "polyline")[0].get("points").split()
    (x1, y1), (x2, y2) = (map(float, point.split(",")) for point in aim)
    assert (y1 - y2) / (x2 - x1) == pytest.approx(0.5, abs=0.01)  # y points up


@pytest.mark.parametrize("record", ["rest", "events", "trajectory"])
def test_a_result_shows_where_balls_began_and_ended(record):
    result = simulate(SCENE, record=record)
    html = result._repr_html_()
    text = re.search(r"<svg.*</svg>", html, re.DOTALL)[0]
    began_and_ended = centres(text)
    assert len(began_and_ended) == 4
    assert began_and_ended[::2] == centres(SCENE._repr_svg_())
    points = drawn(text, "polyline")[0].get("points").split()
    assert len(points) > 200 or record != "trajectory"
    assert points[-1] == "{:.1f},{:.1f}".format(*began_and_ended[1])
    assert f"t = {result.rest_time:.6g} s" in html


def test_without_a_table_all_that_moved_is_in_the_picture():
    scene = Scene(name="free", balls=BALLS)
    ends = scene.positions[np.newaxis] + np.array([[[3.0, -2.0, 0.0], [0.0, 0.0, 0.0]]])
    svg = ElementTree.fromstring(picture(scene, ends))
    width, height = float(svg.get("width")), float(svg.get("height"))
    assert max(width, height) == 640
    assert all(0 < x < width and 0 < y < height for x, y in centres(picture(scene, ends)))


def test_what_is_not_finite_is_left_out():
    ends = SCENE.positions[np.newaxis] * [[[np.nan], [1.0]]]
    assert "nan" not in picture(SCENE, ends)
    assert len(centres(picture(SCENE, ends))) == 4


@pytest.mark.parametrize(("first", "drawn"), [("IPython", "True"), ("json", "False")])
def test_a_notebook_has_the_pictures_from_the_start_and_a_program_loads_none(first, drawn):
    # IPython needn't be installed; a loaded module of this name is enough.
    code = (
        f"import sys, types; sys.modules.setdefault({first!r}, types.ModuleType({first!r}))\n"
        "from ghostball import Ball, Scene\n"
        "print(Scene(name='a', balls=[Ball(id='b', position=(0, 0))])._repr_svg_() is not None)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == [drawn]
