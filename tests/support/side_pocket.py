"""Alciatore's technical proof 3.5: a side pocket whose jaws are points, and shots into it."""

from __future__ import annotations

import math

from shots import ball, scene_of

from ghostball.model import Scene, Table

INCH = 0.0254

SIDE_POCKET = Table.model_validate(
    {
        "length": 2.54,
        "width": 1.27,
        "pockets": {
            "side": {
                "mouth": 5.0625 * INCH,
                "angle": math.radians(104.0),
                "jaw_radius": 1e-7,
                "depth": 0.1875 * INCH,
                "radius": 3.0 * INCH,
            }
        },
    }
)
"""Alciatore's side pocket: at more than 68.292 degrees from its axis, no ball goes in."""


def into_side_pocket(degrees: float, offset: float, *, away: float, t_max: float) -> Scene:
    """Return a shot at 1 m/s, at an angle from the pocket's axis.

    `offset` [m]: distance of the shot's line from the middle of the mouth, to the right.
    `away` [m]: distance of the start from the mouth.
    """
    sine, cosine = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    place = (1.27 + offset - away * sine, away * cosine)
    cue = ball(place, (sine, -cosine), radius=1.125 * INCH)
    return scene_of(cue, table=SIDE_POCKET, t_max=t_max, rolling_friction=0.0)
