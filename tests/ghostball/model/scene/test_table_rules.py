"""What is refused of polygons and of pockets: by field, rule and value."""

from __future__ import annotations

import math
from typing import Any

import pytest
from refusals import refusal_of

from ghostball.model import Table

SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
POOL = Table.PRESETS["wpa-9ft"]["pockets"]


@pytest.mark.parametrize(
    ("fields", "tells"),
    [
        ({"vertices": SQUARE[::2]}, ("`vertices`", "at least 3, got 2")),
        ({"vertices": SQUARE[::-1]}, ("`vertices`", "clockwise")),
        ({"vertices": [SQUARE[k] for k in (0, 2, 1, 3)]}, ("`vertices`", "cross itself")),
        ({"vertices": [*SQUARE[:3], SQUARE[2], SQUARE[3]]}, ("`vertices[3]`", "twice")),
        ({"vertices": [*SQUARE[:2], (2.0, 0.0), (1.5, 0.0), *SQUARE[2:]]}, ("on each other",)),
        ({"vertices": [*SQUARE[:3], (0.0, 0.0), *SQUARE[3:]]}, ("cross itself",)),
        ({"vertices": [(x + 1.0, y) for x, y in SQUARE]}, ("least x", "got 1 and 0")),
        ({"vertices": SQUARE, "length": 2.0}, ("`length`", "1 m, got 2 m", "Leave it out")),
        ({"vertices": SQUARE, "cushions": ["left"]}, ("`cushions`", "beside `vertices`")),
        ({"vertices": SQUARE, "pockets": POOL}, ("`pockets`", "beside `vertices`")),
        (
            {"vertices": SQUARE, "preset": "wpa-9ft"},
            ("`preset`", "beside `vertices`", 'got "wpa-9ft"', "Remove one of them"),
        ),
        (
            {"vertices": [(0, 0), (1, 0), (2, 0)]},
            ("`vertices`", "at least 1e-50 m along y, got 0 m", "no room", "Move a vertex"),
        ),
        ({"vertices": [(0, 0), (10**400, 0), (1, 1)]}, ("`vertices[1][0]`", "at most 1e+50")),
        ({"vertices": [(0, 0), (0, 1), (0, 2)]}, ("`vertices`", "along x, got 0 m")),
        ({"vertices": [(0, 0), (1, 1), (2, 2)]}, ("`vertices[2]`", "room between its sides")),
        ({"vertices": [(0, 0), (1, 0), (0.5, 1e-200)]}, ("`vertices`", "along y, got 1e-200 m")),
        *(
            (
                {"vertices": [*SQUARE[:2], (1.0, tiny), *SQUARE[2:]]},
                ("`vertices[2]`", "at least 1e-50 m from the one before", "got", "Leave one out"),
            )
            for tiny in (1e-51, 1e-162, 1e-170, 5e-324)
        ),
    ],
)
def test_a_polygon_that_is_none(fields, tells):
    message = refusal_of(lambda: Table(**fields))
    assert all(tell in message for tell in tells), message


def pocket(name: str, **changes: float) -> dict[str, Any]:
    return {"pockets": {**POOL, name: {**POOL[name], **changes}}}


LARGE = {name: {**shape, "radius": 0.19} for name, shape in POOL.items()}
NEAR = {"length": 0.5, "width": 0.5, "pockets": LARGE}
"""A small table with large holes."""


@pytest.mark.parametrize(
    ("fields", "tells"),
    [
        ({"cushions": ["left", "top"]}, ("`cushions`", "beside `pockets`")),
        (pocket("corner", radius=0.01, depth=0.0), ("`pockets.corner.depth`", "behind")),
        (pocket("side", radius=0.02), ("`pockets.side.radius`", "no ball passes")),
        (pocket("side", angle=2.8), ("`pockets.side`", "facings", "smaller angle")),
        (
            pocket("side", radius=0.3),
            (
                "is 0.3048 m behind",
                "1.815 rad from a mouth of 0.1286 m, meet 0.2579 m",
                "radius or",
            ),
        ),
        (pocket("side", mouth=0.03), ("from a mouth of 0.03 m, meet 0.06016 m", "larger mouth")),
        (
            pocket("corner", angle=2.9),
            ("`pockets.corner`", "2.9 rad from a mouth", "meet 0.09584 m"),
        ),
        *(
            (pocket("side", angle=angle, radius=0.7), ("side is 1.27 m", "hole of radius 0.7 m"))
            for angle in (1.8151, math.pi / 2.0)
        ),
        (pocket("corner", radius=0.7), ("`pockets.corner`", "smaller `radius`")),
        (
            pocket("side", angle=math.pi / 2.0, depth=2.0),
            ("a shelf of 2 m", "2.152 m together", "smaller `depth`"),
        ),
        (pocket("side", angle=1.5), ("`pockets.side.angle`", "from pi / 2")),
        (pocket("side", angle=104.0), ("`pockets.side.angle`", "104 degrees are 1.815")),
        (pocket("side", jaw_radius=1.5), ("`pockets`", "jaws take")),
        (pocket("side", mouth=2.4), ("`pockets`", "straight", "along the length")),
        (pocket("corner", mouth=1.8), ("`pockets`", "straight")),
        (pocket("corner", depth=-0.1), ("`pockets.corner.depth`", "at least 0")),
        (NEAR, ("`pockets`", "holes apart")),
    ],
)
def test_pockets_that_can_be_none(fields, tells):
    message = refusal_of(lambda: Table(**{"preset": "wpa-9ft", **fields}))
    assert all(tell in message for tell in tells), message


AT_MOUTH = 5.0625 * 0.0254 / 2.0
"""Half of the mouth of a side pocket [m]."""


@pytest.mark.parametrize(
    ("centre", "radius", "pocket"),
    [
        ((1.27, -0.05), 0.01, "bottom"),  # in the hole
        ((1.27, 0.0), 0.01, "bottom"),  # in the mouth
        ((1.27 + AT_MOUTH - 0.001, -0.001), 0.0001, "bottom"),  # between mouth and hole
        ((1.27, 0.019), 0.02, "bottom"),  # over the mouth
        ((0.0, 0.0), 0.005, "bottom-left"),
        ((0.05, 0.05), 0.02, "bottom-left"),
        ((2.54, 1.27), 0.001, "top-right"),
        ((1.27, 0.6), 0.7, "bottom"),
    ],
)
def test_a_post_in_a_pocket_or_over_its_mouth_is_refused(centre, radius, pocket):
    posts = [{"centre": (0.5, 0.5), "radius": 0.05}, {"centre": centre, "radius": radius}]
    message = refusal_of(lambda: Table.model_validate({"preset": "wpa-9ft", "posts": posts}))
    for tell in (
        "`posts[1]`",
        f'the pocket "{pocket}"',
        f"radius of {radius:g} m",
        "Move the post",
    ):
        assert tell in message


@pytest.mark.parametrize(
    ("centre", "radius"), [((1.27, 0.021), 0.02), ((0.6, 0.01), 0.02), ((0.06, 0.06), 0.001)]
)
def test_a_post_beside_a_pocket_or_at_a_cushion_is_accepted(centre, radius):
    Table.model_validate({"preset": "wpa-9ft", "posts": [{"centre": centre, "radius": radius}]})


def test_a_post_outside_the_table_is_refused():
    posts = [{"centre": (0.5, -0.1), "radius": 0.05}]
    message = refusal_of(lambda: Table(vertices=SQUARE, posts=posts))
    assert "`posts[0].centre` must be inside the table, got (0.5, -0.1) m" in message
