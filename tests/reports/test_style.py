"""Fails where an engine loses its colour, shares one look with another, or a unit is wrong."""

import subprocess
import sys

import pytest

from reports import style
from validation.suite import DEFAULT_ENGINES


def test_engines_differ_without_their_colour():
    looks = {style.engine_style(label) for label in DEFAULT_ENGINES}
    assert len({(look.colour, look.line, look.marker) for look in looks}) == len(DEFAULT_ENGINES)
    by_family: dict[str, set[object]] = {}
    for label in DEFAULT_ENGINES:
        look = style.engine_style(label)
        seen = by_family.setdefault(look.colour, set())
        assert (look.line, look.marker) not in seen
        seen.add((look.line, look.marker))


def test_variants_keep_the_colour_of_their_family():
    assert style.engine_style("pymunk:dt=1e-4").colour == style.engine_style("pymunk").colour
    assert style.engine_style("pymunk:dt=1e-4").line != style.engine_style("pymunk").line


@pytest.mark.parametrize("label", ["newcomer", "x:y=1,z=2", "", "ghostball:max_events=3", "a:b:c"])
def test_any_label_gets_a_look_that_is_the_same_in_every_process(label):
    look = style.engine_style(label)
    assert look.colour.startswith("#")
    code = f"from reports import style; print(style.engine_style({label!r}))"
    other = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout
    assert other.strip() == str(look)


def test_names():
    assert style.engine_name("pymunk:mode=landed") == "pymunk, landed"
    assert style.engine_name("pymunk:dt=1e-3,config=default") == "pymunk, dt=1e-3, default"


@pytest.mark.parametrize(
    ("metres", "text"),
    [
        (None, "–"),
        (0.0, "0"),
        (2.5, "2.5 m"),
        (0.25, "250 mm"),
        (0.00042, "420 µm"),
        (1e-3, "1 mm"),
        (9.996e-4, "1 mm"),
        (-0.0015, "-1.5 mm"),
        (1e-10, "100 pm"),
        (2e-10, "200 pm"),
        (785.3, "785 m"),
        (1234.4, "1234 m"),
        (0.00002, "20 µm"),
        (4e-10, "400 pm"),
        (1.5e-16, "0.15 fm"),
        (1.5e-15, "1.5 fm"),
        (1e-20, "1.0e-20 m"),
        (999.7, "1000 m"),
        (float("inf"), "inf m"),
    ],
)
def test_lengths(metres, text):
    assert style.format_length(metres) == text


def test_importing_the_package_loads_no_matplotlib():
    code = "import reports, sys; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_drawing_leaves_the_settings_of_matplotlib_alone():
    import matplotlib

    before = dict(matplotlib.rcParams)
    with style.drawing():
        assert matplotlib.rcParams["svg.hashsalt"] == "ghostball"
    assert dict(matplotlib.rcParams) == before
