"""Engines have permanent, distinct styles, and quantities have the right units."""

import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from ghostball.reference_adapters import engine_names
from ghostball.reports import style
from ghostball.reports.figures import draw_sheet
from ghostball.reports.shots import load_shot
from ghostball.validation.suite.suite import DEFAULT_ENGINES


def test_engines_differ_without_their_colour():
    looks = {style.engine_style(label) for label in DEFAULT_ENGINES}
    assert len({(look.colour, look.line, look.marker) for look in looks}) == len(DEFAULT_ENGINES)
    by_family: dict[str, set[object]] = {}
    for label in DEFAULT_ENGINES:
        look = style.engine_style(label)
        seen = by_family.setdefault(look.colour, set())
        assert (look.line, look.marker) not in seen
        seen.add((look.line, look.marker))


# Machado, Oliveira and Fernandes (2009), table 1, severity 1: perceived linear RGB.
SIGHT = {
    "normal": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
    "grey": [[0.2126, 0.7152, 0.0722]] * 3,
}


def lab(colour: str, sight: str) -> np.ndarray:
    """Return a colour in CIELAB (D65), as perceived with a kind of colour vision."""
    rgb = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    seen = np.clip(np.asarray(SIGHT[sight]) @ linear, 0.0, 1.0)
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    x, y, z = np.cbrt(np.asarray(to_xyz) @ seen / [0.9505, 1.0, 1.089])
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("sight", SIGHT)
def test_the_certified_engine_is_distinguished_from_every_other_one(sight):
    # A difference of 2.3 is just visible; in grey, only the lightness differs.
    certified = style.engine_style("certified")
    assert certified.colour == style.FAMILY_COLOURS["certified"]
    for family in style.FAMILY_COLOURS:
        if family == "certified":
            continue
        other = style.engine_style(family)
        distance = np.linalg.norm(lab(certified.colour, sight) - lab(other.colour, sight))
        assert distance > 8.0, family
        assert (certified.line, certified.marker) != (other.line, other.marker)


def test_variants_keep_the_colour_of_their_family():
    assert style.engine_style("pymunk:dt=1e-4").colour == style.engine_style("pymunk").colour
    assert style.engine_style("pymunk:dt=1e-4").line != style.engine_style("pymunk").line


@pytest.mark.parametrize("label", ["my_engine:simulate", "newcomer", "theirs:Engine", "a:b"])
def test_an_engine_of_a_user_is_told_from_those_that_it_is_compared_with(label):
    # Both lines must not be blue, and both markers must not be dots.
    own = style.engine_style(label)
    for other in map(style.engine_style, DEFAULT_ENGINES):
        assert own.marker != other.marker
        assert own.line != other.line
        for sight in ("normal", "protanopia", "deuteranopia", "tritanopia"):
            assert np.linalg.norm(lab(own.colour, sight) - lab(other.colour, sight)) > 8.0


def test_our_engine_and_pymunk_differ_in_colour_and_marker():
    ours, other = style.engine_style("ghostball"), style.engine_style("pymunk")
    assert ours.colour != other.colour
    assert ours.marker != other.marker


def test_every_marker_has_a_sign_for_the_page():
    labels = [*engine_names(), "newcomer", "my_engine:simulate", "a:b", "c:d", "pymunk:dt=1e-4"]
    labels += ["pymunk:dt=1e-3", "pymunk:dt=1e-2", "pymunk:iterations=3"]
    assert {style.engine_style(label).marker for label in labels} <= {*style.SIGNS}
    assert len({*style.SIGNS.values()}) == len(style.SIGNS)


def test_any_label_gets_a_look_that_is_the_same_in_every_process():
    labels = ["newcomer", "x:y=1,z=2", "", "ghostball:max_events=3", "a:b:c"]
    looks = [style.engine_style(label) for label in labels]
    assert all(look.colour.startswith("#") for look in looks)
    code = (
        "import sys, ghostball.reports; print('matplotlib' in sys.modules)\n"
        "from ghostball.reports import style\n"
        f"for label in {labels!r}: print(style.engine_style(label))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    matplotlib_is_loaded, *other = done.stdout.splitlines()
    assert other == [str(look) for look in looks]
    # The command line must not load matplotlib without drawing anything.
    assert matplotlib_is_loaded == "False"


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (3.67e-3, "m", "3.67 mm"),
        (-1e-6, "s", "-1 µs"),
        (3, "class", "millimetres"),
        (12345, "1", "12345"),
        (0.123456, "J", "0.123 J"),
        (None, "m", "–"),
    ],
)
def test_a_quantity_has_the_unit_that_suits_it(value, unit, text):
    assert style.format_quantity(value, unit) == text


def test_the_same_figure_gives_the_same_bytes(results, tmp_path):
    for name in ("first", "second"):
        with style.drawing():
            style.save_figure(draw_sheet(load_shot(results, "head-on")), tmp_path / name)
    for ending in style.FORMATS:
        first, second = (tmp_path / f"{name}.{ending}" for name in ("first", "second"))
        assert first.read_bytes() == second.read_bytes()
    assert "dc:date" not in first.read_text()


def test_a_figure_carries_what_it_was_drawn_from(results, tmp_path):
    with style.drawing():
        figure = draw_sheet(load_shot(results, "head-on"))
        png, svg = style.save_figure(figure, tmp_path / "figure", "0123abc")
    assert Image.open(png).text["Description"] == "0123abc"
    assert "<dc:description>0123abc</dc:description>" in svg.read_text()
