"""The parts of random scenes: sizes of balls, tables, coefficients; see `random_scenes`.

Sizes over many magnitudes are drawn as a number in [1, 2) times a power of two, which is exact;
other powers differ between machines.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from typing import Any, Final

from ghostball.model import CUSHIONS, POOL_BALL_MASS, POOL_BALL_RADIUS, Ball, Physics, Table
from ghostball.model.impact_laws import any_integrated
from ghostball.model.scene.physics import LEAST_RESTITUTION

Options = Mapping[str, str]
Draft = dict[str, Any]
"""Fields of a ball."""

TABLES: Final = {
    "pool": Table(length=2.54, width=1.27),
    "small": Table(length=0.8, width=0.5),
    "open": Table(length=1.2, width=0.7),
}

_POLYGONS: Final = (
    ((0.0, 0.0), (1.2, 0.0), (1.2, 0.5), (0.7, 0.5), (0.7, 1.0), (0.0, 1.0)),  # an L
    ((0.0, 0.0), (1.25, 0.0), (0.5, 1.0)),
    ((0.25, 0.0), (1.0, 0.0), (1.3, 0.45), (1.0, 0.9), (0.25, 0.9), (0.0, 0.45)),
    ((0.0, 0.0), (0.6, 0.2), (1.2, 0.0), (1.2, 0.8), (0.6, 0.55), (0.0, 0.8)),  # with a waist
)
"""Polygonal tables, with acute corners and with corners that point into the table [m]."""

_POCKETED: Final = (
    "wpa-9ft",
    "bar-7ft",
    "snooker-12ft",
    {"preset": "wpa-9ft", "length": 1.0, "width": 0.6},
    {"preset": "bar-7ft", "pockets": {"side": Table.PRESETS["wpa-9ft"]["pockets"]["side"]}},
)
"""Tables with pockets: one is small, one has wide side pockets."""

UNBOUNDED_SIZE: Final = (1.2, 0.7)
"""Region of the balls on an unbounded cloth [m]."""

_NARROW_LENGTH: Final = 2.5
"""Length of a narrow table [m]."""

_TIMED_PATH: Final = 4.0
"""Path of the fastest ball until a scene with a time limit stops [m]: some tens of collisions."""


def sizes_of(chance: random.Random, options: Options) -> list[Draft]:
    """Return the balls, with their radii, masses and individual frictions.

    If radii or masses are unequal, the first ball differs from the second.
    """
    least = 4 if "rack" in options["layout"] else 2
    count = {"one": 1, "few": chance.randint(least, 5), "many": chance.choice((7, 11, 16))}
    balls: list[Draft] = []
    for k in range(count[options["count"]]):
        ball: Draft = {"id": f"b{k}", "radius": POOL_BALL_RADIUS, "mass": POOL_BALL_MASS}
        if options["radii"] == "unequal":
            ball["radius"] *= chance.uniform(0.75, 1.4)
        if options["masses"] == "unequal":
            ball["mass"] *= sized(chance, -2, 1)
        if options["own-friction"] == "yes" and (k == 0 or chance.random() < 0.5):
            ball["rolling_friction"] = chance.uniform(0.004, 0.05)
            if options["motion"] == "sliding" and chance.random() < 0.5:
                ball["sliding_friction"] = chance.uniform(0.1, 0.5)
                ball["spinning_friction_rate"] = chance.uniform(2.0, 30.0)
        balls.append(ball)
    if options["own-friction"] == "yes" and options["cloth"] == "frictionless":
        balls[0]["rolling_friction"] = 0.0
    return balls


def physics_of(chance: random.Random, options: Options, sizes: list[Draft]) -> Draft:
    """Return the fields of the physics; the preset gives the other coefficients."""
    law = _law_of(chance, options)
    own = options["own-friction"] == "yes"
    physics: Draft = {
        "preset": options["preset"],
        "motion": options["motion"],
        "rolling_friction": chance.choice((0.005, 0.01, 0.02, chance.uniform(0.003, 0.1))),
        "impacts": options["impacts"],
        "ball_impact": options["ball-law"],
        "ball_restitution": max(
            LEAST_RESTITUTION if options["impacts"] == "compliant" else 0.0,
            {
                "elastic": 1.0,
                "lossy": chance.choice((0.95, chance.uniform(0.2, 0.99))),
                "none": 0.0,
            }[options["restitution"]],
        ),
        "ball_friction": {
            "none": 0.0,
            "constant": chance.choice((0.06, chance.uniform(0.01, 0.3))),
            "alciatore": "alciatore",
        }[options["friction"]],
    }
    if options["cloth"] == "frictionless" and not own:
        physics["rolling_friction"] = 0.0
        if chance.random() < 0.5:
            physics["sliding_friction"] = physics["spinning_friction_rate"] = 0.0
    elif chance.random() < 0.5:
        physics["sliding_friction"] = chance.uniform(0.1, 0.5)
        physics["spinning_friction_rate"] = chance.uniform(2.0, 30.0)
    if law != "none":
        physics["cushion"] = "restitution" if law == "tangential" else law
    constants: Draft = {}
    if law not in ("none", "mirror"):
        constants["cushion_restitution"] = chance.choice((1.0, chance.uniform(0.3, 1.0)))
    if law in ("frictional", "han2005", "mathavan2010", "stronge2000"):
        constants["cushion_friction"] = chance.uniform(0.0, 0.4)
    if chance.random() < 0.5:
        physics |= constants
    if options["cushion"] == "falling":
        physics["cushion_restitution_loss"] = chance.choice((0.15, sized(chance, -3, 0)))
    if law == "tangential":
        physics["cushion_tangential_restitution"] = chance.uniform(0.3, 0.99)
    flies = options["flight"] != "no"
    if law == "stronge2000":
        physics["cushion_frequency_ratio"] = chance.choice((1.76, chance.uniform(1.01, 1.99)))
    if law in ("han2005", "mathavan2010", "stronge2000") or (flies and law != "none"):
        least = min(ball["radius"] for ball in sizes)
        physics["cushion_height"] = least * chance.choice((1.0, 1.25, chance.uniform(1.0, 1.4)))
    if options["air"] == "yes":
        physics["air_drag"] = chance.choice((0.0041, 0.1, sized(chance, -10, 0)))
    if options["quadratic"] == "yes":
        physics["rolling_friction_quadratic"] = chance.choice((0.0039, sized(chance, -10, -3)))
    if flies:
        physics["airborne"] = True
        lasts = 1.0 if options["stop"] == "t-max" else 0.9
        returned = chance.choice((0.0, 0.5, lasts, chance.uniform(0.0, 0.95)))
        physics["table_restitution"] = returned
    return {**_not_asked_for(options), **physics}


def _not_asked_for(options: Options) -> Draft:
    """Return fields that switch off features of a preset that the scene doesn't have as options."""
    preset = Physics.PRESETS[options["preset"]]
    without: Draft = {}
    for field in ("rolling_friction_quadratic", "cushion_restitution_loss"):
        if field in preset:
            without[field] = 0.0
    # keeps balls on the cloth, even on a table without cushions
    if any_integrated(preset.get("cushion", "")):
        without["cushion"] = "mirror"
    return without


def _law_of(chance: random.Random, options: Options) -> str:
    """Return the law of cushions; for "falling", a law whose restitution may fall with speed."""
    if options["cushion"] != "falling":
        return options["cushion"]
    if options["motion"] == "rolling":
        return "restitution"
    laws = ["restitution", "frictional", "han2005"]
    return chance.choice(laws if options["flight"] != "no" else [*laws, "mathavan2010"])


def stop_of(chance: random.Random, options: Options, balls: list[Ball]) -> float:
    """Return when to stop [s]: after a path of the fastest ball, but within seconds if balls fly.

    If all balls are at rest, any time will do.
    """
    fastest = max(ball.speed for ball in balls)
    lasts = _TIMED_PATH / fastest if fastest > 0.0 else 1.0
    return chance.uniform(0.2, 1.0) * (lasts if options["flight"] == "no" else min(lasts, 4.0))


def never_rests(options: Options, physics: Draft) -> bool:
    """Return True if a ball may bounce forever: in the air, between two lossless cushions."""
    between = options["flight"] != "no" and options["table"] == "narrow"
    return between and _is_elastic(options, physics)


def _is_elastic(options: Options, physics: Draft) -> bool:
    """Return True if cushions conserve the normal speed."""
    preset = Physics.PRESETS[options["preset"]]
    returned = {**preset, **physics}.get("cushion_restitution", 1.0)
    return options["cushion"] == "mirror" or returned == 1.0


def table_of(
    chance: random.Random, options: Options, sizes: list[Draft], physics: Draft
) -> Table | None:
    """Return the table; a narrow one is about as wide as the largest ball.

    If balls fly or cushions are elastic, it is wider than the ball: without a gap, a ball bounces
    forever between the cushions and the run stops early, which separate tests cover.
    """
    kind = options["table"]
    if kind == "none":
        return chance.choice(
            (None, Table(length=UNBOUNDED_SIZE[0], width=UNBOUNDED_SIZE[1], cushions=()))
        )
    if kind == "narrow":
        flies = options["flight"] != "no"  # its equator may touch the noses
        widest = 2.0 * max(ball["radius"] if flies else reach(ball, physics) for ball in sizes)
        least = 0.125 if flies or _is_elastic(options, physics) else 0.0
        return Table(
            length=_NARROW_LENGTH, width=widest * (1.0 + chance.choice((least, 0.0625, 0.5)))
        )
    if kind == "polygon":
        return Table.model_validate({"vertices": chance.choice(_POLYGONS)})
    if kind == "pockets":
        return Table.model_validate(chance.choice(_POCKETED))
    if kind == "posts":
        return _posts_on(chance, sizes)
    if kind == "open":
        sides = ["left", "bottom"] if options["layout"] == "corner" else []
        others = [name for name in CUSHIONS if name not in sides]
        sides += chance.sample(others, chance.randint(0 if sides else 1, 3 - len(sides)))
        return TABLES["open"].model_copy(update={"cushions": tuple(sides)})
    return TABLES[kind]


def _posts_on(chance: random.Random, sizes: list[Draft]) -> Table:
    """Return a small table with one to three posts; a ball fits between them, or just fits."""
    small = TABLES["small"]
    widest = 2.0 * max(ball["radius"] for ball in sizes)
    first = (chance.uniform(0.35, 0.5) * small.length, chance.uniform(0.4, 0.6) * small.width)
    posts: list[Draft] = [{"centre": first, "radius": sized(chance, -7, -5)}]
    for k in range(chance.randint(0, 2)):
        radius = sized(chance, -7, -5)
        apart = posts[0]["radius"] + radius + widest * chance.choice((1.0625, 1.5))
        sign = 1.0 if k else -1.0
        posts.append({"centre": (first[0] + sign * apart, first[1]), "radius": radius})
    return Table.model_validate({"length": small.length, "width": small.width, "posts": posts})


def reach(ball: Draft, physics: Draft) -> float:
    """Return the distance of a ball's centre from a cushion that it touches, on the cloth [m]."""
    radius: float = ball["radius"]
    if not physics.get("airborne") or "cushion_height" not in physics:
        return radius
    above = radius - physics["cushion_height"]
    return math.sqrt(radius * radius - above * above)


def sized(chance: random.Random, least: int, most: int) -> float:
    """Return a number in [2^least, 2^(most + 1)), with a uniform binary exponent."""
    return math.ldexp(chance.uniform(1.0, 2.0), chance.randint(least, most))
