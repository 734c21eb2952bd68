"""The skips, work that the engine leaves out where a scene doesn't need it: by name, and why.

A skip saves work and changes nothing: with any of them off, a shot comes out the same to the bit.
`ADVANCEMENT` alone is no work left out but another formula, a quadratic's root where others search
for it: contact times agree to within rounding, after which impacts that graze, or that tie but for
it, may go another way.
`python -m benchmarks skips` measures and compares each.

Those in `BUILT_IN` are how a scheduler works, so that the engine can't do without them. That they
miss no contact is shown from outside: `tests/support/oracle.py` predicts every pair anew at every
event, and the stress suite looks for balls that overlap in what the engine recorded.
"""

from __future__ import annotations

import enum
from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np

from ghostball.model import Scene
from ghostball.model.errors import GhostballError

MOST_PAIRED = 60
"""Balls up to which a bound for every pair is faster than cells; the results are the same."""

MOST_IN_MATRIX = 8_000
"""Balls up to which a bound for every pair may be asked for: half a gigabyte of them."""


class Skip(enum.StrEnum):
    """What can be left out; the value is its name in settings and on the command line."""

    UNDISTURBED = "undisturbed"
    RECEDING = "receding"
    OUT_OF_REACH = "out-of-reach"
    FAR_CELLS = "far-cells"
    ADVANCEMENT = "advancement"
    CUSHIONS = "cushions"
    FAR_OBSTACLES = "far-obstacles"
    BALL_FRICTION = "ball-friction"
    RECORDS = "records"
    AIR_AND_FLIGHT = "air-and-flight"

    @property
    def leaves_out(self) -> str:
        """What isn't done."""
        return _LEAVES_OUT[self]


_LEAVES_OUT = {
    Skip.UNDISTURBED: "bounds of pairs that the event at hand didn't touch, such as balls at rest",
    Skip.RECEDING: "pairs that can't meet as they move now",
    Skip.OUT_OF_REACH: "pairs that couldn't meet before either's own next event",
    Skip.FAR_CELLS: "pairs of balls whose cells don't adjoin",
    Skip.ADVANCEMENT: "the steps towards a contact: where nothing slows, a quadratic gives it",
    Skip.CUSHIONS: "when a ball meets a cushion",
    Skip.FAR_OBSTACLES: "jaws, facings and holes, until a ball comes near a pocket",
    Skip.BALL_FRICTION: "slip and friction between two balls",
    Skip.AIR_AND_FLIGHT: "motion that air bends, heights, contacts in space, bounces on the table",
    Skip.RECORDS: "the log of events and motions, and what is made of one, such as orientations",
}

BUILT_IN = frozenset((Skip.UNDISTURBED, Skip.RECEDING, Skip.OUT_OF_REACH))
"""Skips that can't be switched off."""


@dataclass(frozen=True)
class SkipUse:
    """Whether a scene's run makes use of a skip.

    `why`: what in the scene, or in the call, decides that.
    """

    skip: Skip
    used: bool
    why: str


def explain_skips(
    scene: Scene, record: str = "rest", no_skip: Iterable[str] = ()
) -> tuple[SkipUse, ...]:
    """Return every skip, and whether `simulate` uses it with these arguments.

    Raises `GhostballError` as `chosen_skips`.
    """
    off = chosen_skips(no_skip, scene)
    return tuple(
        SkipUse(skip, False, "switched off")
        if skip in off
        else SkipUse(skip, *_use_of(skip, scene, record, off))
        for skip in Skip
    )


def chosen_skips(names: Iterable[str], scene: Scene | None = None) -> frozenset[Skip]:
    """Return the skips that `names` switch off.

    Raises `GhostballError` where a name is none of a skip, or of one that can't be switched off; or
    where the scene has too many balls for what is asked.
    """
    if isinstance(names, str) or not isinstance(names, Iterable):
        raise GhostballError(f"`no_skip` must be a collection of names, got {names!r}. {_known()}")
    chosen = set()
    for name in names:
        try:
            chosen.add(Skip(name))
        except ValueError:
            raise GhostballError(f"`no_skip` must name skips, got {name!r}. {_known()}") from None
    if chosen & BUILT_IN:
        raise GhostballError(
            f"`no_skip` can't switch off {', '.join(sorted(chosen & BUILT_IN))}: without it the "
            f"engine finds no contact. It can: {', '.join(s for s in Skip if s not in BUILT_IN)}"
        )
    if scene is not None and Skip.FAR_CELLS in chosen and len(scene.balls) > MOST_IN_MATRIX:
        raise GhostballError(
            f"`no_skip` must leave {Skip.FAR_CELLS} alone with more than {MOST_IN_MATRIX} balls, "
            f'got {len(scene.balls)} (scene "{scene.name}"): a bound for every pair would take '
            f"{8e-9 * len(scene.balls) ** 2:.1f} GB"
        )
    return frozenset(chosen)


def _known() -> str:
    return f"Known skips: {', '.join(Skip)}"


def has_drag(scene: Scene) -> bool:
    """Whether balls are slowed by more the faster they are."""
    return scene.physics.air_drag > 0.0 or scene.physics.rolling_friction_quadratic > 0.0


def is_lean(scene: Scene) -> bool:
    """Whether all balls stay on the cloth, on pieces that are parabolas."""
    return not (has_drag(scene) or scene.physics.airborne)


def is_uniform(scene: Scene) -> bool:
    """Whether no ball is ever slowed, so that all move uniformly between events."""
    if has_drag(scene):
        return False
    slides = scene.physics.motion == "sliding"
    slowed = scene.rolling_frictions.any() or (slides and scene.sliding_frictions.any())
    return not slowed


def has_cushions(scene: Scene) -> bool:
    """Whether a ball may meet a cushion."""
    return scene.table is not None and scene.table.has_cushions


def has_frame(scene: Scene) -> bool:
    """Whether a ball that touches no nose is in no hole: then both are beyond one rectangle."""
    if scene.table is None or not scene.table.holes:
        return False
    reach = scene.radii
    if scene.physics.airborne:
        nose = scene.physics.cushion_height
        reach = np.sqrt(nose * (2.0 * reach - nose))
    return scene.table.has_holes_beyond(float(np.min(reach)))


def balls_rub(scene: Scene) -> bool:
    """Whether there is friction between balls."""
    return scene.physics.ball_friction != 0.0


def uses_cells(scene: Scene, off: Collection[Skip] = ()) -> bool:
    """Whether cells schedule this scene's impacts, instead of a bound for every pair."""
    return len(scene.balls) > MOST_PAIRED and Skip.FAR_CELLS not in off


def _use_of(skip: Skip, scene: Scene, record: str, off: Collection[Skip]) -> tuple[bool, str]:
    """Return whether a skip that isn't switched off is used, and why."""
    n = len(scene.balls)
    if skip in BUILT_IN:
        return n > 1, f"{n} balls" if n > 1 else "there is one ball"
    if skip is Skip.FAR_CELLS:
        if uses_cells(scene, off):
            return True, f"{n} balls, more than {MOST_PAIRED}"
        return False, f"up to {MOST_PAIRED} balls a bound for every pair is faster; here {n}"
    if skip is Skip.ADVANCEMENT:
        used = is_uniform(scene)
        return used, "nothing slows a ball" if used else "friction slows balls"
    if skip is Skip.CUSHIONS:
        used = not has_cushions(scene)
        return used, "the scene has none" if used else "the table has some"
    if skip is Skip.FAR_OBSTACLES:
        if has_frame(scene):
            return True, "the table has pockets"
        if scene.table is None or not scene.table.holes:
            return False, "the table has no pockets"
        return False, "a hole reaches to where a ball touches no nose"
    if skip is Skip.BALL_FRICTION:
        used = not balls_rub(scene)
        return used, "`ball_friction` is 0" if used else "`ball_friction` isn't 0"
    if skip is Skip.AIR_AND_FLIGHT:
        if has_drag(scene):
            return False, "air, or the cloth, slows fast balls by more"
        if scene.physics.airborne:
            return False, "`airborne` is true"
        return True, "there is no air, and `airborne` is false"
    used = record == "rest"
    return used, f'`record` is "{record}"'
