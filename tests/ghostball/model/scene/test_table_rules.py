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
