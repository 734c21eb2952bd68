"""Skips: work that the engine omits if a scene doesn't need it, with names and reasons.

A skip saves work and changes no result: with any skip switched off, a shot is bit-identical.
`ADVANCEMENT` is the exception, because it replaces a search for the contact time by the root of a
quadratic. With and without it, contact times agree within rounding. Grazing impacts, and impacts
that are simultaneous within rounding, may then differ.
`python -m benchmarks skips` measures and compares all skips.

The skips in `BUILT_IN` are part of how a scheduler works and can't be switched off. Other code
checks that they miss no contact: `tests/support/oracle.py` predicts every pair again at every
event, and the stress suite searches recorded motion for balls that overlap.
"""

from __future__ import annotations

import enum
from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np

from ghostball.model import Scene
from ghostball.model.errors import GhostballError

MOST_PAIRED = 60
"""Number of balls up to which a bound for every pair is faster than cells, with equal results."""

MOST_IN_MATRIX = 8_000
"""Largest number of balls for a bound for every pair: half a gigabyte of bounds."""


class Skip(enum.StrEnum):
    """Work that can be omitted; the value is its name in settings and on the command line."""

    UNDISTURBED = "undisturbed"
    RECEDING = "receding"
    OUT_OF_REACH = "out-of-reach"
    FAR_CELLS = "far-cells"
    ADVANCEMENT = "advancement"
    CUSHIONS = "cushions"
    FAR_OBSTACLES = "far-obstacles"
    RECORDS = "records"
    AIR_AND_FLIGHT = "air-and-flight"

    @property
    def leaves_out(self) -> str:
        """The omitted work, in words."""
        return _LEAVES_OUT[self]


_LEAVES_OUT = {
    Skip.UNDISTURBED: "bounds of pairs that the present event leaves alone, such as balls at rest",
    Skip.RECEDING: "pairs that can't collide with their present motion",
    Skip.OUT_OF_REACH: "pairs that can't collide before the next own event of either ball",
    Skip.FAR_CELLS: "pairs of balls in cells that aren't adjacent",
    Skip.ADVANCEMENT: "steps towards a contact, if nothing slows balls: a quadratic gives it",
    Skip.CUSHIONS: "times at which balls hit a cushion",
    Skip.FAR_OBSTACLES: "jaws, facings and holes, until a ball comes near a pocket",
    Skip.AIR_AND_FLIGHT: "motion in air, heights, contacts in space, bounces on the table",
    Skip.RECORDS: "the log of events and motions, and results from it, such as orientations",
}

BUILT_IN = frozenset((Skip.UNDISTURBED, Skip.RECEDING, Skip.OUT_OF_REACH))
"""Skips that can't be switched off."""


@dataclass(frozen=True)
class SkipUse:
    """Whether a scene's run uses a skip.

    `why`: the reason, in the scene or in the call.
    """

    skip: Skip
    used: bool
    why: str


def explain_skips(
    scene: Scene, record: str = "rest", no_skip: Iterable[str] = ()
) -> tuple[SkipUse, ...]:
    """Return every skip, and whether `simulate` uses it with these arguments.

    Raises `GhostballError` under the same conditions as `chosen_skips`.
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

    Raises `GhostballError` if a name isn't that of a skip, if the skip can't be switched off, or if
    the scene has too many balls to do without it.
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
            "engine finds no contact. Skips that can be switched off: "
            f"{', '.join(s for s in Skip if s not in BUILT_IN)}"
        )
    if scene is not None and Skip.FAR_CELLS in chosen and len(scene.balls) > MOST_IN_MATRIX:
        raise GhostballError(
            f"`no_skip` must not contain {Skip.FAR_CELLS} with more than {MOST_IN_MATRIX} balls, "
            f'got {len(scene.balls)} (scene "{scene.name}"): a bound for every pair would take '
            f"{8e-9 * len(scene.balls) ** 2:.1f} GB"
        )
    return frozenset(chosen)


def _known() -> str:
    return f"Known skips: {', '.join(Skip)}"


def has_drag(scene: Scene) -> bool:
    """Return whether air or rolling friction slows fast balls more than slow ones."""
    return scene.physics.air_drag > 0.0 or scene.physics.rolling_friction_quadratic > 0.0


def is_lean(scene: Scene) -> bool:
    """Return whether all balls stay on the cloth, with parabolas as pieces."""
    return not (has_drag(scene) or scene.physics.airborne)


def is_uniform(scene: Scene) -> bool:
    """Return whether no ball is ever slowed, so that all move uniformly between events."""
    if has_drag(scene):
        return False
    slides = scene.physics.motion == "sliding"
    slowed = scene.rolling_frictions.any() or (slides and scene.sliding_frictions.any())
    return not slowed


def has_cushions(scene: Scene) -> bool:
    """Return whether a ball may hit a cushion."""
    return scene.table is not None and scene.table.has_cushions


def has_frame(scene: Scene) -> bool:
    """Return whether all noses and holes are outside one rectangle, so inside it nothing is hit."""
    if scene.table is None or not scene.table.holes:
        return False
    reach = scene.radii
    if scene.physics.airborne:
        nose = scene.physics.cushion_height
        reach = np.sqrt(nose * (2.0 * reach - nose))
    return scene.table.has_holes_beyond(float(np.min(reach)))


def uses_cells(scene: Scene, off: Collection[Skip] = ()) -> bool:
    """Return whether the scheduler with cells is used for this scene."""
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
        return used, "the scene has no cushions" if used else "the table has cushions"
    if skip is Skip.FAR_OBSTACLES:
        if has_frame(scene):
            return True, "the table has pockets"
        if scene.table is None or not scene.table.holes:
            return False, "the table has no pockets"
        return False, "a hole reaches into the area without noses"
    if skip is Skip.AIR_AND_FLIGHT:
        if has_drag(scene):
            return False, "air, or the cloth, slows fast balls more than slow ones"
        if scene.physics.airborne:
            return False, "`airborne` is true"
        return True, "there is no air, and `airborne` is false"
    used = record == "rest"
    return used, f'`record` is "{record}"'
