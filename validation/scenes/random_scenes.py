"""Random scenes of everything that the engine knows, each from its number alone.

>>> random_scene(17).tags
('preset=pool', 'motion=sliding', ...)
>>> random_scene(17, air="yes", layout="corner").physics.air_drag
0.0041

A scene is one option of each aspect in `ASPECTS`. Every pair of options that can be together is
in one of any `len(PAIRS)` scenes in a row, and nearly all in a tenth as many; what else a scene has
is drawn by weight. What is drawn of an option, such as a coefficient, is in `random_parts`.
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
"""An aspect's name and what it is."""

Wanted = str | tuple[str, ...]
"""The option that a scene must have of an aspect, or several of which it must have one."""

ASPECTS: Final[Mapping[str, Mapping[str, int]]] = {
    "preset": {"paper": 1, "pool": 1, "pool-coulomb": 1, "carom": 0, "snooker": 0},
    "motion": {"rolling": 1, "sliding": 1},
    "cloth": {"slows": 3, "frictionless": 1},
    "own-friction": {"no": 3, "yes": 1},
    "spin": {"rolls": 2, "across": 1, "vertical": 2, "struck": 0},
    "restitution": {"elastic": 2, "lossy": 3, "none": 1},
    "friction": {"none": 2, "constant": 2, "alciatore": 1},
    "ball-law": {"frictional": 4, "mathavan2014": 1},
    "impacts": {"simultaneous": 3, "sequential": 1},
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
"""Every aspect: its options, each with its weight where another pair's turn doesn't choose it.

One of weight 0 is drawn where it is asked for alone, so that it changes no scene of a number.
"tangential" is the law "restitution" with a factor along the cushion, too; "falling" is any law
whose restitution falls with speed; "struck" is the spin that the stroke of a cue gives; "low" is
flight of balls that all begin on the cloth; "on-top" is a ball that lies, or falls, on another."""


def _all(aspect: str, but: str) -> tuple[Option, ...]:
    return tuple((aspect, option) for option in ASPECTS[aspect] if option != but)


_INTEGRATED = (("ball-law", "mathavan2014"), ("cushion", "mathavan2010"))
_RACKS = ("rack", "rack-at-rail", "loose-rack")
_AT_RAILS = (("layout", "rail"), ("layout", "corner"), ("layout", "rack-at-rail"))

_SHAPED = tuple(("table", shape) for shape in ("polygon", "pockets", "posts"))

_NEVER: Final[tuple[tuple[tuple[Option, ...], tuple[Option, ...]], ...]] = (
    # A ball that always rolls has the spin of its velocity, and stays on the cloth.
    (
        (("motion", "rolling"),),
        (
            *_all("spin", "rolls"),
            *_all("friction", "none"),
            *_all("flight", "no"),
            *(("cushion", law) for law in ("frictional", "han2005")),
            *_INTEGRATED,
        ),
    ),
    # What integrates over an impact holds balls on the cloth.
    (_all("flight", "no"), _INTEGRATED),
    # There is one law of cushions where there are cushions.
    ((("table", "none"),), _all("cushion", "none")),
    (_all("table", "none"), (("cushion", "none"),)),
    ((("table", "none"), ("cushion", "none")), (*_AT_RAILS, ("along-rail", "yes"))),
    # A cue's ball leaves a rail by its squirt.
    ((("spin", "struck"),), (("along-rail", "yes"),)),
    # What two balls have in common.
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
    # A triangle has no room in a narrow table; one of balls of all sizes has gaps.
    (tuple(("layout", rack) for rack in _RACKS), (("table", "narrow"),)),
    ((("layout", "rack"), ("layout", "rack-at-rail")), (("radii", "unequal"),)),
    # Rails of a table that is no plain rectangle aren't where balls are laid.
    (_SHAPED, (*_AT_RAILS, ("along-rail", "yes"))),
    # Where nothing slows balls, a run is stopped.
    ((("cloth", "frictionless"),), (("stop", "rest"),)),
)
"""Options that can't be together, each of the first with each of the second, and why."""

_FORBIDDEN: Final = frozenset(
    frozenset((one, other)) for some, others in _NEVER for one in some for other in others
)

_ASKED_FOR: Final[Mapping[tuple[str, str], frozenset[frozenset[Option]]]] = {
    (aspect, "flight"): frozenset(
        frozenset((one, other)) for one in some for other in _all("flight", "no")
    )
    for aspect, some in (("air", (("air", "yes"),)), ("table", _SHAPED))
}
"""Pairs that are together only where both aspects are asked for, so that they change no scene of a
number: what flies in air, and what flies over other tables than plain rectangles."""


def _never(wanted: Iterable[str] = ()) -> frozenset[frozenset[Option]]:
    """Return the pairs that can't be together where these aspects are asked for."""
    kept = (pairs for aspects, pairs in _ASKED_FOR.items() if not set(aspects) <= set(wanted))
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
"""Every pair of options that can be together."""

_STRIDE: Final = 719
"""Prime, and no divisor of the number of pairs: neighbours in number have little in common."""


PROVABLE: Final[Mapping[str, Wanted]] = {
    "ball_law": "frictional",
    "cushion": tuple(law for law in ASPECTS["cushion"] if law not in ("mathavan2010", "falling")),
    "count": ("one", "few"),
    "layout": "apart",
    "along_rail": "no",
    "table": ("none", "pool", "small", "open"),
    "speed": "usual",
    "air": "no",
    "quadratic": "no",
}
"""What scenes have whose proofs take no minutes, and say something of nearly all."""

_ATTEMPTS: Final = 1000
"""How often all options are chosen anew, where some that were chosen leave none for others."""


def random_scene(number: int, **having: Wanted) -> Scene:
    """Return the scene of this number: the same on every machine, and in every process.

    `having`: options that the scene must have, by aspect, "-" written as "_": `along_rail="yes"`;
    or several of which it must have one. A pair whose turn it is and that can't be with them is
    left out.

    All numbers are made of sums, products, quotients and square roots.
    """
    options = options_of(number, **having)
    # The seed is text, whose hash is the same everywhere.
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
    """Return what the scene of this number is, aspect by aspect; see `random_scene`.

    Raises `KeyError` where there is no such aspect or option; `ValueError` where what it must have
    can't be together.
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
    """Choose an option that can be with all others; return whether there is one."""
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
