"""Invalid polygons, pockets and posts are refused with field, rule and value, see the snapshots."""

from __future__ import annotations

import math
from typing import Any

import pytest
from refusals import refusal_of

from ghostball.model import Table

SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
POOL = Table.PRESETS["wpa-9ft"]["pockets"]
LARGE = {name: {**shape, "radius": 0.19} for name, shape in POOL.items()}

POLYGONS: dict[str, dict[str, Any]] = {
    "two vertices": {"vertices": SQUARE[::2]},
    "clockwise": {"vertices": SQUARE[::-1]},
    "crossing itself": {"vertices": [SQUARE[k] for k in (0, 2, 1, 3)]},
    "a vertex twice": {"vertices": [*SQUARE[:3], SQUARE[2], SQUARE[3]]},
    "sides on each other": {"vertices": [*SQUARE[:2], (2.0, 0.0), (1.5, 0.0), *SQUARE[2:]]},
    "touching itself": {"vertices": [*SQUARE[:3], (0.0, 0.0), *SQUARE[3:]]},
    "beside the origin": {"vertices": [(x + 1.0, y) for x, y in SQUARE]},
    "with a length": {"vertices": SQUARE, "length": 2.0},
    "with cushions": {"vertices": SQUARE, "cushions": ["left"]},
    "with pockets": {"vertices": SQUARE, "pockets": POOL},
    "with a preset": {"vertices": SQUARE, "preset": "wpa-9ft"},
    "flat along x": {"vertices": [(0, 0), (1, 0), (2, 0)]},
    "flat along y": {"vertices": [(0, 0), (0, 1), (0, 2)]},
    "flat aslant": {"vertices": [(0, 0), (1, 1), (2, 2)]},
    "flat but for rounding": {"vertices": [(0, 0), (1, 0), (0.5, 1e-200)]},
    "too large": {"vertices": [(0, 0), (10**400, 0), (1, 1)]},
    **{
        f"a side of {tiny}": {"vertices": [*SQUARE[:2], (1.0, tiny), *SQUARE[2:]]}
        for tiny in (1e-51, 1e-162, 1e-170, 5e-324)
    },
    "a post outside": {"vertices": SQUARE, "posts": [{"centre": (0.5, -0.1), "radius": 0.05}]},
}


def pocket(name: str, **changes: float) -> dict[str, Any]:
    return {"preset": "wpa-9ft", "pockets": {**POOL, name: {**POOL[name], **changes}}}


POCKETS = {
    "without a cushion": {"preset": "wpa-9ft", "cushions": ["left", "top"]},
    "a hole before its corner": pocket("corner", radius=0.01, depth=0.0),
    "a hole for no ball": pocket("side", radius=0.02),
    "facings that close": pocket("side", angle=2.8),
    "a hole that facings cut": pocket("side", radius=0.3),
    "a narrow mouth": pocket("side", mouth=0.03),
    "facings that meet": pocket("corner", angle=2.9),
    "a hole over half the table": pocket("side", angle=1.8151, radius=0.7),
    "a hole between parallel facings": pocket("side", angle=math.pi / 2.0, radius=0.7),
    "a large hole": pocket("corner", radius=0.7),
    "a long shelf": pocket("side", angle=math.pi / 2.0, depth=2.0),
    "facings that open": pocket("side", angle=1.5),
    "an angle in degrees": pocket("side", angle=104.0),
    "large jaws": pocket("side", jaw_radius=1.5),
    "no straight side": pocket("side", mouth=2.4),
    "no straight end": pocket("corner", mouth=1.8),
    "a hole before its mouth": pocket("corner", depth=-0.1),
    "holes in each other": {"length": 0.5, "width": 0.5, "pockets": LARGE},
}

AT_MOUTH = 5.0625 * 0.0254 / 2.0
"""Half of the mouth of a side pocket [m]."""

POSTS = {
    f"a post {where}": {
        "preset": "wpa-9ft",
        "posts": [{"centre": (0.5, 0.5), "radius": 0.05}, {"centre": centre, "radius": radius}],
    }
    for where, centre, radius in (
        ("in a hole", (1.27, -0.05), 0.01),
        ("in a mouth", (1.27, 0.0), 0.01),
        ("between mouth and hole", (1.27 + AT_MOUTH - 0.001, -0.001), 0.0001),
        ("over a mouth", (1.27, 0.019), 0.02),
        ("at a corner", (0.0, 0.0), 0.005),
        ("over a corner", (0.05, 0.05), 0.02),
        ("at the far corner", (2.54, 1.27), 0.001),
        ("over all", (1.27, 0.6), 0.7),
    )
}
REFUSED = POLYGONS | POCKETS | POSTS


@pytest.mark.parametrize("what", REFUSED)
def test_a_table_that_is_none_is_refused(what, snapshot):
    assert refusal_of(lambda: Table.model_validate(REFUSED[what])) == snapshot


@pytest.mark.parametrize(
    ("centre", "radius"), [((1.27, 0.021), 0.02), ((0.6, 0.01), 0.02), ((0.06, 0.06), 0.001)]
)
def test_a_post_beside_a_pocket_or_at_a_cushion_is_accepted(centre, radius):
    Table.model_validate({"preset": "wpa-9ft", "posts": [{"centre": centre, "radius": radius}]})
