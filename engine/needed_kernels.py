"""What given scenes need of the kernels, so that it can be compiled before any shot is played.

A variant leaves out what a scene doesn't need (`running.variants`). Variants can be compiled side
by side, and whoever needs one that isn't compiled yet compiles it then.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product

from ghostball.engine.library.entry import Needed
from ghostball.engine.running import driver
from ghostball.engine.running.skips import is_integrated
from ghostball.engine.running.variants import Variant, still_scene, variant_of
from ghostball.engine.sensitivity import tangent_map
from ghostball.engine.shot import MAX_EVENTS, check_request
from ghostball.model import Scene
from ghostball.model.errors import GhostballError

MANY = 3
"""Balls from which on joint impacts and sustained contact are likely: two seldom come to them."""


def kernels_of(
    scenes: Iterable[Scene], *, tangents: bool = False, contacts_from: int = 2
) -> list[Needed]:
    """Return what `scenes` need of the kernels.

    `scenes`: one that this engine can't play needs nothing.
    `tangents`: whether the kernels of the tangent map are needed too (`Result.sensitivity`).
    `contacts_from`: number of balls from which on a scene is taken to come to joint impacts or to
        sustained contact. Where one with fewer does, what it needs is compiled then.
    """
    shots: dict[Variant, None] = {}
    maps: dict[bool, None] = {}
    for scene in scenes:
        try:
            check_request(scene, "rest", MAX_EVENTS)
        except GhostballError:
            continue
        shots.setdefault(variant_of(scene, contacts=False))
        if len(scene.balls) >= contacts_from:
            shots.setdefault(variant_of(scene, contacts=True))
        if tangents and tangent_map.has_derivative(scene):
            maps.setdefault(is_integrated(scene))
    kernels = [driver.needed(variant) for variant in shots]
    return [*kernels, *(one for integrated in maps for one in tangent_map.needed(integrated))]


def warm_up(scenes: Iterable[Scene] = ()) -> None:
    """Compile or load the kernels that `scenes` need now, rather than in the first `simulate`.

    A compilation is announced. Without scenes: what a shot of one ball needs.
    """
    scenes = tuple(scenes) or (still_scene(Variant(False, False, False)),)
    for needed in kernels_of(scenes):
        needed.load()


def every_kernel() -> list[Needed]:
    """Return all kernels that a scene may need; those that take longest to compile come first.

    No law that integrates is for balls that fly.
    """
    every = (Variant(*parts) for parts in product((False, True), repeat=len(Variant._fields)))
    variants = [variant for variant in every if not (variant.integrated and variant.flight)]
    variants.sort(key=lambda variant: -sum(variant))
    maps = [tangent_map.needed(integrated) for integrated in (True, False)]
    return [*map(driver.needed, variants), *(one for each in maps for one in each)]
