"""Random scenes with all features of Ghostball's engine, each determined by its number.

>>> random_scene(17).tags
('preset=pool', 'motion=sliding', ...)
>>> random_scene(17, air="yes", layout="corner").physics.air_drag
0.0041

A scene has one option of each aspect in `ASPECTS`. Every compatible pair of options occurs in any
`len(PAIRS)` consecutive scenes, and nearly every pair in a tenth as many. The other options of a
scene are drawn by weight. `random_parts` draws the values of an option, such as a coefficient.
"""

from __future__ import annotations

import itertools
import random
from collections.abc import Iterable, Mapping
from typing import Final

from ghostball.model import Physics, Scene
from ghostball.validation.scenes.random_parts import (
    never_rests,
    physics_of,
    sizes_of,
    stop_of,
    table_of,
)
from ghostball.validation.scenes.random_places import placed

Option = tuple[str, str]
"""The name of an aspect, and an option."""

Wanted = str | tuple[str, ...]
"""The required option of an aspect, or several options of which one is required."""

ASPECTS: Final[Mapping[str, Mapping[str, int]]] = {
    "preset": {"paper": 1, "pool": 1, "pool-coulomb": 1, "carom": 0, "snooker": 0},
    "motion": {"rolling": 1, "sliding": 1},
    "cloth": {"slows": 3, "frictionless": 1},
    "own-friction": {"no": 3, "yes": 1},
    "spin": {"rolls": 2, "across": 1, "vertical": 2, "struck": 0},
    "restitution": {"elastic": 2, "lossy": 3, "none": 1},
    "friction": {"none": 2, "constant": 2, "alciatore": 1},
    "ball-law": {"frictional": 4, "mathavan2014": 1},
    "impacts": {"simultaneous": 3, "sequential": 1, "compliant": 0},
    "masses": {"equal": 2, "unequal": 1},
    "radii": {"equal": 2, "unequal": 1},
    "table": {
        "none": 1,
        "pool": 2,
        "small": 3,
        "narrow": 1,
        "open": 2,
        "polygon": 0,
        "pockets": 0,
        "posts": 0,
    },
    "cushion": {
        "none": 1,
        "mirror": 1,
        "restitution": 1,
        "tangential": 1,
        "frictional": 1,
        "han2005": 1,
        "mathavan2010": 1,
        "falling": 0,
        "stronge2000": 0,
    },
    "air": {"no": 2, "yes": 1},
    "quadratic": {"no": 3, "yes": 1},
    "flight": {"no": 5, "low": 1, "jump": 1, "drop": 1, "on-top": 1},
    "count": {"one": 1, "few": 5, "many": 1},
    "layout": {
        "apart": 3,
        "touching": 2,
        "rack": 1,
        "rail": 2,
        "corner": 1,
        "rack-at-rail": 1,
        "loose-rack": 0,
    },
    "along-rail": {"no": 3, "yes": 1},
    "speed": {"usual": 4, "slow": 1, "fast": 1},
    "stop": {"rest": 3, "t-max": 1},
}
"""Every aspect: its options, each with the weight with which it is drawn.

An option of weight 0 is drawn only on request, so adding it changed no numbered scene.
"tangential" is the law "restitution" with a tangential restitution; "falling" is a law with a
restitution that falls with speed; "struck" is the spin from the stroke of a cue; "low" is flight of
balls that all start on the cloth; "on-top" is a ball that lies on another, or falls on it.
"""


def _all(aspect: str, but: str) -> tuple[Option, ...]:
    return tuple((aspect, option) for option in ASPECTS[aspect] if option != but)


_INTEGRATED = (("ball-law", "mathavan2014"), ("cushion", "mathavan2010"))
_RACKS = ("rack", "rack-at-rail", "loose-rack")
_RAIL_LAYOUTS = (("layout", "rail"), ("layout", "corner"), ("layout", "rack-at-rail"))

_SHAPED = tuple(("table", shape) for shape in ("polygon", "pockets", "posts"))

_EXCLUSIONS: Final[tuple[tuple[tuple[Option, ...], tuple[Option, ...]], ...]] = (
    # A ball that always rolls stays on the cloth, and its velocity determines its spin.
    (
        (("motion", "rolling"),),
        (
            *_all("spin", "rolls"),
            *_all("friction", "none"),
            *_all("flight", "no"),
            *(("cushion", law) for law in ("frictional", "han2005", "stronge2000")),
            *_INTEGRATED,
        ),
    ),
    # Laws that integrate over an impact need balls on the cloth.
    (_all("flight", "no"), _INTEGRATED),
    # Compliant impacts are between balls on the cloth, and lose at most half of the speed.
    (
        (("impacts", "compliant"),),
        (
            *_all("flight", "no"),
            ("ball-law", "mathavan2014"),
            ("count", "one"),
            ("restitution", "none"),
        ),
    ),
    # A law of cushions needs cushions, and cushions need a law.
    ((("table", "none"),), _all("cushion", "none")),
    (_all("table", "none"), (("cushion", "none"),)),
    ((("table", "none"), ("cushion", "none")), (*_RAIL_LAYOUTS, ("along-rail", "yes"))),
    # Squirt makes a struck ball leave a rail.
    ((("spin", "struck"),), (("along-rail", "yes"),)),
    # Relations of two balls need two balls.
    (
        (("count", "one"),),
        (
            *_all("restitution", "elastic"),
            *_all("friction", "none"),
            *_all("masses", "equal"),
            *_all("radii", "equal"),
            *(("layout", how) for how in ("touching", *_RACKS)),
            ("ball-law", "mathavan2014"),
            ("flight", "on-top"),
        ),
    ),
    # A triangle doesn't fit on a narrow table, and with unequal balls it has gaps.
    (tuple(("layout", rack) for rack in _RACKS), (("table", "narrow"),)),
    ((("layout", "rack"), ("layout", "rack-at-rail")), (("radii", "unequal"),)),
    # Balls are placed only at the rails of rectangular tables.
    (_SHAPED, (*_RAIL_LAYOUTS, ("along-rail", "yes"))),
    # Without friction, balls never rest, so the scene needs a stopping time.
    ((("cloth", "frictionless"),), (("stop", "rest"),)),
)
"""Incompatible options: each option of the first group excludes each of the second."""

_FORBIDDEN: Final = frozenset(
    frozenset((one, other)) for some, others in _EXCLUSIONS for one in some for other in others
)

_REQUESTED_ONLY: Final[Mapping[tuple[str, str], frozenset[frozenset[Option]]]] = {
    (aspect, "flight"): frozenset(
        frozenset((one, other)) for one in some for other in _all("flight", "no")
    )
    for aspect, some in (("air", (("air", "yes"),)), ("table", _SHAPED))
}
"""Pairs that occur only if both aspects are requested, so adding them changed no numbered scene:
flight in air, and flight over tables that aren't rectangles."""


def _never(wanted: Iterable[str] = ()) -> frozenset[frozenset[Option]]:
    """Return the pairs that can't occur together if these aspects are requested."""
    kept = (pairs for aspects, pairs in _REQUESTED_ONLY.items() if not set(aspects) <= set(wanted))
    return _FORBIDDEN.union(*kept)


PAIRS: Final[tuple[tuple[Option, Option], ...]] = tuple(
    (one, other)
    for one, other in itertools.combinations(
        [
            (aspect, option)
            for aspect, options in ASPECTS.items()
            for option, weight in options.items()
            if weight
        ],
        2,
    )
    if one[0] != other[0] and frozenset((one, other)) not in _never()
)
"""Every pair of compatible options."""

_STRIDE: Final = 719
"""A prime that doesn't divide the number of pairs: consecutive scenes have little in common."""


PROVABLE: Final[Mapping[str, Wanted]] = {
    "ball_law": "frictional",
    "cushion": tuple(
        law for law in ASPECTS["cushion"] if law not in ("mathavan2010", "stronge2000", "falling")
    ),
    "count": ("one", "few"),
    "layout": "apart",
    "along_rail": "no",
    "table": ("none", "pool", "small", "open"),
    "speed": "usual",
    "air": "no",
    "quadratic": "no",
}
"""Options of scenes that can be certified in seconds, most of them to their end."""

_ATTEMPTS: Final = 1000
"""Number of attempts to draw all options, in case some options leave none for an aspect."""


def random_scene(number: int, **having: Wanted) -> Scene:
    """Return the scene with a number: the same on every machine, and in every process.

    `having`: required options, by aspect, with "_" for "-": `along_rail="yes"`; or several options
        of which one is required. The pair of the number is ignored if it is incompatible with them.

    All values are computed by sums, products, quotients and square roots.
    """
    options = options_of(number, **having)
    # The seed is text, because its hash is the same everywhere.
    chance = random.Random(f"ghostball scene {number} {sorted(having.items())}")
    sizes = sizes_of(chance, options)
    physics = physics_of(chance, options, sizes)
    table = table_of(chance, options, sizes, physics)
    balls = placed(chance, options, sizes, table, physics)
    if never_rests(options, physics):
        options["stop"] = "t-max"
    return Scene(
        name=f"random-{number}",
        title=f"Random scene {number}",
        tags=[f"{aspect}={option}" for aspect, option in options.items()],
        table=table,
        physics=Physics(**physics),
        t_max=stop_of(chance, options, balls) if options["stop"] == "t-max" else None,
        balls=balls,
    )


def options_of(number: int, **having: Wanted) -> dict[str, str]:
    """Return the options of the scene with a number, by aspect; see `random_scene`.

    Raises `KeyError` for an unknown aspect or option; `ValueError` if the required options are
    incompatible.
    """
    wanted = {
        aspect.replace("_", "-"): (option,) if isinstance(option, str) else option
        for aspect, option in having.items()
    }
    weights: dict[str, Mapping[str, int]] = {
        aspect: {option: ASPECTS[aspect][option] or 1 for option in options}
        for aspect, options in wanted.items()
    }
    weights = {**ASPECTS, **weights}
    asked = {aspect: options[0] for aspect, options in wanted.items() if len(options) == 1}
    never = _never(wanted)
    chance = random.Random(f"ghostball options {number} {sorted(having.items())}")
    pair = dict(PAIRS[number * _STRIDE % len(PAIRS)])
    for first in ({**pair, **asked}, asked):
        if not _can_be(first, never) or not all(
            first[aspect] in weights[aspect] for aspect in first
        ):
            continue
        for _ in range(_ATTEMPTS):
            found = dict(first)
            aspects = [aspect for aspect in ASPECTS if aspect not in first]
            chance.shuffle(aspects)
            if all(_choose(chance, found, aspect, weights[aspect], never) for aspect in aspects):
                return {aspect: found[aspect] for aspect in ASPECTS}
    raise ValueError(f"no scene has all of {wanted}")


def _choose(
    chance: random.Random,
    found: dict[str, str],
    aspect: str,
    weights: Mapping[str, int],
    never: frozenset[frozenset[Option]],
) -> bool:
    """Choose an option that is compatible with those in `found`; return False if there is none."""
    options = [
        option
        for option, weight in weights.items()
        if weight
        and all(frozenset(((aspect, option), other)) not in never for other in found.items())
    ]
    if options:
        found[aspect] = chance.choices(options, [weights[option] for option in options])[0]
    return bool(options)


def _can_be(options: Mapping[str, str], never: frozenset[frozenset[Option]]) -> bool:
    pairs = itertools.combinations(options.items(), 2)
    return not any(frozenset(pair) in never for pair in pairs)
